// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/moved_instances.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <functional>
#include <random>

namespace moved_instances_test {
using namespace tyndall;
using namespace tyndall::support;

/// Two squares, of which the second may stand elsewhere.
static SceneDescription two_squares(const mat4& second_place = mat4(1.0f)) {
    static const std::shared_ptr<const TriangleMesh> mesh = square();
    SceneDescription scene;
    scene.meshes = {mesh};
    scene.object_names = {"still", "moving"};
    scene.materials = {Material{.name = "grey"}, Material{.name = "fog", .medium_index = 0, .has_surface = false}};
    scene.media = {Medium{.name = "fog", .lobes = {ScatterLobe{.sigma_s_per_m = Rgb(0.1f)}}}};
    scene.slot_materials = {0, 0, 1};
    scene.instances = {{.name_index = 0},
                       {.world_from_object = second_place, .name_index = 1, .first_slot_material = 1}};
    return scene;
}

TEST_CASE("an instance that stands elsewhere is told, with where it stood") {
    const mat4 before = translation({1, 2, 3}), after = translation({1, 2, 3.5f});
    const auto moved = moved_instances(two_squares(before), two_squares(after));
    REQUIRE(moved);
    CHECK(*moved == StoodAt{{1, {before}}});
    CHECK(moved_instances(two_squares(after), two_squares(after)) == StoodAt{});
}

TEST_CASE("whatever else differs, nothing is told: the scene is another one") {
    const std::vector<std::function<void(SceneDescription&)>> changes = {
        [](auto& scene) { scene.origin_in_world.x = 1.0; },
        [](auto& scene) { scene.meshes[0] = square(); }, // the same shape, and another mesh
        [](auto& scene) { scene.instances.pop_back(); },
        [](auto& scene) { scene.instances[0].is_camera_visible = false; },
        [](auto& scene) { scene.instances[0].casts_shadow = false; },
        [](auto& scene) { scene.instances[0].first_slot_material = 2; },
        [](auto& scene) { scene.slot_materials[0] = 1; },
        [](auto& scene) { scene.materials[0].constant.diffuse_albedo.x = 0.1f; },
        [](auto& scene) { scene.materials[0].program.emplace_back(); },
        [](auto& scene) { scene.media[0].lobes[0].asymmetry_g = 0.5f; },
        [](auto& scene) { scene.media[0].lobes[0].draine_alpha = 1.0f; },
        [](auto& scene) { scene.media[0].sigma_a_per_m = Rgb(1.0f); },
        [](auto& scene) { scene.volumes.emplace_back(); },
        [](auto& scene) { scene.world_medium_index = 0; },
        [](auto& scene) { scene.particles = {{.age = 2.0f}}; },
        [](auto& scene) { scene.instance_particles.assign(2, 0); },
        [](auto& scene) { scene.instances[1].first_slot_material = 2; },
    };
    for (std::size_t index = 0; index < changes.size(); ++index) {
        CAPTURE(index);
        SceneDescription changed = two_squares(translation({0, 0, 1}));
        changes[index](changed);
        CHECK(!moved_instances(two_squares(), changed));
    }
}

TEST_CASE("what bounds a medium is no mere surface: where it moves, the scene is another one") {
    SceneDescription before = two_squares(), after = two_squares(translation({0, 0, 1}));
    before.instances[1].first_slot_material = after.instances[1].first_slot_material = 2;
    CHECK(!moved_instances(before, after));
}

TEST_CASE("a ray that meets an instance where it stood or stands may meet the boxes, grazing or not") {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> one(-1.0f, 1.0f);
    const auto any = [&] { return vec3(one(random), one(random), one(random)); };
    std::size_t met = 0;
    for (int trial = 0; trial < 400; ++trial) {
        // Axis-aligned half of the time: then faces of the box and of the object coincide.
        const float far_m = trial % 4 == 0 ? 3000.0f : 5.0f;
        const auto place = [&] {
            const mat4 turned = trial % 2 == 0 ? mat4(1.0f) : glm::rotate(mat4(1.0f), 3.0f * one(random), any());
            return translation(far_m * any()) * turned * glm::scale(mat4(1.0f), vec3(0.3f) + 0.2f * any());
        };
        const mat4 before = place(), after = place();
        const Scene scene(two_squares(after), Progress());
        const Scene scene_before(two_squares(before), Progress());
        for (int ray_index = 0; ray_index < 50; ++ray_index) {
            const bool is_before = ray_index % 2 == 0;
            const mat4& at = is_before ? before : after;
            // Towards the square's corners and edges.
            vec3 in_object = any();
            in_object[ray_index % 4 < 2 ? 0 : 1] = ray_index % 8 < 4 ? -1.0f : 1.0f;
            const vec3 target(at * glm::vec4(in_object.x, in_object.y, 0.0f, 1.0f));
            const vec3 origin = target + 0.5f * far_m * any();
            const Ray ray{.origin = origin, .direction = glm::normalize(target - origin)};
            const MovedBoxes boxes(scene, {{1, {before}}}, origin);
            if ((is_before ? scene_before : scene).closest_hit(ray).instance != 1)
                continue;
            ++met;
            CHECK(boxes.may_meet(ray));
        }
    }
    CHECK(met > 2000);
}

TEST_CASE("rays past the boxes, away from them and short of them meet nothing") {
    const Scene scene(two_squares(translation({10, 0, 0})), Progress());
    const MovedBoxes boxes(scene, {{1, {translation({10, 0, 1})}}}, vec3(0.0f));
    CHECK(boxes.may_meet({.origin = {0, 0, 1}, .direction = {1, 0, 0}}));
    CHECK(!boxes.may_meet({.origin = {0, 0, 1}, .direction = {-1, 0, 0}}));
    CHECK(!boxes.may_meet({.origin = {0, 0, 1.1f}, .direction = {1, 0, 0}}));
    CHECK(!boxes.may_meet({.origin = {0, 0, 1}, .direction = {1, 0, 0}, .far_m = 8.5f}));
}

TEST_CASE("an instance that came back did not move, and many that moved have few boxes around all of them") {
    const Scene scene(two_squares(), Progress());
    CHECK(MovedBoxes(scene, {{1, {mat4(1.0f)}}}, vec3(0.0f)).is_empty());
    StoodAt stood_at;
    for (int place = 1; place <= 30; ++place)
        stood_at[1].push_back(translation({4.0f * static_cast<float>(place), 0, 0}));
    const MovedBoxes boxes(scene, stood_at, vec3(0.0f));
    CHECK(boxes.boxes().size() <= MovedBoxes::most_boxes);
    for (const mat4& place : stood_at[1])
        CHECK(boxes.may_meet({.origin = vec3(place[3]) + vec3(0, 0, 1), .direction = {0, 0, -1}}));
}
} // namespace moved_instances_test
