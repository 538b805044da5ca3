// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/sobol.hpp"
#include "scene/scene.hpp"
#include "shading/op_inputs.hpp"
#include "support/close_to.hpp"
#include "support/partial_materials.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

namespace scene_test {
using namespace tyndall;
using namespace tyndall::support;

TEST_CASE("a ray meets the nearest surface, at its distance, with the normal that its winding says") {
    const auto scene = make_scene({{.mesh = square(), .world_from_object = translation({0, 0, 1})},
                                   {.mesh = square(), .world_from_object = translation({0, 0, 2})}});
    const Hit hit = scene->closest_hit({.origin = {0.1f, 0.2f, 5}, .direction = {0, 0, -1}});
    CHECK(hit.is_hit());
    CHECK(hit.instance == 1);
    CHECK(std::abs(hit.distance_m - 3.0f) < 1e-6f); // CPUs differ in its last bits
    CHECK(hit.geometric_normal == vec3(0, 0, 1));
}
TEST_CASE("a mirrored instance keeps its normal outside") {
    const mat4 mirror = glm::scale(mat4(1.0f), vec3(-2, 1, 1));
    const auto scene = make_scene({{.mesh = square(), .world_from_object = mirror}});
    CHECK(scene->closest_hit({.origin = {0, 0.1f, 5}, .direction = {0, 0, -1}}).geometric_normal == vec3(0, 0, 1));
}
TEST_CASE("a fog box is never met, neither by the camera nor by a shadow ray") {
    Material fog{.name = "fog", .medium_index = 0, .has_surface = false};
    const auto scene = make_scene({{.mesh = square(), .material = fog}}, {Medium{.name = "fog"}});
    const Ray ray{.origin = {0, 0, 5}, .direction = {0, 0, -1}};
    CHECK(!scene->closest_hit(ray).is_hit());
    CHECK(scene->shadow_transmittance(ray) == Rgb(1.0f));
    CHECK(scene->surface_bounds().is_empty());
    CHECK(!scene->bounds().is_empty());
}
TEST_CASE("transparent surfaces multiply, an opaque one ends the ray") {
    const auto glass = [](Rgb transparent) {
        return Material{.name = "glass", .constant = {.diffuse_albedo = Rgb(0.0f), .transparent = transparent}};
    };
    const Ray down{.origin = {0.1f, 0.2f, 5}, .direction = {0, 0, -1}};
    const Part red{.mesh = square(), .world_from_object = translation({0, 0, 1}), .material = glass({0.5f, 0.25f, 0})};
    const Part grey{.mesh = square(), .world_from_object = translation({0, 0, 2}), .material = glass(Rgb(0.5f))};
    const Part wall{.mesh = square(), .world_from_object = translation({0, 0, 3})};
    CHECK(make_scene({red, grey})->shadow_transmittance(down) == Rgb(0.25f, 0.125f, 0));
    CHECK(make_scene({red, wall, grey})->shadow_transmittance(down) == Rgb(0.0f));
}

/// Two triangles side by side in the plane z = 0: x < 0 has slot 0, x > 0 has slot 1.
static std::shared_ptr<const TriangleMesh> two_slots() {
    return mesh_of({.name = "two slots",
                    .positions = {{-1, -1, 0}, {0, 0, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}},
                    .triangles = {{0, 1, 2}, {3, 4, 1}},
                    .material_slots = {0, 1}});
}
static std::unique_ptr<Scene> scene_of_slots(Material left, Material right) {
    SceneDescription description;
    description.meshes = {two_slots()};
    description.materials = {std::move(left), std::move(right)};
    description.slot_materials = {0, 1};
    description.object_names = {"object"};
    description.instances = {{.slot_count = 2}};
    return std::make_unique<Scene>(std::move(description), Progress());
}
constexpr Ray left_down{.origin = {-0.5f, 0, 5}, .direction = {0, 0, -1}};
constexpr Ray right_down{.origin = {0.5f, 0, 5}, .direction = {0, 0, -1}};

TEST_CASE("a slot without a surface is a hole in an object that has one elsewhere") {
    const auto scene = scene_of_slots({.name = "fog", .has_surface = false}, {.name = "white"});
    CHECK(!scene->closest_hit(left_down).is_hit());
    CHECK(scene->closest_hit(right_down).is_hit());
    CHECK(scene->shadow_transmittance(left_down) == Rgb(1.0f));
    CHECK(scene->shadow_transmittance(right_down) == Rgb(0.0f));
}
TEST_CASE("each triangle has the material of its slot, and the last one where its slot does not exist") {
    const auto scene = scene_of_slots({.name = "left"}, {.name = "right"});
    CHECK(scene->material(0, scene->closest_hit(left_down).triangle).name == "left");
    CHECK(scene->material(0, scene->closest_hit(right_down).triangle).name == "right");
    const auto one_slot = make_scene({{.mesh = two_slots(), .material = {.name = "only"}}});
    CHECK(one_slot->material(0, 1).name == "only");
}
TEST_CASE("a leaf lets light through where its texture's alpha says so, to the same bits at any number of threads") {
    auto mask = std::make_shared<Texture>(); // left half solid, right half 0.25
    mask->width = 2;
    mask->height = 1;
    mask->floats = {1, 1, 1, 1, 1, 1, 1, 0.25f};
    mask->has_alpha = true;
    mask->interpolation = TextureInterpolation::Closest;
    Material leaf{.name = "leaf"};
    leaf.textures = {mask};
    leaf.uv_map_names = {""};
    leaf.program = {{.code = SurfaceOp::Code::TextureAlpha, .out = 0},
                    {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(1.0f)},
                    {.code = SurfaceOp::Code::Subtract, .out = 2, .a = 1, .b = 0}};
    leaf.diffuse_register = 0;
    leaf.transparent_register = 2;
    leaf.emission_register = 3;
    const auto scene = make_scene({{.mesh = square(), .material = leaf},
                                   {.mesh = square(), .world_from_object = translation({0, 0, -1}), .material = leaf}});
    CHECK(scene->shadow_transmittance(left_down) == Rgb(0.0f));
    CHECK(scene->shadow_transmittance(right_down) == Rgb(0.75f * 0.75f));
    const Hit hit = scene->closest_hit(right_down);
    CHECK(scene->closures(right_down, hit).transparent == Rgb(0.75f));
    CHECK(scene->transparency(right_down, hit) == Rgb(0.75f));
    const auto transmittances = [&](int thread_count) {
        std::vector<float> result(4096);
        with_threads(thread_count, [&] {
            parallel_for(result.size(), Progress(), [&](std::size_t index) {
                const vec2 p = 2.0f * sobol_point(static_cast<std::uint32_t>(index), 1) - 1.0f;
                result[index] = scene->shadow_transmittance({.origin = {p, 5}, .direction = {0, 0, -1}}).x;
            });
        });
        return result;
    };
    CHECK(transmittances(1) == transmittances(0));
}
// Seen to fail where a normal that is in the scene was taken into it once more.
TEST_CASE("which side of a turned surface lets light pass is one for what is met and for rays to light") {
    const auto triangle =
        mesh_of({.name = "triangle", .positions = {{-9, -9, 0}, {9, -9, 0}, {0, 12, 0}}, .triangles = {{0, 1, 2}}});
    int passing = 0, stopping = 0;
    for (std::uint32_t index = 0; index < 60; ++index) {
        const vec3 axis = glm::normalize(vec3(sobol_point(index, 1), 0.3f) - 0.4f);
        const mat4 turned = glm::rotate(mat4(1.0f), 0.1f * static_cast<float>(index), axis);
        const auto scene = make_scene({{.mesh = triangle, .world_from_object = turned, .material = one_way()}});
        const vec3 normal(turned * vec4(0, 0, 1, 0));
        for (const float side : {-1.0f, 1.0f}) {
            const Ray ray{.origin = side * normal, .direction = -side * normal};
            const Hit hit = scene->closest_hit(ray);
            REQUIRE(hit.is_hit());
            const Rgb through(side < 0.0f ? 1.0f : 0.0f); // by its back
            CHECK(scene->closures(ray, hit).transparent == through);
            CHECK(scene->transparency(ray, hit) == through);
            CHECK(scene->shadow_transmittance(ray) == through);
            (through == Rgb(0.0f) ? stopping : passing) += 1;
        }
    }
    CHECK(passing == stopping);
}

// Seen to fail with the edges left as they are in the object.
TEST_CASE("a material reads how far the nearest edge is, in the world, where its mesh is turned and stretched") {
    Material wires{.name = "wires"};
    wires.program = {
        {.code = SurfaceOp::Code::Input, .option = static_cast<std::uint8_t>(PointInput::EdgeDistance), .out = 1}};
    wires.emission_register = wires.transparent_register = 1;
    const mat4 placed = translation({0.3f, -0.2f, 0.1f}) *
                        glm::scale(glm::rotate(mat4(1.0f), 0.5f, vec3(0.6f, 0, 0.8f)), vec3(1.5f, 0.4f, 2.0f));
    const auto triangle = mesh_of({.name = "triangle",
                                   .positions = {{-1, -1, 0}, {1.2f, -0.8f, 0.1f}, {0.1f, 1.4f, 0.3f}},
                                   .triangles = {{0, 1, 2}}});
    const auto scene = make_scene({{.mesh = triangle, .world_from_object = placed, .material = wires}});
    int found = 0;
    for (std::uint32_t index = 0; index < 200; ++index) {
        const Ray ray{.origin = {3.0f * sobol_point(index, 1) - 1.5f, 5}, .direction = {0, 0, -1}};
        const Hit hit = scene->closest_hit(ray);
        if (!hit.is_hit())
            continue;
        ++found;
        const vec3 point = ray.origin + hit.distance_m * ray.direction;
        float nearest = std::numeric_limits<float>::infinity();
        for (std::size_t edge = 0; edge < 3; ++edge) {
            const vec3 a(placed * vec4(triangle->arrays().positions[edge], 1.0f)),
                b(placed * vec4(triangle->arrays().positions[(edge + 1) % 3], 1.0f));
            nearest = std::min(nearest, glm::length(glm::cross(glm::normalize(b - a), point - a)));
        }
        CHECK(scene->closures(ray, hit).emission.x == close_to(nearest, 1e-3).scale(1e-3));
        CHECK(scene->transparency(ray, hit).x == scene->closures(ray, hit).emission.x);
    }
    CHECK(found > 20);
}
TEST_CASE("camera rays and shadow rays each see their own instances") {
    const auto scene =
        make_scene({{.mesh = square(), .is_camera_visible = false},
                    {.mesh = square(), .world_from_object = translation({0, 0, 1}), .casts_shadow = false}});
    CHECK(scene->closest_hit(left_down).instance == 1);
    CHECK(scene->shadow_transmittance(left_down) == Rgb(0.0f));
    CHECK(scene->shadow_transmittance({.origin = {-0.5f, 0, 5}, .direction = {0, 0, -1}, .far_m = 4.5f}) == Rgb(1.0f));
}
TEST_CASE("a mesh tells UV maps from attributes, by name or the first of its kind") {
    const SharedMeshArrays arrays = MeshArrays{.name = "painted",
                                               .uv_maps = {{"\x1frg Tint", {}},
                                                           {"UVMap", {}},
                                                           {"\x1f"
                                                            "ba Tint",
                                                            {}},
                                                           {"\x1frg Rust", {}}}};
    const auto index = [&](const std::string& name) {
        const SharedMeshArrays::UvMap* map = arrays.uv_map(name);
        return map == nullptr ? -1 : static_cast<int>(map - arrays.uv_maps.data());
    };
    CHECK(index("") == 1);
    CHECK(index("UVMap") == 1);
    CHECK(index("\x1frg ") == 0);
    CHECK(index("\x1f"
                "ba ") == 2);
    CHECK(index("\x1frg Rust") == 3);
    CHECK(index("\x1frg Moss") == -1);
    CHECK(index("Tint") == -1);
}
TEST_CASE("a mesh or a scene whose progress is cancelled throws Cancelled") {
    Progress progress;
    progress.cancel();
    CHECK_THROWS_AS(TriangleMesh(MeshArrays{.name = "square"}, progress), Cancelled);
    SceneDescription description;
    CHECK_THROWS_AS(Scene(description, progress), Cancelled);
}
TEST_CASE("smooth normals are interpolated, turned to the ray's side, and flat at corners that have none") {
    MeshArrays arrays{.name = "bent", .positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
    arrays.corner_normals = {{0.6f, 0, 0.8f}, {0, 0, 0}, {0.6f, 0, 0.8f}};
    const mat4 mirror = glm::scale(mat4(1.0f), vec3(-1, 1, 1));
    const auto scene = make_scene(
        {{.mesh = mesh_of(arrays)}, {.mesh = mesh_of(arrays), .world_from_object = translation({0, 0, -9}) * mirror}});
    const auto point_at = [&](const Ray& ray) { return scene->shading_point(ray, scene->closest_hit(ray)); };
    const ShadingPoint corner = point_at({.origin = {0.0001f, 0.0001f, 1}, .direction = {0, 0, -1}});
    CHECK(glm::distance(corner.shading_normal, vec3(0.6f, 0, 0.8f)) < 1e-3f);
    CHECK(!corner.is_backface);
    const ShadingPoint flat = point_at({.origin = {0.9999f, 0.00001f, 1}, .direction = {0, 0, -1}});
    CHECK(glm::distance(flat.shading_normal, vec3(0, 0, 1)) < 1e-3f);
    const ShadingPoint below = point_at({.origin = {0.0001f, 0.0001f, -1}, .direction = {0, 0, 1}});
    CHECK(below.is_backface);
    CHECK(glm::distance(below.shading_normal, vec3(-0.6f, 0, -0.8f)) < 1e-3f);
    const ShadingPoint mirrored = point_at({.origin = {-0.0001f, 0.0001f, -8}, .direction = {0, 0, -1}});
    CHECK(!mirrored.is_backface);
    CHECK(glm::distance(mirrored.shading_normal, vec3(-0.6f, 0, 0.8f)) < 1e-3f);
}
TEST_CASE("an instance of a nested transform lies where its vertices are sent, normals at right angles") {
    const mat4 shear =
        glm::rotate(glm::scale(glm::rotate(translation({3, 4, 5}), 0.7f, vec3(1, 0, 0)), vec3(1, 3, 0.2f)), 1.1f,
                    glm::normalize(vec3(1, 1, 1)));
    const auto scene = make_scene({{.mesh = square(), .world_from_object = shear}});
    const vec3 target(shear * vec4(0.25f, -0.5f, 0, 1)), edge_x(shear[0]), edge_y(shear[1]);
    const vec3 origin = target + vec3(5, 3, 8);
    const Ray ray{.origin = origin, .direction = glm::normalize(target - origin)};
    const Hit hit = scene->closest_hit(ray);
    CHECK(glm::distance(scene->shading_point(ray, hit).position, target) < 2e-6f * glm::length(target));
    CHECK(std::abs(glm::dot(hit.geometric_normal, edge_x)) < 1e-6f * glm::length(edge_x));
    CHECK(std::abs(glm::dot(hit.geometric_normal, edge_y)) < 1e-6f * glm::length(edge_y));
    CHECK(glm::dot(hit.geometric_normal, glm::cross(edge_x, edge_y)) > 0.0f);
}

TEST_CASE("a scene under other lights shares all that rays meet, and lives longer than the first") {
    Light lamp{.name = "lamp", .kind = LightKind::Point, .position = {0, 0, 3}};
    Light broken = lamp;
    broken.name = "broken";
    broken.position.x = std::numeric_limits<float>::quiet_NaN();
    auto first = make_scene({{.mesh = square(), .world_from_object = mat4(0.0f)}, {.mesh = square()}}, {}, {lamp});
    const Scene relit(*first, {broken, lamp, lamp}, World("sky", Rgb(2.0f)));
    CHECK(relit.geometry() == first->geometry());
    CHECK(relit.trees().all() == first->trees().all());
    CHECK(first->lights().size() == 1);
    first.reset();
    CHECK(relit.lights().size() == 2);
    CHECK(relit.world().radiance({0, 0, 1}) == Rgb(2.0f));
    CHECK(relit.closest_hit({.origin = {0.1f, 0.2f, 5}, .direction = {0, 0, -1}}).is_hit());
    // The object that was left out, and the light of this scene.
    CHECK(relit.statistics().reports.size() == 2);
}
} // namespace scene_test
