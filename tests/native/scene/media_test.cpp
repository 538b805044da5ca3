// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ray is in which medium. The traps are boundaries: edges that two triangles share, a camera that stands on one,
// meshes that overlap themselves or one another, normals that point inwards.
#include "scene/media.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>

namespace media_test {
using namespace tyndall;
using support::Part;

namespace {
Medium fog(float sigma_t) {
    return {.name = "fog", .lobes = {{Rgb(0.5f * sigma_t), 0.0f}}, .sigma_a_per_m = Rgb(0.5f * sigma_t)};
}
Material fog_material(int medium) { return {.name = "fog", .medium_index = medium, .has_surface = false}; }

/// A sphere of radius 1 from an octahedron, closed, without a box's fast path.
std::shared_ptr<const TriangleMesh> sphere(int subdivisions, bool is_inside_out = false) {
    std::vector<vec3> positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<uvec3> triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < subdivisions; ++level) {
        std::vector<uvec3> finer;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const vec3 point = glm::normalize(positions[a] + positions[b]);
            for (std::uint32_t index = 0; index < positions.size(); ++index)
                if (positions[index] == point)
                    return index;
            positions.push_back(point);
            return static_cast<std::uint32_t>(positions.size() - 1);
        };
        for (const uvec3& t : triangles) {
            const std::uint32_t a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, a, c}, {t.y, b, a}, {t.z, c, b}, {a, b, c}});
        }
        triangles = finer;
    }
    if (is_inside_out)
        for (uvec3& triangle : triangles)
            std::swap(triangle.y, triangle.z);
    return support::mesh_of({.name = "sphere", .positions = positions, .triangles = triangles});
}
/// The cube, with one face cut into four: closed, but no box to the fast path.
std::shared_ptr<const TriangleMesh> odd_cube() {
    MeshArrays arrays = support::arrays_of(*support::cube());
    const uvec3 cut = arrays.triangles.back();
    arrays.triangles.pop_back();
    arrays.positions.push_back((arrays.positions[cut.x] + arrays.positions[cut.y] + arrays.positions[cut.z]) / 3.0f);
    const auto middle = static_cast<std::uint32_t>(arrays.positions.size() - 1);
    arrays.triangles.insert(arrays.triangles.end(),
                            {{cut.x, cut.y, middle}, {cut.y, cut.z, middle}, {cut.z, cut.x, middle}});
    return support::mesh_of(std::move(arrays));
}
std::vector<MediumSegment> segments(const Scene& scene, const Ray& ray) {
    const Media media(scene, Progress());
    std::vector<MediumSegment> result;
    media.segments(ray, result);
    return result;
}
} // namespace

TEST_CASE("a box found by its planes and the same box found by its triangles bound the same medium") {
    const mat4 place = glm::rotate(support::translation({1, 2, 3}), 0.7f, glm::normalize(vec3(1, 2, -1))) *
                       glm::scale(mat4(1.0f), vec3(4, -2, 3));
    const auto box = support::make_scene({{support::cube(), place, fog_material(0)}}, {fog(0.1f)});
    const auto mesh = support::make_scene({{odd_cube(), place, fog_material(0)}}, {fog(0.1f)});
    const Media box_media(*box, Progress()), mesh_media(*mesh, Progress());
    REQUIRE(box_media.boundaries()[0].is_box);
    REQUIRE(!mesh_media.boundaries()[0].is_box);
    support::SceneRandom random(1);
    int hits = 0;
    for (int ray_index = 0; ray_index < 2000; ++ray_index) {
        const Ray ray{.origin = vec3(1, 2, 3) + 5.0f * random.uniform() * random.direction(),
                      .direction = random.direction()};
        std::vector<MediumSegment> a, b;
        box_media.segments(ray, a), mesh_media.segments(ray, b);
        REQUIRE(a.size() == b.size());
        hits += !a.empty();
        for (std::size_t index = 0; index < a.size(); ++index) {
            CHECK(std::abs(a[index].near_m - b[index].near_m) < 1e-4f);
            CHECK(std::abs(a[index].far_m - b[index].far_m) < 1e-4f);
        }
    }
    CHECK(hits > 500);
}
// Seen to fail without the merging of hits on shared edges: the ray enters twice, leaves once, and never ends.
TEST_CASE("no medium leaks where a ray passes exactly through edges and vertices") {
    for (const bool is_inside_out : {false, true}) {
        const auto scene = support::make_scene({{sphere(3, is_inside_out), mat4(1.0f), fog_material(0)}}, {fog(1.0f)});
        const Media media(*scene, Progress());
        const SharedMeshArrays& arrays = scene->description().meshes[0]->arrays();
        for (const uvec3& triangle : arrays.triangles) {
            const vec3 a = arrays.positions[triangle.x], b = arrays.positions[triangle.y];
            for (const vec3& target : {a, 0.5f * (a + b)})
                for (const vec3& origin : {vec3(0.0f), 3.0f * target, vec3(0, 0, 3), vec3(0, -4, 0)}) {
                    const Ray ray{.origin = origin, .direction = glm::normalize(target - origin)};
                    std::vector<MediumSegment> found;
                    media.segments(ray, found);
                    // At the silhouette either answer is right; an endless segment is not.
                    CHECK(found.size() <= 1);
                    if (!found.empty())
                        CHECK(found.back().far_m < 7.0f);
                    const vec3 inside = glm::cross(origin, ray.direction); // distance from the centre
                    if (glm::length(inside) < 0.9f)
                        CHECK(found.size() == 1);
                }
        }
    }
}
TEST_CASE("a camera on the boundary, on either side, sees the medium in front of it and nothing else") {
    const auto scene = support::make_scene({{odd_cube(), mat4(1.0f), fog_material(0)}}, {fog(0.1f)});
    for (const float offset : {-1e-6f, 0.0f, 1e-6f}) {
        const vec3 origin(1.0f + offset, 0.2f, 0.1f);
        const auto inwards = segments(*scene, {.origin = origin, .direction = {-1, 0, 0}});
        REQUIRE(inwards.size() == 1);
        CHECK(std::abs(inwards[0].far_m - 2.0f) < 1e-5f);
        for (const MediumSegment& segment : segments(*scene, {.origin = origin, .direction = {1, 0, 0}}))
            CHECK(segment.far_m < 1e-5f);
    }
}
TEST_CASE("a ray from beyond what Embree reckons with in a flat object's space crosses no medium") {
    const auto scene =
        support::make_scene({{odd_cube(), glm::scale(mat4(1.0f), vec3(1, 1, 0)), fog_material(0)}}, {fog(0.1f)});
    CHECK(segments(*scene, {.origin = {0.3f, 0.1f, 5}, .direction = {0, 0, -1}}).size() == 1);
    CHECK(segments(*scene, {.origin = {0.3f, 0.1f, 1e13f}, .direction = {0, 0, -1}}).empty());
}
TEST_CASE("objects that overlap add their media; a mesh that overlaps itself is one object") {
    const mat4 moved = support::translation({1, 0, 0});
    const Ray ray{.origin = {-5, 0.1f, 0.2f}, .direction = {1, 0, 0}};
    const auto two = support::make_scene(
        {{odd_cube(), mat4(1.0f), fog_material(0)}, {odd_cube(), moved, fog_material(0)}}, {fog(0.1f)});
    const auto found = segments(*two, ray);
    REQUIRE(found.size() == 3);
    CHECK(found[1].set.count == 2);
    CHECK(std::abs(Media(*two, Progress()).sigma_t_per_m(found[1].set).x - 0.2f) < 1e-7f);

    MeshArrays doubled = support::arrays_of(*odd_cube());
    const auto first = static_cast<std::uint32_t>(doubled.positions.size());
    const auto count = doubled.triangles.size();
    for (std::uint32_t index = 0; index < first; ++index)
        doubled.positions.push_back(doubled.positions[index] + vec3(1, 0, 0));
    for (std::size_t index = 0; index < count; ++index)
        doubled.triangles.push_back(doubled.triangles[index] + first);
    const auto one =
        support::make_scene({{support::mesh_of(std::move(doubled)), mat4(1.0f), fog_material(0)}}, {fog(0.1f)});
    const auto merged = segments(*one, ray);
    REQUIRE(merged.size() == 1);
    CHECK(std::abs(merged[0].far_m - merged[0].near_m - 3.0f) < 1e-5f);
}
TEST_CASE("nested objects and the world's medium: the set changes where a boundary is crossed") {
    SceneDescription description;
    for (const float size : {4.0f, 2.0f}) {
        description.meshes.push_back(size > 3.0f ? support::cube() : sphere(2));
        description.materials.push_back(fog_material(size > 3.0f ? 0 : 1));
        const auto index = static_cast<std::uint32_t>(description.instances.size());
        description.slot_materials.push_back(index);
        description.object_names.push_back("fog");
        description.instances.push_back({.mesh_index = index,
                                         .world_from_object = glm::scale(mat4(1.0f), vec3(size)),
                                         .name_index = index,
                                         .first_slot_material = index});
    }
    description.media = {fog(0.1f), fog(0.2f), fog(0.4f)};
    description.world_medium_index = 2;
    const Scene scene(std::move(description), Progress());
    const auto found = segments(scene, {.origin = {0.1f, 0.2f, 9.0f}, .direction = {0, 0, -1}});
    REQUIRE(found.size() == 5);
    const int counts[] = {1, 2, 3, 2, 1};
    for (std::size_t index = 0; index < 5; ++index)
        CHECK(found[index].set.count == counts[index]);
    CHECK(std::isinf(found.back().far_m));
    const Media media(scene, Progress());
    CHECK(media.transmittance({.origin = {0, 0, 9}, .direction = {0, 0, -1}}) == Rgb(0.0f));
    CHECK(media.fills_world());
}
TEST_CASE("an open sheet bounds the half of the ray behind its front") {
    const auto scene = support::make_scene({{support::square(), mat4(1.0f), fog_material(0)}}, {fog(0.1f)});
    const auto down = segments(*scene, {.origin = {0.3f, 0.2f, 2.0f}, .direction = {0, 0, -1}});
    REQUIRE(down.size() == 1);
    CHECK(std::abs(down[0].near_m - 2.0f) < 1e-6f);
    CHECK(std::isinf(down[0].far_m));
    const auto up = segments(*scene, {.origin = {0.3f, 0.2f, -2.0f}, .direction = {0, 0, 1}});
    REQUIRE(up.size() == 1);
    CHECK(up[0].near_m == 0.0f);
    CHECK(std::abs(up[0].far_m - 2.0f) < 1e-6f);
}
// Seen to fail: with all that leaves a sheet taken for what started inside, as of a pond seen from below.
TEST_CASE("a sheet that stands upright fills nothing in front of its back, unless something lies above") {
    const mat4 upright = glm::rotate(mat4(1.0f), glm::half_pi<float>(), vec3(1, 0, 0)); // its front looks along -y
    const auto scene = support::make_scene({{support::square(), upright, fog_material(0)}}, {fog(0.1f)});
    CHECK(segments(*scene, {.origin = {0.3f, 2.0f, 0.2f}, .direction = {0, -1, 0}}).empty());
    const auto behind = segments(*scene, {.origin = {0.3f, -2.0f, 0.2f}, .direction = {0, 1, 0}});
    REQUIRE(behind.size() == 1);
    CHECK(std::abs(behind[0].near_m - 2.0f) < 1e-6f);
}
TEST_CASE("a medium's emission is what a glowing slab of its optical depth shows") {
    Medium glowing = fog(0.3f);
    glowing.emission_w_per_m3_sr = {1.0f, 2.0f, 0.0f};
    const auto scene =
        support::make_scene({{support::cube(), glm::scale(mat4(1.0f), vec3(5.0f)), fog_material(0)}}, {glowing});
    const Rgb radiance = Media(*scene, Progress()).emission({.origin = {0, 0, 0}, .direction = {0, 1, 0}});
    const float expected = -std::expm1(-0.3f * 5.0f) / 0.3f;
    CHECK(std::abs(radiance.x / expected - 1.0f) < 1e-6f);
    CHECK(std::abs(radiance.y / (2.0f * expected) - 1.0f) < 1e-6f);
    CHECK(radiance.z == 0.0f);
}
TEST_CASE("a scene without a medium, or with one that does nothing, is empty") {
    CHECK(Media(*support::make_scene({{support::cube()}}), Progress()).is_empty());
    CHECK(Media(*support::make_scene({{support::cube(), mat4(1.0f), fog_material(0)}}, {fog(0.0f)}), Progress())
              .is_empty());
}
} // namespace media_test
