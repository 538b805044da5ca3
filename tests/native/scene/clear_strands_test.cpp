// SPDX-License-Identifier: GPL-3.0-or-later
// Hair and points that let a part of the light pass: once for each that a ray goes through, and narrower in the air.
#include "render/passed_surface.hpp"
#include "scene/narrowed_strands.hpp"
#include "scene/scene.hpp"
#include "scene/strands.hpp"
#include "support/close_to.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace clear_strands_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
constexpr Rgb share(0.25f, 0.5f, 0.75f);
struct Kind {
    StrandForm form;
    std::uint32_t layers = 1;
};
constexpr Kind kinds[] = {{StrandForm::Ribbon},
                          {StrandForm::Round},
                          {StrandForm::Round, 2},
                          {StrandForm::RoundLinear},
                          {StrandForm::Spheres}};

/// Straight ones along Z, or balls, 1 apart, in a row.
StrandArrays row(Kind kind, int count, float radius_m) {
    const StrandForm form = kind.form;
    StrandArrays arrays{.name = "row", .form = form, .layers = kind.layers};
    for (int i = 0; i < count; ++i) {
        const auto x = static_cast<float>(i);
        if (form == StrandForm::Spheres) {
            arrays.points.emplace_back(x, 0.0f, 0.0f, radius_m);
            continue;
        }
        arrays.first_points.push_back(static_cast<std::uint32_t>(arrays.points.size()));
        for (int z = -2; z <= 2; ++z)
            arrays.points.emplace_back(x, 0.0f, static_cast<float>(z), radius_m);
    }
    return arrays;
}

std::unique_ptr<Scene> scene_of(StrandArrays arrays, bool has_fog = false) {
    SceneDescription scene;
    scene.object_names = {"hair"};
    scene.materials = {Material{.name = "clear", .constant = {.transparent = share}}};
    scene.shapes = {std::make_shared<const Strands>(std::move(arrays), Progress())};
    scene.placed_shapes.push_back({});
    if (has_fog)
        scene.media.push_back({.name = "fog"});
    return std::make_unique<Scene>(std::move(scene), Progress());
}

/// How often a ray that goes on behind what it meets meets something.
int layers(const Scene& scene, Ray ray) {
    int count = 0;
    for (Hit hit = scene.closest_hit(ray); hit.is_hit() && count < 100; hit = scene.closest_hit(ray), ++count) {
        CHECK(scene.closures(ray, hit).transparent == share);
        render::go_on_behind(ray, hit);
    }
    return count;
}

double off_axis(const Ray& ray, float x, bool is_ball) {
    const dvec3 o = dvec3(ray.origin) - dvec3(x, 0, 0), d(ray.direction);
    if (is_ball)
        return glm::length(o - glm::dot(o, d) * d);
    return std::abs(o.x * d.y - o.y * d.x) / std::hypot(d.x, d.y);
}
} // namespace

// Seen to fail: where rays on their way to light counted one layer of two.
TEST_CASE("rays pass each strand and sphere once, packets and single rays alike") {
    constexpr float radius_m = 0.3f;
    for (const Kind& kind : kinds) {
        const StrandForm form = kind.form;
        CAPTURE(static_cast<int>(form));
        CAPTURE(kind.layers);
        const auto scene = scene_of(row(kind, 4, radius_m));
        SceneRandom random(3);
        std::vector<Ray> rays;
        std::vector<int> expected;
        while (rays.size() < 3000) {
            const vec3 from = vec3(1.5f, 0.0f, 0.0f) + 9.0f * random.direction();
            const vec3 to(random.uniform(-0.5f, 3.5f), random.uniform(-0.4f, 0.4f), random.uniform(-0.3f, 0.3f));
            const Ray ray{.origin = from, .direction = glm::normalize(to - from)};
            // Ends of strands, and what rounds at their silhouettes, are not asked about.
            bool is_clear = form == StrandForm::Spheres || std::abs(ray.direction.z) < 0.2f;
            int count = 0;
            for (int i = 0; i < 4; ++i) {
                const double off = off_axis(ray, static_cast<float>(i), form == StrandForm::Spheres) / radius_m;
                count += off < 1.0;
                is_clear &= std::abs(off - 1.0) > 2e-3;
            }
            if (!is_clear)
                continue;
            rays.push_back(ray);
            expected.push_back(count);
        }
        std::vector<Rgb> passing(rays.size());
        scene->shadow_transmittances(rays, passing, {}, 0);
        int most = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            CHECK(layers(*scene, rays[i]) == expected[i]);
            const Rgb left = glm::pow(share, Rgb(static_cast<float>(kind.layers) * static_cast<float>(expected[i])));
            for (int channel = 0; channel < 3; ++channel) {
                CHECK(scene->shadow_transmittance(rays[i])[channel] == close_to(left[channel], 1e-5));
                CHECK(passing[i][channel] == close_to(left[channel], 1e-5));
            }
            most = std::max(most, expected[i]);
        }
        CHECK(most == 4);
    }
}

TEST_CASE("in the air strands are as narrow, and spheres as small, as stops as much light; without air none are made") {
    for (const Kind& kind : kinds) {
        const StrandForm form = kind.form;
        CAPTURE(static_cast<int>(form));
        CAPTURE(kind.layers);
        const auto scene = scene_of(row(kind, 3, 0.2f), true);
        const SceneDescription& description = scene->description();
        REQUIRE(description.shapes.size() == 2);
        REQUIRE(shade_of(description, description.placed_shapes[0]) == 1);
        const Strands& narrow = *description.shapes[1]->strands();
        REQUIRE(narrow.strand_count() == 3);
        const float passing = kind.layers == 2 ? average(share * share) : average(share),
                    stopped = form == StrandForm::Spheres ? std::sqrt(1.0f - passing) : 1.0f - passing;
        for (std::uint32_t segment = 0; segment < narrow.segment_count(); ++segment) {
            CHECK(narrow.on_spline(segment, 0.5f).radius_m == close_to(0.2f * stopped, 1e-5));
            CHECK(narrow.on_spline(segment, 0.5f).centre ==
                  description.shapes[0]->strands()->on_spline(segment, 0.5f).centre);
        }
        CHECK(scene_of(row(kind, 3, 0.2f))->description().shapes.size() == 1);
    }
}

TEST_CASE("widths follow what is opaque along a strand; strands of which nothing is are left out") {
    const Strands whole(row({StrandForm::Ribbon}, 2, 0.2f), Progress());
    const auto narrow = narrowed(
        whole,
        [](std::uint32_t segment, float along) {
            return segment < 4 ? 0.0f : (static_cast<float>(segment - 4) + along) / 4.0f;
        },
        Progress());
    REQUIRE(narrow->strand_count() == 1);
    for (std::uint32_t segment = 0; segment < 4; ++segment) {
        CHECK(narrow->on_spline(segment, 0.0f).centre.x == 1.0f);
        CHECK(narrow->on_spline(segment, 0.0f).radius_m == close_to(0.2f * static_cast<float>(segment) / 4.0f, 1e-5));
    }
}
} // namespace clear_strands_test
