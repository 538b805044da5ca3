// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/textured_beam.hpp"
#include "light_shafts/lit_pieces.hpp"
#include "light_shafts/texture_steps.hpp"
#include "scene/light_texture.hpp"

namespace tyndall::light_shafts {
/// All points see the same texel where the picture does not lie across the light.
static PlanarPlacement placement_of(const Light& light) {
    if (light.texture->projection == LightProjection::Planar)
        return planar_placement(light, light.texture->size_m);
    const vec2 uv = texture_uv(light, light.position, light.position);
    return {.u_per_m = vec3(0.0f), .v_per_m = vec3(0.0f), .uv_at_origin = uv};
}

void add_textured(const Visibility& visibility, const Light& light, std::span<const ViewRay> rays,
                  const PieceRows& pieces, std::span<Rgb> radiance, std::span<float> lit_length_m, float most_steps) {
    thread_local LitRows lit;
    thread_local std::vector<TextureStep> steps;
    lit.clear();
    visibility.lit_intervals(rays, lit);
    const LightTexture& texture = *light.texture;
    const PlanarPlacement placement = placement_of(light);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        float lit_m = 0.0f, seen_m = 0.0f;
        for_each_lit_part(pieces.of_ray(ray), lit.of_ray(ray),
                          [&](const ScatterPiece&, float near_m, float far_m, const Rgb& transmittance) {
                              lit_m += far_m - near_m;
                              seen_m += (far_m - near_m) * average(transmittance);
                          });
        if (!lit_length_m.empty())
            lit_length_m[ray] += seen_m;
        if (!(lit_m > 0.0f))
            continue;
        const float texels_per_m = glm::length(placement.uv_per_m(rays[ray].direction) * texture.image->size());
        const float step_m = std::max(1.0f / texels_per_m, lit_m / most_steps);
        steps.clear();
        append_texture_steps(rays[ray], pieces.of_ray(ray), lit.of_ray(ray), placement, step_m, steps);
        Rgb sum(0.0f);
        for (const TextureStep& step : steps)
            sum += step.weight * texture.colour(step.uv, step_m * texels_per_m);
        radiance[ray] += sum;
    }
}
} // namespace tyndall::light_shafts
