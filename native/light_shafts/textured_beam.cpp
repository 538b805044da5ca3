// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/textured_beam.hpp"
#include "light_shafts/lit_pieces.hpp"
#include "light_shafts/texture_steps.hpp"
#include "scene/light_texture.hpp"

namespace tyndall::light_shafts {
/// All points see the same texel where the picture does not lie across the light.
static PlanarPlacement placement_of(const Light& light) {
    if (light.texture->projection == LightProjection::Planar)
        return planar_placement(light, *light.texture);
    const vec2 uv = texture_uv(light, light.position, light.position);
    return {.u_per_m = vec3(0.0f), .v_per_m = vec3(0.0f), .uv_at_origin = uv};
}

/// Half texels that the ray crosses between its first and its last lit point.
static float step_count(const Light& light, const ViewRay& ray, std::span<const LitInterval> lit) {
    const vec2 texels_per_m = placement_of(light).uv_per_m(ray.direction) * light.texture->image->size();
    constexpr float fewest = 64.0f, most = 256.0f;
    return std::clamp(2.0f * glm::length(texels_per_m) * (lit.back().far_m - lit.front().near_m), fewest, most);
}

static float lit_length(std::span<const ScatterPiece> pieces, std::span<const LitInterval> lit) {
    float length_m = 0.0f;
    for_each_lit_part(pieces, lit,
                      [&](const ScatterPiece&, float near_m, float far_m, const Rgb&) { length_m += far_m - near_m; });
    return length_m;
}

Rgb scattered_in_steps(const Light& light, const ViewRay& ray, std::span<const ScatterPiece> pieces,
                       std::span<const LitInterval> lit, float step_count) {
    thread_local std::vector<TextureStep> steps;
    const LightTexture& texture = *light.texture;
    const PlanarPlacement placement = placement_of(light);
    const float step_m = lit_length(pieces, lit) / step_count;
    const float texels_per_m = glm::length(placement.uv_per_m(ray.direction) * texture.image->size());
    Rgb sum(0.0f);
    if (!(step_m > 0.0f))
        return sum;
    steps.clear();
    append_texture_steps(ray, pieces, lit, placement, step_m, steps);
    for (const TextureStep& step : steps)
        sum += step.weight * texture.colour(step.uv, step_m * texels_per_m);
    return sum;
}

void add_textured(const Visibility& visibility, const Light& light, const TextureRows* rows,
                  std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                  std::span<float> lit_length_m) {
    thread_local LitRows lit;
    lit.clear();
    visibility.lit_intervals(rays, lit);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const std::span own_pieces = pieces.of_ray(ray);
        const std::span own_lit = lit.of_ray(ray);
        if (!lit_length_m.empty())
            for_each_lit_part(own_pieces, own_lit,
                              [&](const ScatterPiece&, float near_m, float far_m, const Rgb& transmittance) {
                                  lit_length_m[ray] += (far_m - near_m) * average(transmittance);
                              });
        if (own_lit.empty())
            continue;
        std::optional<Rgb> sum;
        if (rows != nullptr)
            sum = rows->scattered(rays[ray], own_pieces, own_lit);
        radiance[ray] +=
            sum ? *sum
                : scattered_in_steps(light, rays[ray], own_pieces, own_lit, step_count(light, rays[ray], own_lit));
    }
}
} // namespace tyndall::light_shafts
