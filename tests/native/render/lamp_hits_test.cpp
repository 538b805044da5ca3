// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that meet a lamp by chance and rays that are aimed at it are two halves of one estimate: they must know each other's
// densities, and agree about what the lamp is.
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "render/lamp_hits.hpp"
#include "render/pixel_samples.hpp"
#include "support/area_lights.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>
#include <string>
#include <vector>

namespace lamp_hits_test {
using namespace tyndall;

namespace {
struct Case {
    std::string name;
    Light light;
};
std::vector<Case> cases() {
    std::vector<Case> result;
    for (const bool is_ellipse : {false, true})
        for (const float half_spread_rad : {1.5707964f, 0.6f}) {
            Light area = support::area_light({0.7f, 0.3f});
            area.is_ellipse = is_ellipse;
            area.spot_half_angle_rad = half_spread_rad;
            result.push_back({(is_ellipse ? "ellipse " : "rectangle ") + std::to_string(half_spread_rad), area});
        }
    for (const LightBody body : {LightBody::Sphere, LightBody::FacingDisc}) {
        Light point;
        point.kind = LightKind::Point;
        point.position = {1, 2, 3};
        point.radius_m = 0.4f;
        point.body = body;
        point.spot_axis = glm::normalize(vec3(0.3f, -0.5f, -0.8f));
        result.push_back({body == LightBody::Sphere ? "sphere" : "disc", point});
    }
    return result;
}
/// Near and far, before the middle and beside it.
std::vector<vec3> points_before(const Light& light) {
    std::vector<vec3> result;
    for (const auto& [foot, height_m] :
         {std::pair{vec2(0, 0), 0.5f}, {vec2(0.3f, 0.1f), 0.6f}, {vec2(1.2f, 0.4f), 1.3f}, {vec2(0.3f, 0.9f), 12.0f}})
        result.push_back(support::before(light, foot, height_m));
    return result;
}
/// Even over a cone that holds all directions to the lamp.
struct Cone {
    vec3 axis;
    float one_minus_cos;
};
Cone cone_around(const Light& light, const vec3& position) {
    const vec3 way = light.position - position;
    const float radius_m = std::max(light.radius_m, glm::length(light.half_size_m)), distance_m = glm::length(way);
    const float sine = radius_m / distance_m;
    return {way / distance_m, sine < 1.0f ? 1.0f - std::sqrt(1.0f - sine * sine) : 1.0f};
}
constexpr std::uint32_t ray_count = 1 << 16;
} // namespace

// Seen to fail without the spread's reach, and with the solid angle of the whole box.
TEST_CASE("the density with which a lamp is aimed at integrates to one over the rays that meet it") {
    for (const auto& [name, light] : cases()) {
        if (light.is_ellipse)
            continue; // near by, rays are aimed at its box, of which the corners are dark
        const render::LightAim aim(light);
        for (const vec3& position : points_before(light)) {
            CAPTURE(name);
            CAPTURE(glm::length(position - light.position));
            const Cone cone = cone_around(light, position);
            double sum = 0.0;
            for (std::uint32_t i = 0; i < ray_count; ++i) {
                const vec3 direction =
                    from_frame(cone.axis, sample_uniform_cone(sobol_point(i, 7), cone.one_minus_cos));
                sum += render::lamp_hit(aim.form(), position, direction).pdf_per_sr;
            }
            const double per_sr = uniform_cone_pdf_per_sr(cone.one_minus_cos);
            CHECK(std::abs(sum / ray_count / per_sr - 1.0) < 0.01);
        }
    }
}
// Seen to fail with the ellipse's corners shining.
TEST_CASE("rays that meet a lamp bring what rays that are aimed at it bring") {
    const auto through_glass = [](float cosine) { return 1.0f + 5.0f * std::pow(cosine, 4.0f); };
    for (const auto& [name, light] : cases()) {
        const render::LightAim aim(light);
        for (const vec3& position : points_before(light)) {
            CAPTURE(name);
            CAPTURE(glm::length(position - light.position));
            const vec3 normal = glm::normalize(light.position - position + vec3(0.1f, 0.2f, -0.1f));
            const Cone cone = cone_around(light, position);
            double met = 0.0, aimed = 0.0;
            for (std::uint32_t i = 0; i < ray_count; ++i) {
                const vec3 direction =
                    from_frame(cone.axis, sample_uniform_cone(sobol_point(i, 7), cone.one_minus_cos));
                const float cosine = std::max(0.0f, glm::dot(direction, normal));
                const render::LampHit hit = render::lamp_hit(aim.form(), position, direction);
                if (hit.pdf_per_sr > 0.0f)
                    met += hit.radiance_per_strength * cosine * through_glass(cosine) /
                           uniform_cone_pdf_per_sr(cone.one_minus_cos);
            }
            for (std::uint32_t i = 0; i < ray_count / 16; ++i) {
                render::LitPoints points;
                for (std::uint32_t lane = 0; lane < 16; ++lane)
                    points.set(lane, position, normal, {.position = position, .normal = normal, .offset_m = 0.0f},
                               hash(lane));
                render::AimedRays rays;
                const render::LaneSet lit = aim.aim(points, {.sample_index = i, .pair_index = 0}, rays);
                for (std::uint32_t lane = 0; lane < 16; ++lane)
                    if ((lit >> lane & 1) != 0)
                        aimed += rays.weight[lane] * through_glass(glm::dot(rays.direction.get(lane), normal));
            }
            CHECK(aimed > 0.0);
            CHECK(std::abs(met / aimed - 1.0) < 0.01);
        }
    }
}
} // namespace lamp_hits_test
