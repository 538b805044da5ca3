// SPDX-License-Identifier: GPL-3.0-or-later
// What the points of a walk ask of the lights, and how that comes to the samples of their rays.
#include "render/view_path.hpp"
#include <array>
#include <bit>

namespace tyndall::render {
// Random pairs set aside for the light of one layer: 2 for each of 100 lights and 2 of the world fit; beyond, layers
// share pairs, which adds noise but no bias.
static constexpr std::uint32_t pairs_per_layer = 256;

void ViewPath::ask_lights(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<const std::uint8_t> is_asked,
                          SurfaceLight& light, std::size_t group_count) const {
    const std::size_t light_count = light_.light_count();
    light.lights.resize(light_count);
    light.many_by_group.resize(light_.has_many() ? group_count : 0);
    for (SurfaceLight::OfLight& of_group : light.many_by_group) {
        of_group.irradiance.resize(walked.points.size());
        of_group.reflected.resize(walked.lobed.size());
    }
    for (std::size_t index = 0; index < light_count; ++index)
        if (is_asked[index] != 0) {
            light.lights[index].irradiance.resize(walked.points.size());
            light.lights[index].unshadowed.resize(
                config_.lights_black_surfaces && !light_.is_world(index) ? walked.points.size() : 0);
            light.lights[index].reflected.resize(walked.lobed.size());
        }
    thread_local std::vector<DirectLight::Irradiance> irradiance;
    irradiance.resize(light_count * DirectLight::most_points);
    thread_local std::vector<DirectLight::Irradiance> many_by_group;
    std::size_t first = 0;
    for (const auto [end, layer, among] : walked.batches) {
        const std::size_t count = end - first;
        many_by_group.assign(light.many_by_group.size() * count, {});
        const std::span<const SurfaceWalk::LobedPoint> lobed = walked.lobed_of(first, end);
        const auto first_lobed = static_cast<std::size_t>(lobed.data() - walked.lobed.data());
        DirectLight::PointLobes lobes;
        for (const SurfaceWalk::LobedPoint& of : lobed)
            lobes[of.point - first] = walked.lobes_of(of);
        light_.at(std::span(walked.points).subspan(first, count), {sample_index, 1 + layer * pairs_per_layer}, is_asked,
                  irradiance, lobed.empty() ? nullptr : &lobes, many_by_group, among);
        for (std::size_t index = 0; index < light_count; ++index) {
            if (is_asked[index] == 0)
                continue;
            SurfaceLight::OfLight& of_light = light.lights[index];
            for (std::size_t i = 0; i < count; ++i) {
                const DirectLight::Irradiance& found = irradiance[index * count + i];
                of_light.irradiance[first + i] = found.sum();
                if (!of_light.unshadowed.empty())
                    of_light.unshadowed[first + i] = found.unshadowed;
            }
            for (std::size_t i = 0; i < lobed.size(); ++i)
                of_light.reflected[first_lobed + i] = irradiance[index * count + lobed[i].point - first].reflected;
        }
        for (std::size_t group = 0; group < light.many_by_group.size(); ++group) {
            SurfaceLight::OfLight& of_group = light.many_by_group[group];
            for (std::size_t i = 0; i < count; ++i)
                of_group.irradiance[first + i] = many_by_group[group * count + i].sum();
            for (std::size_t i = 0; i < lobed.size(); ++i)
                of_group.reflected[first_lobed + i] = many_by_group[group * count + lobed[i].point - first].reflected;
        }
        first = end;
    }
}

std::size_t ViewPath::ask_again(const SurfaceWalk& walked, std::uint32_t sample_index,
                                std::span<const std::uint8_t> is_asked, const MovedBoxes& moved,
                                SurfaceLight& light) const {
    std::array<SurfacePoint, DirectLight::most_points> again;
    std::array<std::uint32_t, DirectLight::most_points> index_of;
    std::array<DirectLight::Irradiance, DirectLight::most_points> irradiance;
    DirectLight::PointLobes lobes, lobes_again;
    std::array<std::size_t, DirectLight::most_points> lobed_index;
    std::size_t again_count = 0, first = 0;
    for (const auto [end, layer, among] : walked.batches) { // walks with catchers are not kept
        const auto points = std::span(walked.points).subspan(first, end - first);
        const std::span<const SurfaceWalk::LobedPoint> lobed = walked.lobed_of(first, end);
        if (!lobed.empty())
            lobes.fill({});
        for (std::size_t i = 0; i < lobed.size(); ++i) {
            lobes[lobed[i].point - first] = walked.lobes_of(lobed[i]);
            lobed_index[lobed[i].point - first] = static_cast<std::size_t>(&lobed[i] - walked.lobed.data());
        }
        const PairIndex first_pair{sample_index, 1 + layer * pairs_per_layer};
        for (std::size_t index = 0; index < light_.light_count(); ++index) {
            if (is_asked[index] != 0)
                continue;
            std::size_t count = 0;
            for (LaneSet left = light_.may_meet(index, points, first_pair, moved, lobed.empty() ? nullptr : &lobes);
                 left != 0; left &= left - 1) {
                const auto point = static_cast<std::uint32_t>(std::countr_zero(left));
                again[count] = points[point];
                lobes_again[count] = lobed.empty() ? LobeSet{} : lobes[point];
                irradiance[count] = {};
                index_of[count++] = static_cast<std::uint32_t>(first) + point;
            }
            if (count == 0)
                continue;
            light_.add_one(index, std::span(again).first(count), first_pair, irradiance,
                           lobed.empty() ? nullptr : &lobes_again);
            SurfaceLight::OfLight& of_light = light.lights[index];
            for (std::size_t i = 0; i < count; ++i) {
                of_light.irradiance[index_of[i]] = irradiance[i].sum(); // no occluder changes what is unshadowed
                if (!lobes_again[i].lobes.empty())
                    of_light.reflected[lobed_index[index_of[i] - first]] = irradiance[i].reflected;
            }
            again_count += count;
        }
        first = end;
    }
    return again_count;
}

void ViewPath::add_light(const SurfaceWalk& walked, const SurfaceLight& light, std::span<PathSample> samples) const {
    const std::size_t lamp_count = light_.light_count() - (light_.has_world() ? 1 : 0);
    for (std::size_t point = 0; point < walked.points.size(); ++point) {
        const auto& [throughput, radiance, cover, target, of, is_elsewhere, way] = walked.shades[point];
        PathSample& sample = samples[target];
        Rgb from_lights(0.0f), unshadowed(0.0f), from_world(0.0f);
        for (std::size_t lamp = 0; lamp < lamp_count; ++lamp) {
            from_lights += light.lights[lamp].irradiance[point];
            if (!light.lights[lamp].unshadowed.empty())
                unshadowed += light.lights[lamp].unshadowed[point];
        }
        if (light_.has_world())
            from_world = light.lights.back().irradiance[point];
        sample.add_light(radiance * (from_lights + from_world), of, way);
        if (of == LightOf::Picture && !is_elsewhere && sample.world_lit.albedo == Rgb(0.0f)) {
            const ShadingPoint& shading = walked.points[point].shading;
            sample.world_lit = {shading.position, shading.shading_normal, radiance, from_world};
        }
        sample.lit += throughput * from_lights;
        sample.unshadowed += throughput * unshadowed;
    }
    for (std::size_t lobed = 0; lobed < walked.lobed.size(); ++lobed) {
        Rgb reflected(0.0f);
        for (const SurfaceLight::OfLight& of_light : light.lights)
            reflected += of_light.reflected[lobed];
        const SurfaceWalk::LobedPoint& of = walked.lobed[lobed];
        const SurfaceWalk::Shade& shade = walked.shades[of.point];
        samples[shade.sample].add_light(of.throughput * reflected, shade.of, shade.way);
    }
    if (!walked.shades.empty() && !samples[walked.shades.front().sample].by_group.empty())
        add_light_to_groups(walked, light, samples);
}

void ViewPath::add_light_to_groups(const SurfaceWalk& walked, const SurfaceLight& light,
                                   std::span<PathSample> samples) const {
    const auto add = [&](const SurfaceLight::OfLight& of_light, std::size_t group) {
        for (std::size_t point = 0; point < walked.points.size(); ++point) {
            const SurfaceWalk::Shade& shade = walked.shades[point];
            if (shade.of != LightOf::Picture)
                continue;
            samples[shade.sample].by_group[group] += shade.radiance * of_light.irradiance[point];
        }
        for (std::size_t lobed = 0; lobed < walked.lobed.size(); ++lobed) {
            const SurfaceWalk::LobedPoint& of = walked.lobed[lobed];
            const SurfaceWalk::Shade& shade = walked.shades[of.point];
            if (shade.of == LightOf::Picture)
                samples[shade.sample].by_group[group] += of.throughput * of_light.reflected[lobed];
        }
    };
    const std::size_t group_count = samples[walked.shades.front().sample].by_group.size();
    for (std::size_t index = 0; index < light.lights.size(); ++index)
        if (!light_.is_many(index) && light_.group_of(index) < group_count)
            add(light.lights[index], light_.group_of(index));
    for (std::size_t group = 0; group < light.many_by_group.size(); ++group)
        add(light.many_by_group[group], group);
}
} // namespace tyndall::render
