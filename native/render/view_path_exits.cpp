// SPDX-License-Identifier: GPL-3.0-or-later
// Points where light comes in that is seen below a surface.
#include "core/random.hpp"
#include "render/follower.hpp"
#include "render/subsurface_exit.hpp"
#include <numbers>

namespace tyndall::render {
void ViewPath::await_exits(const Lit& lit, const Share& share, SurfaceWalk& exits) const {
    ProgramRandom random = lit.random;
    for (const Lobe& lobe : lit.below) {
        random.seed = hash(random.seed, 0x6578'6974); // a seed apart from those of other purposes
        const Exits<SubsurfaceExit> found = subsurface_exits({.scene = scene_,
                                                              .point = lit.point,
                                                              .lobe = lobe,
                                                              .outgoing = lit.towards_viewer,
                                                              .footprint_m = lit.footprint_m,
                                                              .random = random});
        for (const SubsurfaceExit& exit : found.all()) {
            const Rgb throughput = share.throughput * exit.weight;
            const bool has_lobe = exit.own_normal != vec3(0.0f) || lobe.is_separable;
            exits.points.push_back(exit.point);
            exits.shades.push_back({.throughput = Rgb(0.0f),
                                    .radiance = has_lobe ? Rgb(0.0f) : throughput * std::numbers::inv_pi_v<float>,
                                    .sample = share.sample,
                                    .of = share.of,
                                    .is_elsewhere = true,
                                    .way = share.way(Scatterer::Diffuse)});
            if (!has_lobe)
                continue;
            exits.points.back().lambert_share = 0.0f;
            // Seen along its normal, Burley's is what dims flat light alone.
            const Lobe leaving{.kind = lobe.is_separable ? Lobe::Kind::Burley : Lobe::Kind::Lambert,
                               .bump_shadowing =
                                   exit.own_normal != vec3(0.0f) ? lobe.bump_shadowing : BumpShadowing::None,
                               .alpha = 0.0f,
                               .weight = Rgb(1.0f),
                               .normal = exit.own_normal};
            exits.push_lobes({&leaving, 1},
                             leaving.has_own_normal() ? leaving.normal : exit.point.shading.shading_normal, throughput);
        }
    }
}
} // namespace tyndall::render
