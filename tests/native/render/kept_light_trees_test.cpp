// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame.hpp"
#include "render/kept_light_trees.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <tuple>

namespace kept_light_trees_test {
using namespace tyndall;
using namespace tyndall::support;
using render::KeptLightTrees;
using render::LightBounds;

namespace {
constexpr std::uint32_t glowing = 1, dark = 2;
constexpr std::size_t plenty = 1 << 20;

/// A floor, a cube over it that glows in fog, and one that does not.
std::unique_ptr<Scene> room(const Rgb& emission = Rgb(5.0f)) {
    Material floor{.name = "floor"}, glow{.name = "glow"};
    floor.constant = {.diffuse_albedo = Rgb(0.8f), .transparent = Rgb(0.0f), .emission = Rgb(0.0f)};
    glow.constant = {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(0.0f), .emission = emission};
    SceneDescription description =
        description_of(*make_scene({{.mesh = square(), .world_from_object = glm::scale(mat4(1.0f), vec3(8.0f))},
                                    {.mesh = cube(), .world_from_object = translation({2, 0, 3})},
                                    {.mesh = cube(), .world_from_object = translation({-3, 0, 1.5f})}},
                                   {{.name = "fog", .lobes = {{Rgb(0.05f), 0.0f}}, .sigma_a_per_m = Rgb(0.02f)}}));
    description.materials = {floor, glow, floor};
    description.world_medium_index = 0;
    return std::make_unique<Scene>(std::move(description), Progress());
}
std::unique_ptr<Scene> moved(const Scene& scene, std::uint32_t instance, const vec3& offset) {
    const MovedInstance move{.index = instance, .world_from_object = translation(offset)};
    return std::make_unique<Scene>(scene, std::span(&move, 1), TreeUpdate::Anew, Progress());
}
std::vector<LightBounds> bounds_of(const Scene& scene) {
    std::vector<LightBounds> bounds;
    const render::MeshEmitters emitters(scene);
    for (const render::EmissiveTriangle& triangle : emitters.triangles())
        bounds.push_back(render::MeshEmitters::bounds_of(triangle));
    return bounds;
}
std::vector<float> picture(const Scene& scene, const std::shared_ptr<KeptLightTrees>& kept) {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 12});
    camera.width_px = camera.height_px = 12;
    render::FrameConfig config;
    config.pixel_samples = 4;
    config.kept_light_trees = kept;
    Progress progress;
    return render::render(scene, camera, config, progress).find(render::Pass::Combined)->values;
}
} // namespace

TEST_CASE("a tree of lights is kept while none of its lights changes, whatever else of the scene does") {
    KeptLightTrees kept(plenty);
    const auto scene = room();
    const auto emitters = kept.emitters_of(*scene, Progress());
    const auto tree = kept.tree_of(bounds_of(*scene));
    CHECK(emitters->triangles().size() == 12);
    CHECK(kept.emitters_of(*scene, Progress()) == emitters);
    CHECK(kept.tree_of(bounds_of(*scene)) == tree);

    const auto beside = moved(*scene, dark, {-3, 1, 1.5f});
    CHECK(kept.emitters_of(*beside, Progress()) != emitters); // instances may have come or gone
    CHECK(kept.tree_of(bounds_of(*beside)) == tree);
    CHECK(kept.tree_of(bounds_of(*moved(*scene, glowing, {2, 0, 3.001f}))) != tree);
    CHECK(kept.tree_of(bounds_of(*room(Rgb(5.01f)))) != tree);
    CHECK(kept.tree_of(bounds_of(*scene)) == tree);
}

TEST_CASE("what is kept of trees stays below its bound, and those last asked for stay") {
    const auto scene = room();
    KeptLightTrees measure(plenty);
    (void)measure.tree_of(bounds_of(*scene));
    KeptLightTrees two(2 * measure.bytes()), none(measure.bytes() - 1);
    const auto first = two.tree_of(bounds_of(*room(Rgb(1.0f)))), second = two.tree_of(bounds_of(*room(Rgb(2.0f))));
    CHECK(two.tree_of(bounds_of(*room(Rgb(1.0f)))) == first);
    (void)two.tree_of(bounds_of(*room(Rgb(3.0f))));
    CHECK(two.bytes() == 2 * measure.bytes());
    CHECK(two.tree_of(bounds_of(*room(Rgb(1.0f)))) == first);
    CHECK(two.tree_of(bounds_of(*room(Rgb(2.0f)))) != second);
    CHECK(none.tree_of(bounds_of(*scene)) != nullptr);
    CHECK(none.bytes() == 0);
}

TEST_CASE("pictures have the same bits with trees that were kept, on surfaces and in fog") {
    const auto kept = std::make_shared<KeptLightTrees>(plenty);
    const auto scene = room(), beside = moved(*scene, dark, {-1, 1, 1.5f}), lit = moved(*scene, glowing, {0, 2, 3});
    const std::vector<float> first = picture(*scene, nullptr);
    for (const auto& [now, seen] : {std::tuple(scene.get(), first),
                                    {beside.get(), picture(*beside, nullptr)},
                                    {lit.get(), picture(*lit, nullptr)},
                                    {scene.get(), first}}) {
        CHECK(picture(*now, kept) == seen);
    }
    CHECK(picture(*beside, nullptr) != first);
    CHECK(picture(*lit, nullptr) != first);
    CHECK(kept->bytes() > 0);
}
} // namespace kept_light_trees_test
