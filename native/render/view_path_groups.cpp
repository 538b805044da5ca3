// SPDX-License-Identifier: GPL-3.0-or-later
// The part of view_path.hpp that keeps light groups apart.
#include "render/view_path.hpp"

namespace tyndall::render {
void ViewPath::add_light_to_groups(const SurfaceWalk& walked, const SurfaceLight& light,
                                   std::span<PathSample> samples) const {
    const auto add = [&](const SurfaceLight::OfLight& of_light, std::size_t group) {
        for (std::size_t point = 0; point < walked.points.size(); ++point) {
            const SurfaceWalk::Shade& shade = walked.shades[point];
            samples[shade.sample].by_group[group] += shade.radiance * of_light.irradiance[point];
        }
        for (std::size_t lobed = 0; lobed < walked.lobed.size(); ++lobed) {
            const SurfaceWalk::LobedPoint& of = walked.lobed[lobed];
            samples[walked.shades[of.point].sample].by_group[group] += of.throughput * of_light.reflected[lobed];
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
