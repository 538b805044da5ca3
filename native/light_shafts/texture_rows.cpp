// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/texture_rows.hpp"
#include "light_shafts/lit_pieces.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::light_shafts {
static constexpr float two_pi = 2.0f * std::numbers::pi_v<float>;
/// Along a line of a coarse picture: its texels' own borders then blur by no more than a few thousandths of it.
static constexpr float fewest_samples = 1024.0f;

static float cross(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

TextureRows::TextureRows(const Light& light, const View& view, std::span<const ViewRay> rays)
    : texture_(*light.texture), placement_(planar_placement(light, texture_)), size_(texture_.image->size()),
      is_parallel_(view.is_orthographic) {
    start_ = texel_at(view.position);
    if (is_parallel_) {
        const vec2 way = placement_.uv_per_m(view.direction) * size_;
        along_ = glm::length(way) > 0.0f ? glm::normalize(way) : vec2(1, 0);
    }
    is_dark_outside_ = texture_.image->texture().extension == TextureExtension::Clip && texture_.offset == Rgb(0.0f);
    const auto [lines, texels] = extent_of(rays);
    begin_ = texels.least, end_ = texels.most;
    if (is_dark_outside_) {
        const Range picture = picture_along();
        begin_ = std::max(begin_, picture.least), end_ = std::min(end_, picture.most);
    }
    const float length = end_ - begin_;
    if (!(length > 0.0f) || !std::isfinite(length))
        return;
    sample_count_ = static_cast<std::uint32_t>(std::clamp(length, fewest_samples, static_cast<float>(most_samples)));
    step_ = length / static_cast<float>(sample_count_);
    ++sample_count_;
    const float fan = lines.most - lines.least;
    const float widest = is_parallel_ ? fan : fan * std::max(std::abs(begin_), std::abs(end_));
    line_count_ =
        static_cast<std::uint32_t>(std::clamp(std::ceil(widest / step_), 1.0f, static_cast<float>(most_lines)));
    first_line_ = lines.least;
    line_step_ = std::max(fan, 1e-6f) / static_cast<float>(line_count_);
    ++line_count_; // the last is the other border, or closes the circle
    lines_ = std::vector<Line>(line_count_);
}

/// A little more than the rays reach: those of later passes lie between and beside them.
TextureRows::Extent TextureRows::extent_of(std::span<const ViewRay> rays) {
    vec2 mean(0.0f);
    if (!is_parallel_)
        for (const ViewRay& ray : rays)
            mean += placement_.uv_per_m(ray.direction) * size_;
    reference_rad_ = std::atan2(mean.y, mean.x);
    Extent extent;
    for (const ViewRay& ray : rays) {
        if (!(ray.near_m < ray.far_m))
            continue;
        const Crossing crossing = crossing_of(ray);
        extent.lines.grow(crossing.line);
        for (const float at_m : {ray.near_m, ray.far_m})
            extent.texels.grow(crossing.at_zero + at_m * crossing.texels_per_m);
    }
    for (Range* range : {&extent.lines, &extent.texels}) {
        const float margin = 0.01f * (range->most - range->least);
        range->least -= margin, range->most += margin;
    }
    // A fan this wide is the whole circle: the rays look along the light.
    if (!is_parallel_ && extent.lines.most - extent.lines.least > 1.5f * pi)
        extent.lines = {-pi, pi};
    return extent;
}

/// What the picture covers of the lines, with the border of a texel that it fades out over.
TextureRows::Range TextureRows::picture_along() const {
    const vec2 low(-1.0f), high = size_ + 1.0f;
    Range range;
    for (int corner = 0; corner < 4; ++corner) {
        const vec2 at(corner % 2 == 0 ? low.x : high.x, corner / 2 == 0 ? low.y : high.y);
        range.grow(is_parallel_ ? glm::dot(along_, at) : glm::length(at - start_));
    }
    if (!is_parallel_)
        range.least = glm::length(glm::max(glm::max(low - start_, start_ - high), 0.0f));
    return range;
}

TextureRows::Crossing TextureRows::crossing_of(const ViewRay& ray) const {
    const vec2 way = placement_.uv_per_m(ray.direction) * size_;
    if (!is_parallel_)
        return {.line = std::remainder(std::atan2(way.y, way.x) - reference_rad_, two_pi),
                .at_zero = 0.0f,
                .texels_per_m = glm::length(way)};
    const vec2 origin = texel_at(ray.origin);
    return {.line = cross(along_, origin), .at_zero = glm::dot(along_, origin), .texels_per_m = glm::length(way)};
}

const std::vector<Rgb>& TextureRows::line(std::uint32_t index) const {
    Line& line = lines_[index];
    std::call_once(line.once, [&] {
        const float place = first_line_ + static_cast<float>(index) * line_step_;
        const float angle_rad = reference_rad_ + place;
        const vec2 direction = is_parallel_ ? along_ : vec2(std::cos(angle_rad), std::sin(angle_rad));
        const vec2 from = is_parallel_ ? place * vec2(-along_.y, along_.x) : start_;
        line.running.resize(sample_count_);
        glm::dvec3 sum(0.0);
        for (std::uint32_t sample = 0; sample < sample_count_; ++sample) {
            line.running[sample] = Rgb(sum);
            const float at = begin_ + (static_cast<float>(sample) + 0.5f) * step_;
            const float spacing = is_parallel_ ? line_step_ : line_step_ * std::abs(at);
            sum += glm::dvec3(step_ * texture_.colour((from + at * direction) / size_, std::max(step_, spacing)));
        }
    });
    return line.running;
}

/// Of the weights at the ends of a part, 1 - tilt and 1 + tilt, where so much light is lost along it: -tanh(lost / 2).
static Rgb tilt_of(const Rgb& lost) {
    const Rgb square = lost * lost;
    if (std::max({square.x, square.y, square.z}) < 0.04f) // 2e-7
        return lost * (-0.5f + square * (1.0f / 24.0f - square * (1.0f / 240.0f)));
    return 2.0f / (1.0f + glm::exp(lost)) - 1.0f;
}

std::optional<Rgb> TextureRows::scattered(const ViewRay& ray, std::span<const ScatterPiece> pieces,
                                          std::span<const LitInterval> lit) const {
    const Crossing crossing = crossing_of(ray);
    const float between = (crossing.line - first_line_) / line_step_;
    if (lines_.empty() || !(between >= 0.0f && between <= static_cast<float>(line_count_ - 1)))
        return std::nullopt;
    const auto first = std::min(static_cast<std::uint32_t>(between), line_count_ - 2);
    const std::vector<Rgb>&line0 = line(first), &line1 = line(first + 1);
    const float share = between - static_cast<float>(first);
    const auto last = static_cast<float>(sample_count_ - 1);
    bool reaches = true;
    const auto running = [&](float at_m) {
        const float place = (crossing.at_zero + at_m * crossing.texels_per_m - begin_) / step_;
        reaches = reaches && ((place >= 0.0f && place <= last) || is_dark_outside_);
        const float inside = std::clamp(place, 0.0f, last);
        const auto sample = std::min(static_cast<std::uint32_t>(inside), sample_count_ - 2);
        const float rest = inside - static_cast<float>(sample);
        return glm::mix(glm::mix(line0[sample], line0[sample + 1], rest),
                        glm::mix(line1[sample], line1[sample + 1], rest), share);
    };
    Rgb sum(0.0f);
    for_each_lit_part(pieces, lit, [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
        const float length_m = far_m - near_m, texels = length_m * crossing.texels_per_m;
        if (texels < 0.05f) { // so short that running integrals tell nothing of it
            const vec3 middle = ray.origin + 0.5f * (near_m + far_m) * ray.direction;
            sum +=
                transmittance * light_shafts::scattered(piece, near_m, far_m) * texture_.colour(placement_.uv(middle));
            return;
        }
        constexpr float depth_per_part = 0.15f, deepest = 80.0f, even = 0.01f;
        const Rgb per_m = glm::abs(piece.depth_per_m);
        const float depth = std::max({per_m.x, per_m.y, per_m.z}) * length_m;
        const float count = std::ceil(std::clamp(depth / depth_per_part, 1.0f, deepest / depth_per_part));
        const float part_m = length_m / count;
        Rgb before = running(near_m);
        for (float part = 0.0f; part < count; ++part) {
            const float begin_m = near_m + part * part_m, end_m = part + 1.0f < count ? begin_m + part_m : far_m;
            const Rgb after = running(end_m), gain = after - before;
            Rgb weighted = gain;
            if (depth > even) { // else it would be off by less than a thousandth
                const Rgb middle = running(0.5f * (begin_m + end_m)) - before;
                const Rgb tilt = tilt_of(piece.depth_per_m * (end_m - begin_m));
                weighted += tilt * (gain - (4.0f * middle + gain) * (1.0f / 3.0f));
            }
            sum += transmittance * light_shafts::scattered(piece, begin_m, end_m) * weighted /
                   ((end_m - begin_m) * crossing.texels_per_m);
            before = after;
        }
    });
    return reaches ? std::optional(sum) : std::nullopt;
}
} // namespace tyndall::light_shafts
