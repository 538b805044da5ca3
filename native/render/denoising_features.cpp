// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/denoising_features.hpp"
#include "render/light_paths.hpp"

namespace tyndall::render {
// Facets no wider are as sharp as a mirror to Cycles.
static constexpr float sharpest_alpha = 0.075f;
// Of what a surface does to light, by weight: with less of it that is not sharp, features are those behind.
static constexpr float least_rough_share = 0.25f;

/// Share of even light that lobes send back, by their sharpness.
struct LobeAlbedos {
    Rgb rough{0.0f}, sharp{0.0f};
};

static LobeAlbedos albedos_of(const LobeSet& lobes) {
    LobeAlbedos found;
    for (const Lobe& lobe : lobes.lobes) {
        const bool is_sharp = lobe.is_of_facets() && lobe.alpha <= sharpest_alpha;
        (is_sharp ? found.sharp : found.rough) += lobe_albedo(lobes, lobe);
    }
    return found;
}

FeatureSearches see_features(const FeatureSearch& search, float distance_m, const SurfaceClosures& closures,
                             const LobeSet& lobes, std::span<const Lobe> bent, const mat4& world_from_camera,
                             bool follows_mirrors, DenoisingFeatures& features) {
    if (search.is_over)
        return {.passing = search, .all_sent = search};
    features.depth_m += search.share * average(search.through) * (distance_m - search.passed_m);
    features.albedo += search.share * search.through * closures.emission;

    const LobeAlbedos of_lobes = albedos_of(lobes);
    Rgb all_sent = closures.mirrored;
    for (const Lobe& lobe : bent)
        all_sent += lobe.a + lobe.weight;
    const Rgb sent = follows_mirrors ? all_sent : Rgb(0.0f);
    const Rgb unfollowed = of_lobes.sharp + all_sent - sent;
    const Rgb sharp = closures.transparent + sent + unfollowed;
    const Rgb rough = closures.diffuse_albedo + closures.translucent + of_lobes.rough;
    const float sharp_weight = average(sharp), rough_weight = average(rough);
    FeatureSearches next{.passing = search, .all_sent = search, .sharp_weight = sharp_weight};
    // What ends here: all, or of a sharp surface that which is not followed, as if there was white behind it.
    const bool ends = rough_weight > least_rough_share * (rough_weight + sharp_weight) || sharp_weight == 0.0f;
    const float ending = search.share * (ends ? 1.0f : average(unfollowed) / sharp_weight);
    features.albedo += ending * search.through * (ends ? rough : sharp);
    if (rough_weight + sharp_weight > 0.0f) {
        const mat3 axes(world_from_camera);
        const vec3& normal = lobes.normal;
        features.normal +=
            ending * vec3(glm::dot(axes[0], normal), glm::dot(axes[1], normal), -glm::dot(axes[2], normal));
    }
    if (ends) {
        next.passing.is_over = next.all_sent.is_over = true;
        return next;
    }
    next.passing.through = next.all_sent.through = search.through * sharp;
    next.passing.share = search.share * average(closures.transparent) / sharp_weight;
    next.passing.passed_m = distance_m;
    next.all_sent.passed_m = 0.0f;
    return next;
}

FeatureSearch FeatureSearches::sent(const Rgb& share) const {
    FeatureSearch of_ray = all_sent;
    if (!of_ray.is_over)
        of_ray.share = all_sent.share * average(share) / sharp_weight;
    return of_ray;
}

void see_world_features(const FeatureSearch& search, const Rgb& radiance, DenoisingFeatures& features) {
    if (!search.is_over)
        features.albedo += search.share * search.through * radiance;
}
} // namespace tyndall::render
