// SPDX-License-Identifier: GPL-3.0-or-later
// A shape of cells in a scene is met, shaded and left as a mesh of the same boxes is.
#include "scene/moved_instances.hpp"
#include "support/box_shape.hpp"
#include <doctest/doctest.h>

namespace cell_geometry_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
struct Both {
    std::unique_ptr<Scene> shapes, meshes;
    explicit Both(const BoxScene& boxes) {
        const auto shape = std::make_shared<const BoxShape>(scattered_cells(60, 6, 3), 0.25f);
        shapes = boxes.scene(shape, false);
        meshes = boxes.scene(shape, true);
    }
};

std::vector<Ray> rays_around(std::size_t count, std::uint64_t seed) {
    SceneRandom random(seed);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
        const vec3 from = 6.0f * random.direction();
        const vec3 to{random.uniform(-3.0f, 4.5f), random.uniform(-0.5f, 2.0f), random.uniform(-0.5f, 2.0f)};
        rays.push_back({.origin = from, .direction = glm::normalize(to - from), .near_m = 0.25f});
    }
    return rays;
}
} // namespace

TEST_CASE("rays meet a turned, a mirrored and a sheared shape where they meet a mesh of its boxes") {
    const Both scenes({.places = various_places()});
    int hits = 0;
    for (const Ray& ray : rays_around(4000, 1)) {
        const Hit cell = scenes.shapes->closest_hit(ray), triangle = scenes.meshes->closest_hit(ray);
        REQUIRE(cell.is_hit() == triangle.is_hit());
        if (!cell.is_hit())
            continue;
        ++hits;
        CHECK(cell.instance == triangle.instance);
        CHECK(std::abs(cell.distance_m - triangle.distance_m) < 4e-6f * triangle.distance_m);
        CHECK(glm::dot(cell.geometric_normal, triangle.geometric_normal) > 1.0f - 1e-5f);
        const ShadingPoint point = scenes.shapes->shading_point(ray, cell);
        CHECK(glm::length(point.position - (ray.origin + cell.distance_m * ray.direction)) < 5e-6f);
        CHECK_FALSE(point.is_backface);
    }
    CHECK(hits > 1000);
}

TEST_CASE("packets of rays meet the cells, with the same bits, that the rays meet alone") {
    const Both scenes({.places = various_places()});
    const std::vector<Ray> rays = rays_around(1000, 2);
    std::vector<Hit> hits(rays.size());
    scenes.shapes->closest_hits(rays, hits);
    std::vector<Rgb> passing(rays.size());
    scenes.shapes->shadow_transmittances(rays, passing);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Hit alone = scenes.shapes->closest_hit(rays[i]);
        CHECK(hits[i].is_hit() == alone.is_hit());
        CHECK(hits[i].cell == alone.cell);
        CHECK(hits[i].distance_m == alone.distance_m);
        CHECK(passing[i] == scenes.shapes->shadow_transmittance(rays[i]));
        CHECK(passing[i] == scenes.meshes->shadow_transmittance(rays[i]));
    }
}

TEST_CASE("a ray that leaves a lone cell meets nothing, and one between two cells meets the other") {
    const mat4 place =
        glm::rotate(glm::scale(translation({5e3f, -2e3f, 70.0f}), vec3(0.3f)), 0.4f, vec3(0, 0.6f, 0.8f));
    const auto lone = std::make_shared<const BoxShape>(std::vector<glm::ivec3>{{0, 0, 0}}, 1.0f);
    const auto pair = std::make_shared<const BoxShape>(std::vector<glm::ivec3>{{0, 0, 0}, {2, 0, 0}}, 1.0f);
    const BoxScene boxes{.places = {place}};
    const auto alone = boxes.scene(lone, false), facing = boxes.scene(pair, false);
    SceneRandom random(5);
    for (int i = 0; i < 2000; ++i) {
        const vec3 centre = vec3(place * vec4(0.5f, 0.5f, 0.5f, 1.0f));
        const Ray ray{.origin = centre + 3.0f * random.direction(), .direction = vec3(0.0f)};
        const Ray towards{.origin = ray.origin, .direction = glm::normalize(centre - ray.origin)};
        const Hit hit = alone->closest_hit(towards);
        REQUIRE(hit.is_hit());
        vec3 away = random.direction();
        if (glm::dot(away, hit.geometric_normal) < 0.0f)
            away = -away;
        CHECK(alone->shadow_transmittance(alone->leaving_ray(hit, away)) == Rgb(1.0f));
    }
    const vec3 along_x = glm::normalize(vec3(place[0]));
    const vec3 between = vec3(place * vec4(1.5f, 0.4f, 0.7f, 1.0f));
    const Hit hit = facing->closest_hit({.origin = between, .direction = -along_x});
    REQUIRE(hit.is_hit());
    CHECK(facing->shadow_transmittance(facing->leaving_ray(hit, along_x)) == Rgb(0.0f));
    CHECK(facing->shadow_transmittance(facing->leaving_ray(hit, along_x, 0.2f)) == Rgb(1.0f)); // 0.3 m apart
}

TEST_CASE("a shape hides from the camera, and lets light pass, where it says so") {
    const Ray ray{.origin = {0.75f, 0.75f, 9.0f}, .direction = {0, 0, -1}};
    const auto shape = std::make_shared<const BoxShape>(scattered_cells(216, 6, 1), 0.25f);
    const BoxScene unseen{.is_camera_visible = false}, unshadowed{.casts_shadow = false};
    CHECK_FALSE(unseen.scene(shape, false)->closest_hit(ray).is_hit());
    CHECK(unseen.scene(shape, false)->shadow_transmittance(ray) == Rgb(0.0f));
    CHECK(unshadowed.scene(shape, false)->closest_hit(ray).is_hit());
    CHECK(unshadowed.scene(shape, false)->shadow_transmittance(ray) == Rgb(1.0f));
    const std::uint64_t of_shape = 2;
    CHECK(BoxScene{}.scene(shape, false)->shadow_transmittance(ray, std::span(&of_shape, 1), 2) == Rgb(1.0f));
    CHECK(BoxScene{}.scene(shape, false)->shadow_transmittance(ray, std::span(&of_shape, 1), 1) == Rgb(0.0f));
}

TEST_CASE("voxels are opaque, which is said where their material is not; a material without a surface hides them") {
    const Ray ray{.origin = {0.75f, 0.75f, 9.0f}, .direction = {0, 0, -1}};
    const auto shape = std::make_shared<const BoxShape>(scattered_cells(216, 6, 1), 0.25f);
    SceneDescription description = BoxScene{}.description(shape, false);
    description.materials[0].constant.transparent = Rgb(0.5f);
    const Scene half(description, Progress());
    CHECK(half.shadow_transmittance(ray) == Rgb(0.0f));
    CHECK(half.closures(ray, half.closest_hit(ray)).transparent == Rgb(0.0f));
    REQUIRE(half.statistics().reports.size() == 1);
    CHECK(half.statistics().reports[0] ==
          "object 'boxes': its material lets a part of the light pass, but voxels are opaque");
    description.materials[0] = Material{.name = "fog"};
    description.materials[0].has_surface = false;
    CHECK_FALSE(Scene(description, Progress()).closest_hit(ray).is_hit());
}

TEST_CASE("a shape without a cell, or without a place, is left out and named") {
    const auto none = std::make_shared<const BoxShape>(std::vector<glm::ivec3>{}, 1.0f);
    CHECK(BoxScene{}.scene(none, false)->statistics().reports[0] == "object 'boxes' left out: it has no voxel");
    const auto one = std::make_shared<const BoxShape>(std::vector<glm::ivec3>{{0, 0, 0}}, 1.0f);
    const BoxScene nowhere{.places = {mat4(std::numeric_limits<float>::quiet_NaN())}};
    CHECK(nowhere.scene(one, false)->statistics().reports[0] == "object 'boxes' left out: its transform is not finite");
    SceneDescription description = BoxScene{}.description(one, false);
    description.placed_shapes[0].shape_index = 7;
    CHECK_THROWS_WITH_AS(Scene(description, Progress()), "object 'boxes' asks for shape 7 of 1", InvalidInput);
}

TEST_CASE("a scene is around its shapes, and one whose shapes moved is another scene") {
    const auto one = std::make_shared<const BoxShape>(std::vector<glm::ivec3>{{0, 0, 0}}, 1.0f);
    SceneDescription before = BoxScene{.places = {translation({4, 5, 6})}}.description(one, false);
    CHECK(Scene(before, Progress()).surface_bounds().min == vec3(4, 5, 6));
    CHECK(Scene(before, Progress()).bounds().max == vec3(5, 6, 7));
    SceneDescription after = before;
    CHECK(moved_instances(before, after).has_value());
    after.placed_shapes[0].world_from_object = translation({4, 5, 7});
    CHECK_FALSE(moved_instances(before, after).has_value());
}
} // namespace cell_geometry_test
