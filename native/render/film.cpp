// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/film.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
// What Blender and Cycles write where a ray meets nothing.
static constexpr float background_depth_m = 1e10f;

Pass pass_named(std::string_view name) {
    std::string names;
    for (std::size_t index = 0; index < pass_count; ++index) {
        if (pass_layouts[index].name == name)
            return static_cast<Pass>(index);
        names += index == 0 ? "" : ", ";
        names += pass_layouts[index].name;
    }
    refuse("there is no pass \"", name, "\"; there are: ", names);
}

const Plane* Film::find(Pass pass) const {
    const auto plane = std::find_if(planes.begin(), planes.end(), [&](const Plane& p) { return p.pass == pass; });
    return plane == planes.end() ? nullptr : &*plane;
}

FilmSums::FilmSums(std::uint32_t width_px, std::uint32_t height_px, const PassSet& passes, const dvec3& origin_in_world,
                   CatcherFilm catchers)
    : width_px_(width_px), height_px_(height_px), origin_in_world_(origin_in_world), catchers_(catchers) {
    for (std::size_t index = 0; index < pass_count; ++index)
        if (passes.has(static_cast<Pass>(index))) {
            offsets_[index] = stride_;
            stride_ += pass_layouts[index].channel_count;
        }
    if (passes.has(Pass::Shadow)) {
        shadow_weight_offset_ = stride_;
        stride_ += 3;
    }
    const std::size_t pixel_count = std::size_t{width_px} * height_px;
    sums_.resize(pixel_count * stride_);
    sample_counts_.resize(pixel_count);
    if (catchers != CatcherFilm::None)
        caught_.resize(pixel_count);
}

/// Light beyond all measure, of shaders that multiply it without end, is none: it would make its pixel's mean no number.
static float sound(float x) {
    constexpr float beyond_measure = 1e30f;
    return std::abs(x) <= beyond_measure ? x : 0.0f;
}

void FilmSums::add_colour(std::size_t pixel, Pass pass, const Rgb& colour) {
    if (!wants(pass))
        return;
    float* sum = channels(pixel, pass);
    sum[0] += sound(colour.x);
    sum[1] += sound(colour.y);
    sum[2] += sound(colour.z);
}

void FilmSums::add_paths(std::size_t pixel, const LightPaths& paths) {
    const auto& [direct, indirect, environment, glossy_colour, transmission_colour] = paths;
    add_colour(pixel, Pass::DiffuseDirect, direct[0]);
    add_colour(pixel, Pass::DiffuseIndirect, indirect[0]);
    add_colour(pixel, Pass::GlossyDirect, direct[1]);
    add_colour(pixel, Pass::GlossyIndirect, indirect[1]);
    add_colour(pixel, Pass::TransmissionDirect, direct[2]);
    add_colour(pixel, Pass::TransmissionIndirect, indirect[2]);
    add_colour(pixel, Pass::Environment, environment);
    add_colour(pixel, Pass::GlossyColour, glossy_colour);
    add_colour(pixel, Pass::TransmissionColour, transmission_colour);
}

void FilmSums::add(std::size_t pixel, const PathSample& sample) {
    ++sample_counts_[pixel];
    add_colour(pixel, Pass::Combined, sample.radiance);
    // Below 0 behind a surface that gives more than it meets; as in Cycles.
    channels(pixel, Pass::Combined)[3] += std::clamp(sample.alpha, 0.0f, 1.0f);
    if (!caught_.empty())
        caught_[pixel] += *sample.caught;
    add_colour(pixel, Pass::Normal, sample.normal);
    add_colour(pixel, Pass::DiffuseColour, sample.diffuse_colour);
    add_colour(pixel, Pass::Emission, sample.emission);
    add_colour(pixel, Pass::Transmittance, sample.transmittance);
    add_colour(pixel, Pass::AmbientOcclusion, sample.ambient);
    add_colour(pixel, Pass::Unshadowed, sample.unshadowed);
    if (sample.paths != nullptr)
        add_paths(pixel, *sample.paths);
    if (wants(Pass::Shadow)) {
        add_colour(pixel, Pass::Shadow, sample.lit);
        float* weight = &sums_[pixel * stride_ + shadow_weight_offset_];
        for (int channel = 0; channel < 3; ++channel)
            weight[channel] += sample.unshadowed[channel];
    }
}

void FilmSums::set_place(std::size_t pixel, float depth_m, const vec3& position) {
    if (wants(Pass::Depth))
        *channels(pixel, Pass::Depth) = depth_m;
    if (depth_m > 0.0f)
        add_colour(pixel, Pass::Position, vec3(dvec3(position) + origin_in_world_));
}

void FilmSums::add_shafts(std::size_t pixel, const Rgb& radiance, float visibility) {
    add_colour(pixel, Pass::Combined, radiance);
    add_colour(pixel, Pass::Shafts, radiance);
    if (wants(Pass::ShaftsVisibility))
        *channels(pixel, Pass::ShaftsVisibility) += visibility;
}

float FilmSums::resolved(std::size_t pixel, Pass pass, std::uint32_t channel) const {
    const std::uint32_t count = sample_counts_[pixel];
    const float sum = sums_[pixel * stride_ + *offsets_[static_cast<std::size_t>(pass)] + channel];
    switch (pass) {
    case Pass::Depth:
        return sum == 0.0f && count > 0 ? background_depth_m : sum;
    case Pass::Position:
        return sum;
    case Pass::Shadow: {
        const float unshadowed = sums_[pixel * stride_ + shadow_weight_offset_ + channel];
        return unshadowed > 0.0f ? sum / unshadowed : 0.0f;
    }
    default:
        return count > 0 ? sum / static_cast<float>(count) : 0.0f;
    }
}

vec4 FilmSums::caught_colour(std::size_t pixel) const {
    const CaughtLight& caught = caught_[pixel];
    if (!(caught.weight > 0.0f) || wants(Pass::ShadowCatcher)) // then whoever composes has the shadows apart
        return vec4(0.0f);
    const float kept = caught.kept_as_seen(), per_sample = 1.0f / static_cast<float>(sample_counts_[pixel]);
    if (catchers_ == CatcherFilm::World)
        return {caught.backdrop * (kept * per_sample), caught.weight * per_sample};
    return {Rgb(0.0f), caught.weight * (1.0f - kept) * per_sample};
}

Rgb FilmSums::shadow_catcher(std::size_t pixel) const {
    if (caught_.empty() || !(caught_[pixel].weight > 0.0f))
        return Rgb(1.0f);
    // For what is put behind the picture: beside what the picture itself covers.
    const float alpha = sums_[pixel * stride_ + *offsets_[static_cast<std::size_t>(Pass::Combined)] + 3];
    const float uncovered = static_cast<float>(sample_counts_[pixel]) - alpha;
    const float share = caught_[pixel].weight / std::max(uncovered, caught_[pixel].weight);
    return Rgb(1.0f) - share * (Rgb(1.0f) - caught_[pixel].kept());
}

Film FilmSums::resolve(const Progress& progress) const {
    Film film{.width_px = width_px_, .height_px = height_px_, .planes = {}, .data_planes = {}, .statistics = {}};
    const std::size_t pixel_count = sample_counts_.size();
    for (std::size_t index = 0; index < pass_count; ++index) {
        if (!offsets_[index])
            continue;
        const auto pass = static_cast<Pass>(index);
        const std::uint32_t channel_count = layout(pass).channel_count;
        Plane plane{.pass = pass, .values = std::vector<float>(pixel_count * channel_count)};
        constexpr std::size_t pixels_per_block = 1 << 14;
        parallel_for(
            pixel_count, progress,
            [&](std::size_t pixel) {
                float* to = &plane.values[pixel * channel_count];
                if (pass == Pass::ShadowCatcher) {
                    const Rgb kept = shadow_catcher(pixel);
                    std::copy_n(&kept.x, 3, to);
                    return;
                }
                for (std::uint32_t channel = 0; channel < channel_count; ++channel)
                    to[channel] = resolved(pixel, pass, channel);
                if (pass == Pass::Combined && !caught_.empty()) {
                    const vec4 more = caught_colour(pixel);
                    for (int channel = 0; channel < 4; ++channel)
                        to[channel] += more[channel];
                }
            },
            pixels_per_block);
        film.planes.push_back(std::move(plane));
    }
    return film;
}
} // namespace tyndall::render
