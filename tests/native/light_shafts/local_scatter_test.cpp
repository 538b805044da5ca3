// SPDX-License-Identifier: GPL-3.0-or-later
// Batches of smooth pieces against the panels of support/local_panels.hpp, which know nothing of pieces.
#include "core/simd.hpp"
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "support/area_lights.hpp"
#include "support/forest.hpp"
#include "support/local_panels.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace local_scatter_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
Rgb random_rgb(SceneRandom& random, float most) {
    return {random.uniform(0.0f, most), random.uniform(0.0f, most), random.uniform(0.0f, most)};
}
Medium random_medium(SceneRandom& random, bool is_grey) {
    Medium medium{.name = "fog", .lobes = {{random_rgb(random, 0.2f), random.uniform(-0.9f, 0.9f)}}};
    if (random.uniform() < 0.3f) {
        medium.lobes.push_back({random_rgb(random, 0.1f), random.uniform(-0.9f, 0.9f)});
        medium.lobes[0].draine_alpha = 20.0f * std::abs(medium.lobes[0].asymmetry_g);
    }
    medium.sigma_a_per_m = random_rgb(random, 0.1f);
    if (is_grey) {
        for (ScatterLobe& lobe : medium.lobes)
            lobe.sigma_s_per_m = Rgb(lobe.sigma_s_per_m.x);
        medium.sigma_a_per_m = Rgb(medium.sigma_a_per_m.x);
    }
    return medium;
}

/// The kinds of local lights: a point, strata of soft lamps, spots, narrow, wide, scaled, old and new.
std::vector<Light> lights_at(const vec3& position, SceneRandom& random) {
    Light lamp{.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(1.0f), .position = position};
    std::vector<Light> lights{lamp};
    lamp.radius_m = 0.3f;
    lights.push_back(lamp);
    lamp.body = LightBody::FacingDisc;
    lights.push_back(lamp);
    for (const float blend : {0.0f, 0.15f, 1.0f})
        for (const float half_angle_rad : {0.1f, 0.5f, 1.4f}) {
            Light spot = lamp;
            spot.kind = LightKind::Spot;
            spot.radius_m = random.uniform() < 0.5f ? 0.0f : 0.05f;
            spot.spot_axis = random.direction();
            spot.spot_blend = blend, spot.spot_half_angle_rad = half_angle_rad;
            spot.spot_falloff = random.uniform() < 0.3f ? SpotFalloff::Blender3 : SpotFalloff::Blender4;
            const auto [tangent, bitangent] = orthonormal_basis(-spot.spot_axis);
            spot.light_from_world_directions = glm::transpose(mat3(tangent, bitangent, -spot.spot_axis));
            spot.body = random.uniform() < 0.3f ? LightBody::Sphere : LightBody::FacingDisc;
            if (random.uniform() < 0.3f)
                spot.light_from_world_directions =
                    mat3(glm::scale(mat4(1.0f), vec3(1.0f, 1.5f, 0.8f))) * spot.light_from_world_directions;
            lights.push_back(spot);
        }
    for (const float half_spread_rad : {0.02f, 0.3f, 1.2f, 1.5707964f}) {
        Light area = area_light({0.4f, 0.1f});
        area.position = position;
        area.spot_axis = random.direction();
        area.spot_half_angle_rad = half_spread_rad;
        lights.push_back(area);
    }
    return lights;
}

/// MediaRays from anywhere in a box of 10 m, every other one past the light at a thousandth to a half of the way.
void add_random_rays(MediaRays& rays, const vec3& light, int count, SceneRandom& random) {
    for (int index = 0; index < count; ++index) {
        const vec3 origin = 5.0f * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const float aside = std::pow(10.0f, random.uniform(-3.0f, -0.3f));
        const vec3 past = glm::normalize(glm::normalize(light - origin) + aside * random.direction());
        rays.add({origin, index % 2 == 0 ? random.direction() : past, 0.0f, random.uniform(1.0f, 20.0f)});
    }
}

/// One scene with a coloured, nested pair of media and some rays, asked in several ways.
struct Nest {
    std::vector<FogBox> boxes{
        {{0, 0, 0}, {6, 5, 4}, {.name = "haze", .lobes = {{{0.02f, 0.04f, 0.08f}, 0.6f}}, .sigma_a_per_m = Rgb(0.01f)}},
        {{1, 0.5, 0}, {2, 1.5, 1}, {.name = "smoke", .lobes = {{Rgb(0.3f), -0.4f, 3.0f}}}}};
    std::unique_ptr<Scene> scene = scene_of(boxes);
    Progress progress;
    Media media{*scene, progress};
    MediaRays rays{media, {}, {0}, {}};
    explicit Nest(const vec3& light) {
        SceneRandom random(3);
        add_random_rays(rays, light, 300, random);
    }
};
Light narrow_spot() {
    Light spot{.name = "Spot", .kind = LightKind::Spot, .strength = Rgb(3.0f, 2.0f, 1.0f), .position = {2, -7, 1}};
    spot.spot_axis = glm::normalize(vec3(-0.2f, 1.0f, 0.0f));
    spot.spot_half_angle_rad = 0.2f, spot.spot_blend = 0.3f, spot.spot_falloff = SpotFalloff::Blender3;
    return spot;
}
} // namespace

// Pieces that cross the light's foot, and those that lead far away from it, were seen to fail here (1e-3) before they were
// cut: what happens in the last instant of the angle lies between the points of any rule.
TEST_CASE("batches of pieces agree with panels of the angle: media, cones, softness, near and far from the light") {
    SceneRandom random(11);
    for (std::uint32_t round = 0; round < 12; ++round) {
        CAPTURE(round);
        std::vector<FogBox> boxes{{{0, 0, 0}, {6, 5, 4}, random_medium(random, round % 3 == 0)}};
        if (round % 2 == 1) // nested in the first, and one that overlaps it
            boxes.push_back({{1, 0.5, 0}, {2, 1.5, 1}, random_medium(random, round % 3 == 0)});
        if (round % 4 == 3)
            boxes.push_back({{-5, 3, 1}, {3, 4, 2}, random_medium(random, false)});
        const auto scene = scene_of(boxes);
        Progress progress;
        const Media media(*scene, progress);
        const float reach = round % 4 < 2 ? 3.5f : 9.0f; // inside the first box, or anywhere
        const vec3 position = reach * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        for (const Light& light : lights_at(position, random)) {
            CAPTURE(light.name);
            CAPTURE(light.spot_blend);
            const vec3 u(random.uniform(), random.uniform(), 0.3f);
            const bool is_patch =
                light.kind == LightKind::Area || (light.body == LightBody::Sphere && light.radius_m > 0);
            const LightSample sample = is_patch ? stratum_of(light, 0, 5, 16, round) : sample_light(light, 0, u);
            MediaRays rays{media, {}, {0}, {}};
            add_random_rays(rays, sample.position, 4, random);
            const std::vector<Rgb> radiance = rays.ask(sample);
            for (std::size_t ray = 0; ray < radiance.size(); ++ray) {
                const dvec3 expected = by_panels(boxes, sample, rays, ray);
                // An area light's lobe has bends, and patches fade within little, between the points; next to none of
                // a patch's light may be a few percent of it off.
                const double share = is_patch ? 2e-3 : 5e-5, least = is_patch ? 1e-11 : 1e-15;
                CHECK(glm::length(dvec3(radiance[ray]) - expected) <= share * glm::length(expected) + least);
            }
        }
    }
}
TEST_CASE("a ray's bits do not depend on the rays beside it") {
    const Light spot = narrow_spot();
    const LightSample light = sample_light(spot, 0, vec3(0.5f));
    const Nest nest(light.position);
    const std::vector<Rgb> together = nest.rays.ask(light);
    for (std::size_t ray = 0; ray < together.size(); ++ray) {
        MediaRays alone{nest.media, {}, {0}, {}};
        alone.add(nest.rays.rays[ray]);
        CHECK(alone.ask(light)[0] == together[ray]);
    }
}
TEST_CASE("what is lit and what is dark add up to the whole, on every instruction set") {
    Light lamp{.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(3.0f, 2.0f, 1.0f), .position = {1, 2, -3}};
    lamp.radius_m = 0.2f;
    const Stripes lit(0.0f, 0.3f, 0.5f), dark(0.3f, 0.5f, 0.5f);
    for (const Light& light : {lamp, narrow_spot()}) {
        const LightSample sample = sample_light(light, 0, vec3(0.3f, 0.6f, 0.9f));
        const Nest nest(sample.position);
        const std::vector<Rgb> reference = nest.rays.ask(sample);
        for (const SimdTarget target : available_simd_targets()) {
            CAPTURE(static_cast<int>(target));
            const ForcedSimdTarget forced(target);
            const auto whole = nest.rays.ask(sample), a = nest.rays.ask(sample, &lit), b = nest.rays.ask(sample, &dark);
            for (std::size_t ray = 0; ray < whole.size(); ++ray) {
                CHECK(glm::length(whole[ray] - reference[ray]) <= 1e-5f * glm::length(reference[ray]));
                CHECK(glm::length(a[ray] + b[ray] - whole[ray]) <= 3e-5f * glm::length(whole[ray]) + 1e-12f);
            }
        }
    }
}
TEST_CASE("what a light would send without shadows is asked beside them, bit for bit") {
    const Light spot = narrow_spot();
    const LightSample light = sample_light(spot, 0, vec3(0.5f));
    const Nest nest(light.position);
    const LocalRays local = nest.rays.columns();
    const LocalScatter scatter(nest.media, light);
    const std::vector<Rgb> black(local.size(), Rgb(0.0f));
    std::vector<Rgb> alone = black;
    scatter.add_scattered(local, nullptr, alone, {}, {});
    const Stripes half(0.0f, 0.25f, 0.5f), nothing(0.0f, 0.0f, 0.5f);
    for (const Stripes* shadows : {&half, &nothing}) {
        std::vector<Rgb> shadowed = black, radiance = black, unshadowed = black;
        scatter.add_scattered(local, shadows, shadowed, {}, {});
        scatter.add_scattered(local, shadows, radiance, unshadowed, {});
        CHECK(radiance == shadowed);
        CHECK(unshadowed == alone);
        CHECK(unshadowed != radiance);
    }
    std::vector<Rgb> radiance = black, unshadowed = black;
    scatter.add_scattered(local, nullptr, radiance, unshadowed, {});
    CHECK(radiance == alone);
    CHECK(unshadowed == alone);
}
TEST_CASE("only what the cone holds is asked for shadows, and counts as lit: by half in its soft edge") {
    const Light spot = narrow_spot();
    const LightSample light = sample_light(spot, 0, vec3(0.5f));
    const Nest nest(light.position);
    const LocalRays local = nest.rays.columns();
    const LocalScatter scatter(nest.media, light);
    std::vector<Rgb> radiance(local.size(), Rgb(0.0f)), again = radiance;
    std::vector<float> lit_length_m(local.size(), 0.0f);
    const Stripes shadows(0.0f, 0.5f, 0.5f);
    scatter.add_scattered(local, &shadows, radiance, {}, {});
    CHECK(shadows.asked.size() < local.size() / 2);
    for (const ViewRay& ray : shadows.asked)
        for (const float at_m : {ray.near_m, ray.far_m}) {
            const vec3 from_light = ray.origin + at_m * ray.direction - light.position;
            CHECK(std::acos(glm::dot(glm::normalize(from_light), light.spot->spot_axis)) < 0.2f + 1e-3f);
        }
    scatter.add_scattered(local, &shadows, again, {}, lit_length_m);
    CHECK(again == radiance);
    std::size_t edge_count = 0;
    for (std::size_t ray = 0; ray < local.size(); ++ray) {
        double length_m = 0.0, step_m = 0.0;
        for (const LocalRays::Segment& segment : local.segments_of(ray)) {
            constexpr int steps = 2000;
            step_m = (segment.far_m - segment.near_m) / steps;
            for (int step = 0; step < steps; ++step) {
                const double at_m = segment.near_m + (step + 0.5) * step_m;
                const vec3 point = local.ray(ray).origin + static_cast<float>(at_m) * local.ray(ray).direction;
                const vec3 from_light = glm::normalize(point - light.position);
                const float cosine = glm::dot(from_light, spot.spot_axis); // a factor up to Blender 3
                const float shone = spot_attenuation(spot, from_light) / cosine;
                length_m += step_m * (shone >= 0.99999f ? 1.0 : shone > 0.0f ? 0.5 : 0.0);
                edge_count += shone > 0.0f && shone < 0.99999f;
            }
        }
        CHECK(std::abs(lit_length_m[ray] - length_m) <= 4.0 * step_m + 1e-2 * length_m);
    }
    CHECK(edge_count > 100);
}
// Without loss on the way from the light. Seen to fail, black from 1e3 on, where only the points of a rule were asked
// whether anything is left, and not the ends of the piece.
TEST_CASE("in ever denser soot a ray shows what the light gives its first instant") {
    const Light lamp{.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(1.0f), .position = {0.5f, 1.0f, 0.7f}};
    LightSample sample = sample_light(lamp, 0, vec3(0.5f));
    sample.is_dimmed_by_media = false;
    for (const float sigma : {1e1f, 1e2f, 1e3f, 2.5e3f, 6e3f, 1e4f, 3e4f, 5e4f, 1e5f}) {
        CAPTURE(sigma);
        const auto scene =
            scene_of({{{0, 0, 0}, {6, 5, 4}, {.name = "soot", .lobes = {{Rgb(sigma), 0.0f}}, .sigma_a_per_m = {}}}});
        Progress progress;
        const Media media(*scene, progress);
        MediaRays rays{media, {}, {0}, {}};
        rays.add({{-1, 0, 0}, glm::normalize(vec3(2, 1, 0.5f)), 0.0f, 5.0f});
        std::vector<Rgb> radiance(1, Rgb(0.0f));
        LocalScatter(media, sample).add_scattered(rays.columns(), nullptr, radiance, {}, {});
        const double away2 = glm::dot(dvec3(1.5, 1.0, 0.7), dvec3(1.5, 1.0, 0.7));
        const double expected = 1.0 / (4.0 * std::numbers::pi * away2); // sigma_s / sigma_t is 1
        CHECK(std::abs(radiance[0].x / expected - 1.0) < 3.0 / (sigma * std::sqrt(away2)) + 1e-4);
    }
}

namespace {
/// A sliver that lets a part of the light pass, shadow, and light from there on.
class Sliver final : public Visibility {
public:
    Sliver(const LitInterval& sliver, float rest_m) : sliver_(sliver), rest_m_(rest_m) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const override {
        for (const ViewRay& ray : rays) {
            for (const LitInterval& lit : {sliver_, LitInterval{.near_m = rest_m_, .far_m = ray.far_m}})
                if (std::max(lit.near_m, ray.near_m) < std::min(lit.far_m, ray.far_m))
                    rows.intervals.push_back(
                        {std::max(lit.near_m, ray.near_m), std::min(lit.far_m, ray.far_m), lit.transmittance});
            rows.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    LitInterval sliver_;
    float rest_m_;
    Statistics statistics_;
};
} // namespace
// Seen to fail (1e-4) where a sliver counted as if it were long, and where one behind a veil did as if there were none.
TEST_CASE("rays far into thick fog send what slivers of light in front of it do, and what is behind") {
    SceneRandom random(23);
    int from_behind_count = 0;
    for (std::uint32_t round = 0; round < 150; ++round) {
        CAPTURE(round);
        Medium fog = random_medium(random, round % 2 == 0);
        const float denser = std::pow(10.0f, random.uniform(-1.0f, 1.5f));
        for (ScatterLobe& lobe : fog.lobes)
            lobe.sigma_s_per_m *= denser;
        fog.sigma_a_per_m *= denser;
        std::vector<FogBox> boxes{{{0, 0, 0}, {4000, 4000, 4000}, fog}};
        if (round % 3 == 0)
            boxes.push_back({{1, 2, 0}, {3, 2, 4}, random_medium(random, false)});
        const auto scene = scene_of(boxes);
        Progress progress;
        const Media media(*scene, progress);
        const Rgb sigma_t = fog.sigma_t_per_m();
        const float least = std::min({sigma_t.x, sigma_t.y, sigma_t.z});
        const vec3 position = std::min(10.0f, 8.0f / least) * random.direction();
        const Light lamp{.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(1.0f), .position = position};
        const LightSample sample = sample_light(lamp, 0, vec3(0.5f));
        const float sliver_m = std::pow(10.0f, random.uniform(-6.0f, 0.0f)), begin_m = random.uniform(0.0f, 1.0f);
        const LitInterval sliver{begin_m, begin_m + sliver_m, Rgb(std::pow(10.0f, random.uniform(-8.0f, 0.0f)))};
        const float rest_m = std::min(sliver.far_m + random.uniform(0.0f, 25.0f / least), 2500.0f);
        const Sliver visibility(sliver, rest_m);
        MediaRays rays{media, {}, {0}, {}};
        const vec3 beside =
            glm::normalize(position + random.uniform(0.01f, 0.5f) * glm::length(position) * random.direction());
        rays.add({{0, 0, 0}, beside, 0.0f, 3000.0f});
        const dvec3 direction(beside);
        const dvec3 of_sliver =
            dvec3(sliver.transmittance) * integral(boxes, sample, dvec3(0.0), direction, sliver.near_m, sliver.far_m);
        const dvec3 of_rest =
            integral(boxes, sample, dvec3(0.0), direction, rest_m, std::min(3000.0f, rest_m + 60.0f / least));
        from_behind_count += of_rest.x > 0.01 * of_sliver.x;
        const dvec3 radiance(rays.ask(sample, &visibility)[0]), expected = of_sliver + of_rest;
        CHECK(glm::length(radiance - expected) <= 3e-5 * glm::length(expected));
    }
    CHECK(from_behind_count > 30);
    CHECK(from_behind_count < 130);
}
} // namespace local_scatter_test
