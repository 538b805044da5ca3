// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/light_paths.hpp"
#include "shading/lobes/ggx_energy.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
Scatterer scatterer_of(const Lobe& lobe) {
    if (lobe.is_matte())
        return Scatterer::Diffuse;
    return lobe.kind == Lobe::Kind::FibreTransmission ? Scatterer::Transmission : Scatterer::Glossy;
}

Rgb lobe_albedo(const LobeSet& lobes, const Lobe& lobe) {
    const LobeSet alone{.lobes = {&lobe, 1}, .normal = lobes.normal, .outgoing = lobes.outgoing};
    const bool is_ggx = lobe.kind == Lobe::Kind::Ggx || lobe.kind == Lobe::Kind::GgxAlongTangent;
    if (!is_ggx || lobe.is_separable)
        return alone.albedo();
    const float cosine =
        std::clamp(glm::dot(lobe.has_own_normal() ? lobe.normal : lobes.normal, lobes.outgoing), 0.0f, 1.0f);
    const float roughness = std::sqrt(lobe.alpha);
    const float seen = ggx::albedo(roughness, cosine).seen; // weights of facets make up for what these hide
    if (lobe.fresnel == Lobe::Fresnel::Dielectric && lobe.film.spectra == nullptr)
        return seen * lobe.weight * glm::mix(lobe.a, lobe.b, ggx::mean_rise(roughness, cosine, lobe.ior));
    return seen * alone.albedo();
}

void see_colours(const SurfaceClosures& closures, const LobeSet& lobes, std::span<const Lobe> bent,
                 const Rgb& throughput, LightPaths& paths) {
    paths.glossy_colour += throughput * closures.mirrored;
    for (const Lobe& lobe : lobes.lobes) {
        const Scatterer by = scatterer_of(lobe);
        if (by != Scatterer::Diffuse)
            (by == Scatterer::Glossy ? paths.glossy_colour : paths.transmission_colour) +=
                throughput * lobe_albedo(lobes, lobe);
    }
    for (const Lobe& lobe : bent) {
        paths.glossy_colour += throughput * lobe.a;
        paths.transmission_colour += throughput * lobe.weight;
    }
}
} // namespace tyndall::render
