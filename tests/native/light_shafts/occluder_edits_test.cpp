// SPDX-License-Identifier: GPL-3.0-or-later
// What edits do to the shadows of a scene, whatever light casts them.
#include "light_shafts/exact_strip.hpp"
#include "light_shafts/map_visibility.hpp"
#include "light_shafts/occluder_edits.hpp"
#include "light_shafts/row_query.hpp"
#include "support/close_to.hpp"
#include "support/scenes.hpp"
#include "support/shaft_settings.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace occluder_edits_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// A plate [-60, 60]^2 at z = 0 with a square hole [-hole, hole]^2.
MeshArrays plate_with_hole(float hole_m) {
    MeshArrays plate{.name = "plate"};
    const std::array xs{-60.0f, -hole_m, hole_m, 60.0f}, ys = xs;
    for (const float y : ys)
        for (const float x : xs)
            plate.positions.emplace_back(x, y, 0.0f);
    for (std::uint32_t row = 0; row < 3; ++row)
        for (std::uint32_t column = 0; column < 3; ++column) {
            const std::uint32_t a = 4 * row + column;
            if (row == 1 && column == 1)
                continue;
            plate.triangles.emplace_back(a, a + 1, a + 5);
            plate.triangles.emplace_back(a, a + 5, a + 4);
        }
    return plate;
}

/// A light above z = 0, seen from the side.
struct Stage {
    std::unique_ptr<Scene> scene;
    Light light;
    View view = perspective({0.3f, -9.0f, -1.0f});
    std::vector<ViewRay> rays;

    Stage(const std::vector<Part>& parts, LightKind kind)
        : scene(make_scene(parts)), light{.name = "light", .kind = kind, .position = {0.1f, 0.2f, 5.0f}} {
        light.towards_light = glm::normalize(vec3(0.1f, 0.05f, 1.0f));
        Setting setting{"stage", view, {}, {0, 9, -0.5f}};
        rays = make_rays(setting, 24);
        for (ViewRay& ray : rays)
            ray.far_m += 4.0f;
    }
    [[nodiscard]] LightSample sample() const { return sample_light(light, 0, vec3(0.5f)); }
};

/// Visibility of the stage's light with some edits.
std::unique_ptr<Visibility> edited(Stage& stage, std::vector<OccluderEdit> edits, std::uint32_t lines = 512) {
    stage.light.occluder_edits = std::move(edits);
    Progress progress;
    const Occluders occluders = gather_occluders(stage.scene->description(), progress);
    const OccluderEdits made(stage.scene->description(), stage.light, occluders);
    REQUIRE(!made.is_empty());
    return make_edited_beam(*stage.scene, made, occluders, stage.view, stage.sample(),
                            outline(stage.view.is_orthographic, stage.rays, progress),
                            std::make_shared<const StripOnDemand>(*stage.scene), {.resolution = lines}, progress);
}
std::vector<double> lit_lengths(const Visibility& visibility, std::span<const ViewRay> rays) {
    LitRows lit;
    visibility.lit_intervals(rays, lit);
    std::vector<double> lengths(rays.size(), 0.0);
    for (std::size_t r = 0; r < rays.size(); ++r)
        for (std::uint32_t i = lit.first[r]; i < lit.first[r + 1]; ++i)
            lengths[r] += double{lit.intervals[i].far_m} - double{lit.intervals[i].near_m};
    return lengths;
}
double total(const std::vector<double>& lengths) {
    double sum = 0.0;
    for (const double length : lengths)
        sum += length;
    return sum;
}
/// The parts of the rays in a box below the plate that every light's cone contains.
std::vector<ViewRay> below_plate(std::span<const ViewRay> rays) {
    std::vector<ViewRay> below;
    const vec3 low(-2.0f, -2.0f, -1.5f), high(2.0f, 2.0f, -0.05f);
    for (ViewRay ray : rays) {
        for (int axis = 0; axis < 3; ++axis) {
            const float a = (low[axis] - ray.origin[axis]) / ray.direction[axis],
                        b = (high[axis] - ray.origin[axis]) / ray.direction[axis];
            ray.near_m = std::max(ray.near_m, std::min(a, b));
            ray.far_m = std::min(ray.far_m, std::max(a, b));
        }
        if (ray.near_m < ray.far_m)
            below.push_back(ray);
    }
    return below;
}
constexpr std::array light_kinds{LightKind::Sun, LightKind::Point, LightKind::Spot};
} // namespace

TEST_CASE("a hole closes when the kernel reaches across it, and stays as it is when it does not") {
    for (const LightKind kind : light_kinds)
        for (const KernelShape shape : {KernelShape::Disc, KernelShape::Square}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(static_cast<int>(shape));
            Stage stage({{.mesh = mesh_of(plate_with_hole(0.3f))}}, kind);
            stage.light.spot_half_angle_rad = 0.6f;
            stage.light.spot_axis = {0, 0, -1};
            stage.rays = below_plate(stage.rays);
            const auto lit_with = [&](float size_m) {
                OccluderEdit close{.name = "close", .shape = shape, .size_m = size_m, .distance_m = 5.0f};
                return total(lit_lengths(*edited(stage, {close}), stage.rays));
            };
            // The hole is 0.6 m wide; a lamp 5 m above sees it so.
            const double open = lit_with(1e-4f);
            CHECK(open > 1.0);
            // A disc of 0.4 m rounds the hole's corners by 0.034 of 0.36 m^2; and its borders lie on texels.
            CHECK(lit_with(0.4f) > 0.8 * open);
            CHECK(lit_with(0.4f) < 1.1 * open);
            CHECK(lit_with(1.0f) < 0.002 * open);
        }
}

TEST_CASE("a hole closes, too, for a camera that sees nothing but the middle of the beam through it") {
    for (const LightKind kind : light_kinds)
        for (const EditKind edit : {EditKind::Close, EditKind::EpipolarClose}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(static_cast<int>(edit));
            Stage stage({{.mesh = mesh_of(plate_with_hole(0.3f))}}, kind);
            stage.light.spot_half_angle_rad = 0.6f;
            stage.light.spot_axis = {0, 0, -1};
            stage.light.towards_light = {0, 0, 1};
            stage.light.position = {0, 0, 5};
            std::vector<ViewRay> middle;
            for (float height_m = -0.3f; height_m < -0.1f; height_m += 0.02f) {
                const vec3 towards = vec3(0.0f, 0.0f, height_m) - stage.view.position;
                const float distance_m = glm::length(towards);
                middle.push_back({stage.view.position, towards / distance_m, distance_m - 0.05f, distance_m + 0.05f});
            }
            stage.rays = middle;
            const auto lit_with = [&](float size_m) {
                OccluderEdit close{.name = "close", .kind = edit, .size_m = size_m, .distance_m = 5.0f};
                return total(lit_lengths(*edited(stage, {close}, 4096), stage.rays));
            };
            CHECK(lit_with(1e-4f) == close_to(0.1 * static_cast<double>(middle.size()), 1e-3));
            CHECK(lit_with(1.4f) == 0.0);
        }
}

TEST_CASE("holes everywhere in an object are its absence, and leave what the edit does not mean") {
    for (const LightKind kind : light_kinds) {
        CAPTURE(static_cast<int>(kind));
        const Part plate{.mesh = mesh_of(plate_with_hole(0.3f))};
        const Part cube_below{.mesh = cube(), .world_from_object = translation({1.5f, 0, -2})};
        Stage both({plate, cube_below}, kind), one({cube_below}, kind);
        OccluderEdit holes{.name = "holes", .kind = EditKind::Holes, .affects_all = false, .objects = {0}};
        holes.noise.probability = 1.0f;
        OccluderEdit nothing{.name = "nothing", .kind = EditKind::Silhouette, .size_m = 1e-12f};
        const std::vector<double> without = lit_lengths(*edited(both, {holes, nothing}), both.rays);
        CHECK(without == lit_lengths(*edited(one, {nothing}), one.rays));
        CHECK(total(without) > total(lit_lengths(*edited(both, {nothing}), both.rays)));
    }
}

TEST_CASE("the share of holes is the share of light that comes through a plate") {
    for (const LightKind kind : {LightKind::Sun, LightKind::Point}) {
        CAPTURE(static_cast<int>(kind));
        Stage stage({{.mesh = square(), .world_from_object = glm::scale(mat4(1.0f), vec3(60.0f))}}, kind);
        stage.rays = below_plate(stage.rays);
        const double open = [&] {
            double length = 0.0;
            for (const ViewRay& ray : stage.rays)
                length += double{ray.far_m} - double{ray.near_m};
            return length;
        }();
        for (const float probability : {0.2f, 0.7f}) {
            OccluderEdit holes{.name = "holes", .kind = EditKind::Holes, .distance_m = 5.0f};
            holes.noise.probability = probability;
            holes.noise.scale_m = 0.1f;
            const double share = total(lit_lengths(*edited(stage, {holes}, 2048), stage.rays)) / open;
            // Some 8 x 8 m of the plate matter: 6,400 cells, each much like a draw of its own.
            CHECK(share == close_to(probability, 0.1));
        }
    }
}

TEST_CASE("a silhouette grows away from the camera: the air before the object is lit as it was") {
    // A board that faces the camera, 9 m away and 0.2 m thick, under lights that stand straight above it.
    const mat4 flat = glm::scale(mat4(1.0f), vec3(1.0f, 0.1f, 1.0f));
    for (const LightKind kind : {LightKind::Sun, LightKind::Point}) {
        CAPTURE(static_cast<int>(kind));
        Stage stage({{.mesh = cube(), .world_from_object = flat}}, kind);
        stage.light.towards_light = {0, 0, 1};
        stage.light.position = {0, 0, 5};
        std::vector<ViewRay> in_front = stage.rays;
        for (ViewRay& ray : in_front) // up to 5 cm before the board: two lines
            ray.far_m = std::min(ray.far_m, 8.85f / ray.direction.y);
        OccluderEdit grow{.name = "grow", .kind = EditKind::Silhouette, .size_m = 1e-12f, .distance_m = 5.0f};
        const auto before = edited(stage, {grow}, 2048);
        grow.size_m = 1.5f;
        const auto after = edited(stage, {grow}, 2048);
        // A lamp's lines are others once they leave room for the filter: half a line here or there.
        CHECK(total(lit_lengths(*after, in_front)) == close_to(total(lit_lengths(*before, in_front)), 5e-4));
        // Its shadow is 1.7 m deep instead of 0.2 m.
        const double shadow_before = total(lit_lengths(*before, stage.rays)),
                     shadow_after = total(lit_lengths(*after, stage.rays));
        CHECK(shadow_after < shadow_before - 50.0);
        // A camera that sees nothing but the middle of that shadow asks for no line near the board.
        const vec3 towards = vec3(0.0f, 1.0f, -0.5f) - stage.view.position;
        const float distance_m = glm::length(towards);
        stage.rays = {{stage.view.position, towards / distance_m, distance_m - 0.02f, distance_m + 0.02f}};
        CHECK(total(lit_lengths(*before, stage.rays)) == close_to(0.04, 1e-3));
        CHECK(total(lit_lengths(*edited(stage, {grow}, 4096), stage.rays)) == 0.0);
    }
}

TEST_CASE("a closing along the view fills what the light sees of a gap between neighbours in a slice") {
    Stage stage({{.mesh = mesh_of(plate_with_hole(0.3f))}}, LightKind::Sun);
    stage.rays = below_plate(stage.rays);
    OccluderEdit close{.name = "close", .kind = EditKind::EpipolarClose, .size_m = 1e-12f};
    const double open = total(lit_lengths(*edited(stage, {close}), stage.rays));
    close.size_m = 0.3f;
    const double narrow = total(lit_lengths(*edited(stage, {close}), stage.rays));
    close.size_m = 1.2f;
    const double closed = total(lit_lengths(*edited(stage, {close}), stage.rays));
    CHECK(open > 1.0);
    CHECK(narrow > 0.8 * open);
    CHECK(closed < 0.05 * open);
}

TEST_CASE("holes stay where they are while the camera moves, and go with the light") {
    for (const LightKind kind : light_kinds) {
        CAPTURE(static_cast<int>(kind));
        Stage stage({{.mesh = square(), .world_from_object = glm::scale(mat4(1.0f), vec3(60.0f))}}, kind);
        stage.light.spot_half_angle_rad = 0.6f;
        stage.light.spot_axis = {0, 0, -1};
        OccluderEdit holes{.name = "holes", .kind = EditKind::Holes, .distance_m = 5.0f};
        holes.noise.scale_m = 0.8f;
        holes.noise.probability = 0.5f;
        Progress progress;
        const Occluders occluders = gather_occluders(stage.scene->description(), progress);
        const auto map_from = [&](const vec3& eye, const vec3& light_offset) {
            Stage moved = Stage({{.mesh = square()}}, kind);
            moved.light = stage.light;
            moved.light.position += light_offset;
            moved.light.occluder_edits = {holes};
            std::vector<ViewRay> rays = stage.rays;
            for (ViewRay& ray : rays)
                ray.origin = eye;
            const LightSample sample = sample_light(moved.light, 0, vec3(0.5f));
            slope_rows::Rows rows(slope_rows::make_layout(*slope_rows::make_frame(perspective(eye), sample), rays,
                                                          {.lines = 512}, progress));
            Statistics statistics;
            const OccluderEdits edits(stage.scene->description(), moved.light, occluders);
            return MapVisibility(edits.fill(rows, sample, {1024}, PartialShading({}, sample, 0), statistics, progress));
        };
        const auto is_lit_at = [&](const MapVisibility& map, const vec3& point) {
            LitRows lit;
            const ViewRay up_to{point, {1, 0, 0}, 0.0f, 1e-4f};
            map.lit_intervals({&up_to, 1}, lit);
            return !lit.intervals.empty();
        };
        const MapVisibility here = map_from({0.3f, -9.0f, -1.0f}, vec3(0.0f)),
                            there = map_from({1.4f, -8.0f, -1.5f}, vec3(0.0f)),
                            light_moved = map_from({0.3f, -9.0f, -1.0f}, {0.7f, 0.4f, 0});
        SceneRandom random(3);
        int different = 0, lit = 0, different_moved = 0;
        constexpr int count = 2000;
        for (int i = 0; i < count; ++i) {
            const vec3 point(random.uniform(-0.7f, 0.7f), random.uniform(-0.7f, 0.7f), -0.5f);
            const bool is_lit = is_lit_at(here, point);
            lit += is_lit;
            different += is_lit != is_lit_at(there, point);
            // A light that moves across its own direction takes its holes along.
            const vec3 offset = kind == LightKind::Sun ? vec3(0.7f, 0.4f, 0) : vec3(0.7f, 0.4f, 0);
            different_moved += is_lit != is_lit_at(light_moved, point + offset);
        }
        CHECK(lit > count / 10);
        CHECK(lit < count * 9 / 10);
        CHECK(different < count / 40); // at the borders of texels
        CHECK(different_moved < count / 20);
    }
}

TEST_CASE("a mask keeps an edit where it is white") {
    Stage stage({{.mesh = square(), .world_from_object = glm::scale(mat4(1.0f), vec3(60.0f))}}, LightKind::Sun);
    stage.light.towards_light = {0, 0, 1};
    stage.light.position = vec3(0.0f);
    auto mask = std::make_shared<LightMask>();
    mask->name = "left half";
    mask->width = 64;
    mask->height = 16;
    mask->size_m = 8.0f; // 8 x 2 m around the light's origin
    for (std::uint32_t i = 0; i < mask->width * mask->height; ++i)
        mask->values.push_back(i % mask->width < mask->width / 2 ? 1.0f : 0.0f);
    OccluderEdit holes{.name = "holes", .kind = EditKind::Holes, .mask = mask};
    holes.noise.probability = 1.0f;
    const auto visibility = edited(stage, {holes}, 1024);
    const auto is_lit_at = [&](const vec3& point) {
        const vec3 direction = glm::normalize(point - stage.view.position);
        const float distance = glm::length(point - stage.view.position);
        const ViewRay ray{stage.view.position, direction, distance - 1e-3f, distance + 1e-3f};
        LitRows lit;
        visibility->lit_intervals({&ray, 1}, lit);
        return !lit.intervals.empty();
    };
    CHECK(is_lit_at({-1.0f, 0.5f, -0.5f}));
    CHECK(is_lit_at({-2.0f, -0.8f, -0.5f}));
    CHECK(!is_lit_at({1.0f, 0.5f, -0.5f}));
    CHECK(!is_lit_at({-1.0f, 1.3f, -0.5f}));
}
} // namespace occluder_edits_test
