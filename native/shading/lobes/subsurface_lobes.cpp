// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/lobe_builder.hpp"

namespace tyndall {
void LobeBuilder::subsurface(const Rgb& weight, const Below& below) {
    if (!(average(weight) >= least_share))
        return;
    if (lobes_ == nullptr) { // as if it were Lambert's
        closures_.diffuse_albedo += weight;
        return;
    }
    const bool is_of_blender3 = source_.model == LobeModel::Principled3Subsurface;
    if (is_of_blender3)
        add({.kind = Lobe::Kind::BurleyRetro, .alpha = below.roughness, .weight = weight, .normal = normals_.facets});
    Rgb inside = weight, radius_m = glm::max(below.radius_m, Rgb(0.0f)), at_surface(0.0f);
    for (int channel = 0; channel < 3; ++channel)
        if (!(radius_m[channel] >= subsurface::least_radius_m)) {
            at_surface[channel] = inside[channel];
            inside[channel] = radius_m[channel] = 0.0f;
        }
    if (at_surface != Rgb(0.0f)) {
        if (is_of_blender3)
            add({.kind = Lobe::Kind::Burley, .alpha = 0.0f, .weight = at_surface, .normal = normals_.facets});
        else if (normals_.facets == vec3(0.0f))
            closures_.diffuse_albedo += at_surface;
        else
            add({.kind = Lobe::Kind::Lambert, .weight = at_surface, .normal = normals_.facets});
    }
    if (inside == Rgb(0.0f))
        return;
    const float ior = std::clamp(below.ior, 1.01f, 3.8f);
    lobes_->push_back({.kind = Lobe::Kind::Subsurface,
                       .is_separable = is_of_blender3,
                       .bump_shadowing = source_.bump_shadowing,
                       .subsurface = source_.subsurface,
                       .alpha = source_.subsurface == SubsurfaceMethod::SkinWalk ? 1.0f : clamped(below.alpha),
                       .own_alpha = std::clamp(below.anisotropy, 0.0f, 0.9f),
                       .ior = ior,
                       .weight = inside,
                       .a = subsurface::mean_free_path(source_.subsurface, radius_m, below.albedo, ior),
                       .b = below.albedo,
                       .normal = normals_.facets});
}
} // namespace tyndall
