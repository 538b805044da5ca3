// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG in a scene: the same voxels, met where tracing alone meets them.
#include "image/srgb.hpp"
#include "scene/scene.hpp"
#include "support/packed_voxels.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/trace.hpp"
#include "voxel_dag/voxel_shape.hpp"
#include <doctest/doctest.h>
#include <set>

namespace voxel_shape_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
std::shared_ptr<const PlacedDag> placed_dag(const LeafMasks& voxels, const Cube& bounds_m) {
    const Progress progress;
    const Dag dag = merge_symmetric(build_dag(voxels, {}, progress), {.symmetry = Symmetry::Cube}, progress);
    return std::make_shared<const PlacedDag>(PlacedDag{pack_dag(dag, progress), bounds_m});
}
const Cube cube_m{.lower_m = {-1.0, 0.5, 2.0}, .side_m = 3.0};

class Gatherer final : public CellVisitor {
public:
    bool enters(const Bounds3& box) override {
        boxes.push_back(box);
        return true;
    }
    void meet(const Bounds3& cell) override {
        cells.insert({cell.min.x, cell.min.y, cell.min.z, cell.max.x, cell.max.y, cell.max.z});
        CHECK((glm::all(glm::greaterThanEqual(cell.min, boxes.back().min)) &&
               glm::all(glm::lessThanEqual(cell.max, boxes.back().max))));
    }
    std::vector<Bounds3> boxes;
    std::set<std::array<float, 6>> cells;
};
} // namespace

TEST_CASE("a visitor that enters every box meets every voxel, and nothing else") {
    for (const std::uint32_t level : {2u, 3u, 5u}) {
        const LeafMasks voxels = random_voxels(level, 0.2, level);
        const auto shape = make_voxel_shape(placed_dag(voxels, cube_m), "voxels");
        Gatherer gatherer;
        shape->visit(gatherer);
        std::set<std::array<float, 6>> truth;
        Bounds3 around;
        for (std::size_t brick = 0; brick < voxels.codes.size(); ++brick)
            for (std::uint64_t i = 0; i < 64; ++i) {
                if ((voxels.masks[brick] >> i & 1) == 0)
                    continue;
                const Voxel voxel = voxel_at(voxels.codes[brick] << 6 | i);
                std::array<float, 6> box;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    for (std::size_t end = 0; end < 2; ++end)
                        box[3 * end + axis] =
                            static_cast<float>(cube_m.lower_m[static_cast<int>(axis)] +
                                               3.0 * (static_cast<double>(voxel[axis] + end) / (1u << level)));
                truth.insert(box);
                around.grow(vec3(box[0], box[1], box[2]));
                around.grow(vec3(box[3], box[4], box[5]));
            }
        CHECK(gatherer.cells == truth);
        CHECK(shape->cell_count() == truth.size());
        CHECK(shape->bounds().min == around.min);
        CHECK(shape->bounds().max == around.max);
    }
}

TEST_CASE("in a scene, rays meet the voxels that tracing alone meets") {
    const std::uint32_t level = 6;
    const auto placed = placed_dag(random_voxels(level, 0.02, 9), cube_m);
    SceneDescription description;
    description.object_names = {"voxels"};
    description.materials = {Material{.name = "white"}};
    description.shapes = {std::make_shared<const CellGeometry>(make_voxel_shape(placed, "voxels"))};
    description.placed_shapes = {PlacedShape{}};
    const Scene scene(std::move(description), Progress());
    std::mt19937 random(4);
    std::uniform_real_distribution<float> within(-1.0f, 1.0f);
    const double per_m = (1u << level) / cube_m.side_m;
    int hits = 0;
    for (int i = 0; i < 3000; ++i) {
        const vec3 from = vec3(0.5f, 2.0f, 3.5f) + 4.0f * vec3(within(random), within(random), within(random));
        const vec3 to = vec3(0.5f, 2.0f, 3.5f) + 1.4f * vec3(within(random), within(random), within(random));
        const Ray ray{.origin = from, .direction = glm::normalize(to - from), .near_m = 0.125f, .far_m = 5.0f};
        const dvec3 start = dvec3(ray.origin) + 0.125 * dvec3(ray.direction);
        const VoxelHit truth = trace(placed->dag, {.origin = (start - cube_m.lower_m) * per_m,
                                                   .direction = dvec3(ray.direction) * per_m,
                                                   .end = 5.0 - 0.125});
        const Hit hit = scene.closest_hit(ray);
        REQUIRE(hit.is_hit() == truth.is_hit());
        CHECK(scene.shadow_transmittance(ray) == Rgb(truth.is_hit() ? 0.0f : 1.0f));
        if (!hit.is_hit())
            continue;
        ++hits;
        CHECK((hit.cell >> 3) == morton_code(truth.voxel));
        CHECK(hit.distance_m == static_cast<float>(0.125 + truth.distance));
        if (truth.axis == 3)
            continue;
        CHECK((hit.cell >> 1 & 3) == truth.axis);
        const ShadingPoint point = scene.shading_point(ray, hit);
        CHECK(glm::length(point.position - (ray.origin + hit.distance_m * ray.direction)) < 4e-6f);
    }
    CHECK(hits > 1000);
}

TEST_CASE("open faces of wanted voxels are those that a ray from beside each meets") {
    const LeafMasks voxels = random_voxels(4, 0.3, 11);
    const Progress progress;
    auto placed = std::make_shared<PlacedDag>(PlacedDag{packed(voxels, Symmetry::Cube), cube_m});
    for (const bool has_colors : {false, true}) {
        VoxelAttributes attributes;
        for (std::uint64_t voxel = 0; voxel < voxels.voxel_count(); ++voxel)
            attributes.colors.push_back(voxel % 5 == 0 ? 0x0000ffu : 0xff0000u);
        if (has_colors)
            placed->attributes = encode_attributes(placed->dag, attributes, {}, progress);
        const auto shape = make_voxel_shape(placed, "voxels");
        const auto is_red = [&](const CellLook& look) { return !has_colors || look.color.x > look.color.z; };
        std::vector<std::uint64_t> truth;
        const double width_m = cube_m.side_m / 16;
        std::uint64_t number = 0;
        for (const Voxel& voxel : listed(voxels)) {
            const bool is_wanted = !has_colors || number++ % 5 == 0;
            for (int face = 0; is_wanted && face < 6; ++face) {
                dvec3 out(0.0);
                out[face / 2] = face % 2 == 0 ? -1.0 : 1.0;
                const dvec3 middle = cube_m.lower_m + width_m * (dvec3(voxel[0], voxel[1], voxel[2]) + 0.5);
                const CellHit hit = shape->closest_hit(
                    {.origin = vec3(middle + 0.75 * width_m * out), .direction = vec3(-out), .near_m = 0.0f});
                if (hit.distance_m > 0.1f * static_cast<float>(width_m)) // nothing is there to begin in
                    truth.push_back(hit.cell);
            }
        }
        std::optional<std::vector<std::uint64_t>> faces = shape->open_faces(is_red, 6 * 4096, progress);
        REQUIRE(faces);
        std::ranges::sort(*faces);
        std::ranges::sort(truth);
        CHECK(truth.size() > (has_colors ? 500 : 3000));
        CHECK(*faces == truth);
        CHECK(shape->open_faces(is_red, truth.size(), progress));
        CHECK_FALSE(shape->open_faces(is_red, truth.size() - 1, progress));
        Progress cancelled;
        cancelled.cancel();
        if (has_colors)
            CHECK_THROWS_AS((void)shape->open_faces(is_red, 7, cancelled), Cancelled);
        CHECK(shape->open_faces([](const CellLook&) { return false; }, 0, progress)->empty());
    }
}

TEST_CASE("a voxel's colour multiplies its material's, and its normal shades it on the side that is seen") {
    const LeafMasks voxels = leaf_masks_of({{0, 0, 0}, {3, 3, 3}}, 2);
    const Progress progress;
    auto placed = std::make_shared<PlacedDag>(PlacedDag{pack_dag(build_dag(voxels, {}, progress), progress), cube_m});
    VoxelAttributes attributes;
    attributes.colors = {0x4020ffu, 0x00ff80u};
    const vec3 normal = glm::normalize(vec3(-0.6f, 0.3f, 0.9f));
    attributes.normals.assign(2, octahedral::encode(dvec3(normal), 32));
    placed->attributes = encode_attributes(placed->dag, attributes, {}, progress);
    SceneDescription description;
    description.object_names = {"voxels"};
    description.materials = {Material{.name = "half"}};
    description.materials[0].constant.diffuse_albedo = Rgb(0.5f);
    description.shapes = {std::make_shared<const CellGeometry>(make_voxel_shape(placed, "voxels"))};
    description.placed_shapes = {{.world_from_object = glm::scale(mat4(1.0f), vec3(-1.0f, 1.0f, 2.0f))}};
    const Scene scene(std::move(description), progress);
    // Of the first voxel, from both sides along x, which the placement mirrors.
    for (const float side : {1.0f, -1.0f}) {
        const Ray ray{.origin = {side * 9.0f + 0.6f, 0.8f, 4.6f}, .direction = {-side, 0, 0}};
        const Hit hit = scene.closest_hit(ray);
        REQUIRE(hit.is_hit());
        const Rgb albedo = scene.closures(ray, hit).diffuse_albedo;
        CHECK(std::abs(albedo.x - 0.5f) < 1e-6f);
        CHECK(std::abs(albedo.y - 0.5f * linear_from_srgb(0x20 / 255.0f)) < 1e-6f);
        CHECK(std::abs(albedo.z - 0.5f * linear_from_srgb(0x40 / 255.0f)) < 1e-6f);
        const vec3 expected = glm::normalize(normal * vec3(-1.0f, 1.0f, 0.5f));
        CHECK(glm::length(scene.shading_point(ray, hit).shading_normal - side * expected) < 1e-4f); // 32 bits
        CHECK(hit.geometric_normal == vec3(side, 0, 0));
    }
    CHECK(scene.is_smooth(0));
}
} // namespace voxel_shape_test
