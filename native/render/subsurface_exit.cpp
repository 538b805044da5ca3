// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/subsurface_exit.hpp"
#include "core/random.hpp"
#include "shading/material.hpp"
#include <algorithm>

namespace tyndall::render {
/// Bumps bend the light that comes in there, too: the mean normal of what scatters there below the surface, as Cycles has it.
static vec3 own_normal_at(const SubsurfaceEntry& entry, const FoundExit& exit, const SurfacePoint& point) {
    const Material& material = entry.scene.material(exit.hit.instance, exit.hit.triangle);
    if (std::ranges::none_of(material.lobe_sources, [](const LobeSource& source) {
            return source.subsurface != SubsurfaceMethod::None && source.facet_normal != LobeSource::no_register;
        }))
        return vec3(0.0f);
    thread_local Lobes lobes;
    lobes.clear();
    (void)entry.scene.closures(
        {.ray = exit.from_outside, .kind = RayKind::Diffuse, .footprint_m = entry.footprint_m, .random = entry.random},
        point.shading, exit.hit, &lobes);
    vec3 sum(0.0f);
    for (const Lobe& lobe : lobes)
        if (lobe.kind == Lobe::Kind::Subsurface)
            sum += (lobe.has_own_normal() ? lobe.normal : point.shading.shading_normal) * average(lobe.weight);
    const float length = glm::length(sum);
    return length > 0.0f && sum / length != point.shading.shading_normal ? sum / length : vec3(0.0f);
}

Exits<SubsurfaceExit> subsurface_exits(const SubsurfaceEntry& entry) {
    const FoundExits found =
        entry.lobe.subsurface == SubsurfaceMethod::Profile ? exit_by_profile(entry) : walk_below(entry);
    Exits<SubsurfaceExit> exits;
    for (const FoundExit& exit : found.all()) {
        const auto number = static_cast<std::uint32_t>(exits.count);
        constexpr std::uint32_t of_light = 0x6c69'7465; // a seed apart from those of the way
        SurfacePoint point =
            surface_point(entry.scene, exit.from_outside, exit.hit, hash(entry.random.seed, of_light + number));
        point.passed_count = entry.point.passed_count; // its light began there, wherever the way below led
        exits.each[exits.count++] = {point, own_normal_at(entry, exit, point), exit.weight};
    }
    return exits;
}
} // namespace tyndall::render
