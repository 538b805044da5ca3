// SPDX-License-Identifier: GPL-3.0-or-later
// Batches of smooth pieces against a quadrature that knows nothing of pieces: it cuts the angle under which the light sees
// a ray into hundreds of panels, asks each point for its media box by box, in doubles, and finds a cone's edge by bisection.
#include "core/simd.hpp"
#include "light_shafts/local_scatter.hpp"
#include "support/soup.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
struct FogBox {
    dvec3 centre, half;
    Medium medium;
};
/// A scene of fog boxes with the media index of each box.
std::unique_ptr<Scene> scene_of(const std::vector<FogBox>& boxes) {
    std::vector<support::Part> parts;
    std::vector<Medium> media;
    for (const FogBox& box : boxes) {
        parts.push_back(
            {.mesh = support::cube(),
             .world_from_object = support::translation(vec3(box.centre)) * glm::scale(mat4(1.0f), vec3(box.half)),
             .material = {.name = "fog", .medium_index = static_cast<int>(media.size()), .has_surface = false}});
        media.push_back(box.medium);
    }
    return support::make_scene(parts, media, {});
}

/// Length of from + s step, s in [0, 1], inside the box.
double length_inside(const FogBox& box, const dvec3& from, const dvec3& step) {
    double low = 0.0, high = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = box.centre[axis] - box.half[axis] - from[axis], b = a + 2.0 * box.half[axis];
        if (step[axis] == 0.0) {
            if (a > 0.0 || b < 0.0)
                return 0.0;
            continue;
        }
        low = std::max(low, std::min(a / step[axis], b / step[axis]));
        high = std::min(high, std::max(a / step[axis], b / step[axis]));
    }
    return low < high ? (high - low) * glm::length(step) : 0.0;
}
dvec3 optical_depth(const std::vector<FogBox>& boxes, const dvec3& from, const dvec3& to) {
    dvec3 depth(0.0);
    for (const FogBox& box : boxes)
        depth += dvec3(box.medium.sigma_t_per_m()) * length_inside(box, from, to - from);
    return depth;
}

double spot_share(const Light& spot, const dvec3& from_light) {
    const double cos_half = std::cos(double{spot.spot_half_angle_rad}), smooth = (1.0 - cos_half) * spot.spot_blend;
    const bool is_old = spot.spot_falloff == SpotFalloff::Blender3;
    const dvec3 in_light = glm::normalize(glm::dmat3(spot.light_from_world_directions) * from_light);
    const double cosine = is_old ? glm::dot(from_light, dvec3(spot.spot_axis)) : -in_light.z;
    if (cosine <= cos_half)
        return 0.0;
    const double rise = smooth > 0.0 ? std::min(1.0, (cosine - cos_half) / smooth) : 1.0;
    return rise * rise * (3.0 - 2.0 * rise) * (is_old ? cosine : 1.0);
}

/// What one point of the ray sends to its origin per metre, without the strength.
dvec3 scattered_at(const std::vector<FogBox>& boxes, const LightSample& light, const dvec3& origin,
                   const dvec3& direction, double t) {
    const dvec3 point = origin + t * direction, way = point - dvec3(light.position), to_point = glm::normalize(way);
    double intensity = light.spot != nullptr ? spot_share(*light.spot, to_point) : 1.0;
    if (light.emission_normal != vec3(0.0f))
        intensity *= std::max(0.0, glm::dot(to_point, dvec3(light.emission_normal)));
    if (intensity == 0.0)
        return dvec3(0.0);
    const dvec3 softened = way - dvec3(light.falloff_offset);
    intensity /= glm::dot(softened, softened) + double{light.softening_m2};
    dvec3 scatter(0.0);
    const double cosine = -glm::dot(to_point, direction);
    for (const FogBox& box : boxes) {
        if (glm::any(glm::greaterThan(glm::abs(point - box.centre), box.half)))
            continue;
        for (const ScatterLobe& lobe : box.medium.lobes) {
            const double g = lobe.asymmetry_g;
            scatter += dvec3(lobe.sigma_s_per_m) * (1.0 - g * g) /
                       (4.0 * std::numbers::pi * std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
        }
    }
    return intensity * scatter *
           glm::exp(-optical_depth(boxes, origin, point) - optical_depth(boxes, point, dvec3(light.position)));
}

/// Gauss's 3 points on panels of the angle, cut where the light begins and ends.
dvec3 integral(const std::vector<FogBox>& boxes, const LightSample& light, const dvec3& origin, const dvec3& direction,
               double near, double far) {
    const double light_x = glm::dot(dvec3(light.position) - origin, direction);
    const double light_y =
        std::hypot(glm::length(origin + light_x * direction - dvec3(light.position)), std::sqrt(light.softening_m2));
    const auto panel = [&](double a, double b) {
        dvec3 sum(0.0);
        for (const auto [node, weight] :
             {dvec2(-std::sqrt(0.6), 5.0 / 18.0), dvec2(0.0, 8.0 / 18.0), dvec2(std::sqrt(0.6), 5.0 / 18.0)}) {
            const double angle = 0.5 * (a + b) + 0.5 * (b - a) * node, tangent = std::tan(angle);
            sum += weight * (b - a) * light_y * (1.0 + tangent * tangent) *
                   scattered_at(boxes, light, origin, direction, light_x + light_y * tangent);
        }
        return sum;
    };
    const auto is_lit = [&](double angle) {
        return scattered_at(boxes, light, origin, direction, light_x + light_y * std::tan(angle)) != dvec3(0.0);
    };
    const double from = std::atan2(near - light_x, light_y), to = std::atan2(far - light_x, light_y);
    constexpr int panel_count = 6000;
    dvec3 sum(0.0);
    for (int index = 0; index < panel_count; ++index) {
        double a = from + (to - from) * index / panel_count, b = from + (to - from) * (index + 1) / panel_count;
        const bool begins = is_lit(a + 1e-12 * (b - a)), ends = is_lit(b - 1e-12 * (b - a));
        if (begins != ends) {
            double dark = begins ? b : a, lit = begins ? a : b;
            for (int step = 0; step < 50; ++step)
                (is_lit(0.5 * (dark + lit)) ? lit : dark) = 0.5 * (dark + lit);
            (begins ? b : a) = lit;
        }
        sum += panel(a, b);
    }
    return sum;
}

/// A view ray with its media, and a light, ready to be asked.
struct Rays {
    const Media& media;
    std::vector<ViewRay> rays;
    std::vector<std::uint32_t> first{0};
    std::vector<MediumSegment> segments;

    void add(const ViewRay& ray) {
        rays.push_back(ray);
        media.segments({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = ray.far_m},
                       segments);
        first.push_back(static_cast<std::uint32_t>(segments.size()));
    }
    [[nodiscard]] std::vector<Rgb> ask(const LightSample& light, const Visibility* visibility = nullptr) const {
        LocalRays local;
        local.assign(media, rays, first, segments);
        std::vector<Rgb> radiance(rays.size(), Rgb(0.0f));
        LocalScatter(media, light, true).add_scattered(local, visibility, radiance, {});
        return radiance;
    }
};

Rgb random_rgb(support::SceneRandom& random, float most) {
    return {random.uniform(0.0f, most), random.uniform(0.0f, most), random.uniform(0.0f, most)};
}
Medium random_medium(support::SceneRandom& random, bool is_grey) {
    Medium medium{.name = "fog", .lobes = {{random_rgb(random, 0.2f), random.uniform(-0.9f, 0.9f)}}};
    if (random.uniform() < 0.3f)
        medium.lobes.push_back({random_rgb(random, 0.1f), random.uniform(-0.9f, 0.9f)});
    medium.sigma_a_per_m = random_rgb(random, 0.1f);
    if (is_grey) {
        for (ScatterLobe& lobe : medium.lobes)
            lobe.sigma_s_per_m = Rgb(lobe.sigma_s_per_m.x);
        medium.sigma_a_per_m = Rgb(medium.sigma_a_per_m.x);
    }
    return medium;
}

/// The kinds of local lights: a point, strata of soft lamps, spots, narrow, wide, scaled, old and new.
std::vector<Light> lights_at(const vec3& position, support::SceneRandom& random) {
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
            if (random.uniform() < 0.3f)
                spot.light_from_world_directions =
                    mat3(glm::scale(mat4(1.0f), vec3(1.0f, 1.5f, 0.8f))) * spot.light_from_world_directions;
            lights.push_back(spot);
        }
    return lights;
}

/// Lets light through on [from, to) of every `period_m` of a ray, and remembers what it was asked.
class Stripes final : public Visibility {
public:
    Stripes(float from_m, float to_m, float period_m) : from_m_(from_m), to_m_(to_m), period_m_(period_m) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const override {
        for (const ViewRay& ray : rays) {
            asked.push_back(ray);
            for (float t = 0.0f; t < ray.far_m; t += period_m_) {
                const float near_m = std::max(ray.near_m, t + from_m_), far_m = std::min(ray.far_m, t + to_m_);
                if (near_m < far_m)
                    rows.intervals.push_back({.near_m = near_m, .far_m = far_m});
            }
            rows.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }
    mutable std::vector<ViewRay> asked;

private:
    float from_m_, to_m_, period_m_;
    Statistics statistics_;
};

/// Rays from anywhere in a box of 10 m, every other one past the light at a thousandth to a half of the way.
void add_random_rays(Rays& rays, const vec3& light, int count, support::SceneRandom& random) {
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
        {{1, 0.5, 0}, {2, 1.5, 1}, {.name = "smoke", .lobes = {{Rgb(0.3f), -0.4f}}}}};
    std::unique_ptr<Scene> scene = scene_of(boxes);
    Progress progress;
    Media media{*scene, progress};
    Rays rays{media, {}, {0}, {}};
    explicit Nest(const vec3& light) {
        support::SceneRandom random(3);
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
    support::SceneRandom random(11);
    for (int round = 0; round < 12; ++round) {
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
            const LightSample sample = sample_light(light, 0, vec2(random.uniform(), random.uniform()));
            Rays rays{media, {}, {0}, {}};
            add_random_rays(rays, sample.position, 8, random);
            const std::vector<Rgb> radiance = rays.ask(sample);
            for (std::size_t ray = 0; ray < radiance.size(); ++ray) {
                const ViewRay& asked = rays.rays[ray];
                dvec3 expected(0.0);
                for (std::uint32_t at = rays.first[ray]; at < rays.first[ray + 1]; ++at)
                    expected += integral(boxes, sample, dvec3(asked.origin), dvec3(asked.direction),
                                         rays.segments[at].near_m, rays.segments[at].far_m);
                expected *= dvec3(sample.strength);
                CHECK(glm::length(dvec3(radiance[ray]) - expected) <= 5e-5 * glm::length(expected) + 1e-15);
            }
        }
    }
}
TEST_CASE("a ray's bits do not depend on the rays beside it") {
    const Light spot = narrow_spot();
    const LightSample light = sample_light(spot, 0, vec2(0.5f));
    const Nest nest(light.position);
    const std::vector<Rgb> together = nest.rays.ask(light);
    for (std::size_t ray = 0; ray < together.size(); ++ray) {
        Rays alone{nest.media, {}, {0}, {}};
        alone.add(nest.rays.rays[ray]);
        CHECK(alone.ask(light)[0] == together[ray]);
    }
}
TEST_CASE("what is lit and what is dark add up to the whole, on every instruction set") {
    Light lamp{.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(3.0f, 2.0f, 1.0f), .position = {1, 2, -3}};
    lamp.radius_m = 0.2f;
    const Stripes lit(0.0f, 0.3f, 0.5f), dark(0.3f, 0.5f, 0.5f);
    for (const Light& light : {lamp, narrow_spot()}) {
        const LightSample sample = sample_light(light, 0, vec2(0.3f, 0.6f));
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
TEST_CASE(
    "only what the cone holds is asked for shadows, unless the lit length is wanted, which counts all of the ray") {
    const Light spot = narrow_spot();
    const LightSample light = sample_light(spot, 0, vec2(0.5f));
    const Nest nest(light.position);
    LocalRays local;
    local.assign(nest.media, nest.rays.rays, nest.rays.first, nest.rays.segments);
    const LocalScatter scatter(nest.media, light, true);
    std::vector<Rgb> radiance(local.size(), Rgb(0.0f)), again = radiance;
    std::vector<float> lit_length_m(local.size(), 0.0f);
    const Stripes sparing(0.0f, 0.5f, 0.5f), generous(0.0f, 0.5f, 0.5f);
    scatter.add_scattered(local, &sparing, radiance, {});
    scatter.add_scattered(local, &generous, again, lit_length_m);
    CHECK(sparing.asked.size() < local.size() / 2);
    for (const ViewRay& ray : sparing.asked)
        for (const float at_m : {ray.near_m, ray.far_m}) {
            const vec3 from_light = ray.origin + at_m * ray.direction - light.position;
            CHECK(std::acos(glm::dot(glm::normalize(from_light), light.spot->spot_axis)) < 0.2f + 1e-3f);
        }
    CHECK(generous.asked.size() == local.size());
    for (std::size_t ray = 0; ray < local.size(); ++ray) {
        CHECK(glm::length(radiance[ray] - again[ray]) <= 3e-5f * glm::length(again[ray]) + 1e-12f);
        float length_m = 0.0f;
        for (const LocalRays::Segment& segment : local.segments_of(ray))
            length_m += segment.far_m - segment.near_m;
        CHECK(std::abs(lit_length_m[ray] - length_m) <= 1e-5f * length_m);
    }
}
