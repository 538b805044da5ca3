// SPDX-License-Identifier: GPL-3.0-or-later
// Strands and spheres are met where closed forms say, with normals of a round hair, and rays leave them freely.
#include "scene/scene.hpp"
#include "scene/strand_bends.hpp"
#include "scene/strand_surface.hpp"
#include "scene/strands.hpp"
#include "scene/tube_mesh.hpp"
#include "support/close_to.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace strands_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
const float not_a_number = std::numeric_limits<float>::quiet_NaN();

std::unique_ptr<Scene> scene_of(StrandArrays arrays, std::vector<mat4> places = {mat4(1.0f)}) {
    SceneDescription scene;
    scene.object_names = {"hair"};
    scene.materials = {Material{.name = "white"}};
    scene.shapes = {std::make_shared<const Strands>(std::move(arrays), Progress())};
    for (const mat4& place : places)
        scene.placed_shapes.push_back({.world_from_object = place});
    return std::make_unique<Scene>(std::move(scene), Progress());
}

/// One along Z, from -2 to 2, as thick all along.
StrandArrays straight(StrandForm form, float radius_m) {
    StrandArrays arrays{.name = "straight", .form = form, .first_points = {0}};
    for (int i = -2; i <= 2; ++i)
        arrays.points.emplace_back(0.0f, 0.0f, static_cast<float>(i), radius_m);
    return arrays;
}

std::vector<Ray> rays_around(std::size_t count, float reach_m, std::uint64_t seed) {
    SceneRandom random(seed);
    std::vector<Ray> rays;
    for (std::size_t i = 0; i < count; ++i) {
        const vec3 from = 10.0f * random.direction();
        const vec3 to = reach_m * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        rays.push_back({.origin = from, .direction = glm::normalize(to - from)});
    }
    return rays;
}

/// Nearest point of an endless cylinder around Z; infinite: it is missed.
double cylinder_distance(const Ray& ray, double radius_m) {
    const dvec3 o(ray.origin), d(ray.direction);
    const double a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y, c = o.x * o.x + o.y * o.y - radius_m * radius_m;
    const double inside = b * b - a * c;
    return inside < 0.0 ? std::numeric_limits<double>::infinity() : (-b - std::sqrt(inside)) / a;
}
} // namespace

TEST_CASE("a straight strand is a cylinder: where rays meet it, its normals, and the rays that pass it") {
    constexpr float radius_m = 0.3f;
    for (const StrandForm form : {StrandForm::Round, StrandForm::RoundLinear, StrandForm::Ribbon}) {
        CAPTURE(static_cast<int>(form));
        const auto scene = scene_of(straight(form, radius_m));
        int hits = 0, misses = 0;
        for (const Ray& ray : rays_around(4000, 0.6f, 1)) {
            // Where Embree ends its iteration, and what a float rounds at the silhouette: neither is asked about.
            const double expected = cylinder_distance(ray, radius_m);
            const Hit hit = scene->closest_hit(ray);
            if (!std::isfinite(cylinder_distance(ray, 1.001 * radius_m))) {
                CHECK_FALSE(hit.is_hit());
                ++misses;
            }
            const dvec3 there = dvec3(ray.origin) + expected * dvec3(ray.direction);
            if (!std::isfinite(cylinder_distance(ray, 0.999 * radius_m)) || !(std::abs(there.z) < 1.7) ||
                std::abs(ray.direction.z) > 0.9f) // its ends are tested elsewhere
                continue;
            REQUIRE(hit.is_hit());
            ++hits;
            const ShadingPoint point = scene->shading_point(ray, hit);
            const dvec3 normal = glm::normalize(dvec3(there.x, there.y, 0.0));
            if (form == StrandForm::Ribbon) {
                // A band through the axis, at right angles to the ray's share across it: the normal is that of the
                // cylinder where a ray of the same offset, going straight across, meets it.
                const dvec3 way = glm::normalize(dvec3(ray.direction.x, ray.direction.y, 0.0));
                const dvec3 side(-way.y, way.x, 0.0);
                const double offset = glm::dot(dvec3(ray.origin), side) / radius_m;
                const dvec3 round = offset * side - std::sqrt(1.0 - offset * offset) * way;
                CHECK(glm::dot(dvec3(point.shading_normal), round) > 1.0 - 1e-4);
            } else {
                CHECK(std::abs(hit.distance_m - expected) < 2e-3 * radius_m);
                CHECK(glm::dot(dvec3(point.shading_normal), normal) > 1.0 - 1e-4);
                CHECK(glm::length(dvec3(point.position) - there) < 4e-3 * radius_m);
            }
            // Embree's bands are flat in the ray's space: seen at a slant, their depth is that of the middle nearby.
            const dvec3 met = dvec3(ray.origin) + double{hit.distance_m} * dvec3(ray.direction);
            CHECK(glm::length(dvec3(point.position) - met) < (form == StrandForm::Ribbon ? 0.15 : 4e-3) * radius_m);
            CHECK_FALSE(point.is_backface);
        }
        CHECK(hits > 800);
        CHECK(misses > 10);
    }
}

// Seen to fail of bands and cones where rays ended as near as what leaves them begins.
TEST_CASE("what a ray is to reach does not block it") {
    const mat4 turned =
        glm::rotate(glm::scale(mat4(1.0f), vec3(-1.0f, 1.5f, 0.7f)), 0.7f, glm::normalize(vec3(1, 2, -1)));
    for (const StrandForm form :
         {StrandForm::Ribbon, StrandForm::Round, StrandForm::RoundLinear, StrandForm::Spheres}) {
        CAPTURE(static_cast<int>(form));
        StrandArrays arrays = straight(form, 0.1f);
        if (form == StrandForm::Spheres)
            arrays.first_points.clear();
        const auto scene = scene_of(arrays, {turned});
        int hits = 0;
        for (const Ray& ray : rays_around(20'000, 1.0f, 6)) {
            const Hit hit = scene->closest_hit(ray);
            if (!hit.is_hit())
                continue;
            ++hits;
            const vec3 way = scene->arrival_point(hit, ray.direction) - ray.origin;
            CHECK(glm::length(way) > hit.distance_m - 0.6f);
            CHECK(scene->shadow_transmittance(
                      {.origin = ray.origin, .direction = glm::normalize(way), .far_m = glm::length(way)}) ==
                  Rgb(1.0f));
        }
        CHECK(hits > 500);
    }
}

TEST_CASE("turned, mirrored and stretched spheres are met where their quadric is") {
    StrandArrays arrays{.name = "points", .form = StrandForm::Spheres};
    SceneRandom random(5);
    for (int i = 0; i < 40; ++i)
        arrays.points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1),
                                   random.uniform(0.02f, 0.2f));
    const mat4 mirrored = glm::scale(translation({0.1f, -0.2f, 0.3f}), vec3(-1.0f, 1.5f, 0.7f)),
               turned = glm::rotate(mirrored, 0.7f, glm::normalize(vec3(1, 2, -1)));
    const std::vector<vec4> spheres = arrays.points;
    const auto scene = scene_of(arrays, {turned});
    const glm::dmat4 to_object = glm::inverse(glm::dmat4(turned));
    int hits = 0;
    for (const Ray& ray : rays_around(3000, 1.0f, 2)) {
        const dvec3 o(to_object * glm::dvec4(dvec3(ray.origin), 1.0)), d(glm::dmat3(to_object) * dvec3(ray.direction));
        double nearest = std::numeric_limits<double>::infinity(), slack = 1.0;
        dvec3 outwards(0.0);
        for (const vec4& sphere : spheres) {
            const dvec3 from = o - dvec3(vec3(sphere));
            const double a = glm::dot(d, d), b = glm::dot(from, d),
                         c = glm::dot(from, from) - double{sphere.w} * double{sphere.w}, inside = b * b - a * c;
            slack = std::min(slack, std::abs(inside) / (a * glm::dot(from, from)));
            if (const double t = (-b - std::sqrt(inside)) / a; inside > 0.0 && t < nearest)
                nearest = t, outwards = glm::dmat3(glm::dmat4(turned)) * (from + t * d);
        }
        if (slack < 1e-5) // grazes one
            continue;
        const Hit hit = scene->closest_hit(ray);
        REQUIRE(hit.is_hit() == std::isfinite(nearest));
        if (!hit.is_hit())
            continue;
        ++hits;
        CHECK(std::abs(hit.distance_m - nearest) < 1e-4);
        const double side = glm::dot(outwards, dvec3(ray.direction)) < 0.0 ? 1.0 : -1.0;
        const ShadingPoint point = scene->shading_point(ray, hit);
        CHECK(point.is_backface == (side < 0.0));
        CHECK(glm::dot(dvec3(point.shading_normal), side * glm::normalize(outwards)) > 1.0 - 1e-4);
    }
    CHECK(hits > 500);
}

// As Cycles leaves it out for rays that begin on it. Seen to fail where they begin beside it as its shading normals say.
TEST_CASE("a stretched sphere shades nothing of itself") {
    for (const float distance_m : {0.0f, 2000.0f}) {
        StrandArrays arrays{.name = "points", .form = StrandForm::Spheres};
        arrays.points.emplace_back(0.01f, -0.02f, 0.03f, 0.1f);
        const auto scene = scene_of(arrays, {glm::scale(translation({distance_m, 0, 0}), vec3(1.0f, 3.0f, 0.3f))});
        SceneRandom random(8);
        int hits = 0;
        for (Ray ray : rays_around(2000, 0.1f, 4)) {
            ray.origin.x += distance_m;
            const Hit hit = scene->closest_hit(ray);
            hits += hit.is_hit() ? 1 : 0;
            if (hit.is_hit())
                CHECK(scene->shadow_transmittance(scene->leaving_ray(hit, random.direction())) == Rgb(1.0f));
        }
        CHECK(hits > 100);
    }
}

TEST_CASE("curved strands are met where the nearest of many small spheres along the spline is") {
    StrandArrays arrays{.name = "curl", .form = StrandForm::Round, .first_points = {0, 6}};
    for (int i = 0; i < 6; ++i) {
        const float turn = 0.8f * static_cast<float>(i);
        arrays.points.emplace_back(std::cos(turn), std::sin(turn), 0.2f * turn, 0.06f);
    }
    for (int i = 0; i < 4; ++i)
        arrays.points.emplace_back(0.3f * static_cast<float>(i) - 0.5f, 0.1f * static_cast<float>(i * i), 0.4f, 0.05f);
    const Strands strands(arrays, Progress());
    const auto scene = scene_of(arrays);
    int hits = 0, wrong = 0, asked = 0;
    for (const Ray& ray : rays_around(2000, 1.2f, 3)) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::uint32_t segment = 0; segment < strands.segment_count(); ++segment)
            for (int i = 0; i <= 400; ++i) {
                const StrandPoint at = strands.on_spline(segment, static_cast<float>(i) / 400.0f);
                const dvec3 from = dvec3(ray.origin) - dvec3(at.centre);
                const double b = glm::dot(from, dvec3(ray.direction)),
                             inside = b * b - glm::dot(from, from) + double{at.radius_m} * double{at.radius_m};
                if (inside > 0.0)
                    nearest = std::min(nearest, -b - std::sqrt(inside));
            }
        const Hit hit = scene->closest_hit(ray);
        ++asked;
        hits += hit.is_hit();
        wrong += hit.is_hit() != std::isfinite(nearest) ||
                 (hit.is_hit() && std::abs(hit.distance_m - nearest) > 0.02 * 0.06);
    }
    CHECK(hits > 140);
    CHECK(wrong < asked / 100); // the spheres round the strands' ends, and leave dents
}

TEST_CASE("a strand does not shadow its own lit side, and shadows what lies behind it") {
    for (const StrandForm form : {StrandForm::Ribbon, StrandForm::Round, StrandForm::RoundLinear}) {
        CAPTURE(static_cast<int>(form));
        for (const float distance_m : {0.0f, 2000.0f}) {
            const auto scene = scene_of(straight(form, 0.01f), {translation({distance_m, 0, 0})});
            SceneRandom random(7);
            int lit = 0, passed = 0;
            for (Ray ray : rays_around(1000, 0.01f, 4)) {
                ray.origin.x += distance_m;
                const Hit hit = scene->closest_hit(ray);
                if (!hit.is_hit())
                    continue;
                const ShadingPoint point = scene->shading_point(ray, hit);
                const vec3 to_light = random.direction();
                const float cosine = glm::dot(to_light, point.shading_normal);
                if (std::abs(cosine) < 0.05f || std::abs(to_light.z) > 0.9f)
                    continue;
                const bool is_lit = scene->shadow_transmittance(scene->leaving_ray(hit, to_light)) != Rgb(0.0f);
                if (cosine > 0.0f) {
                    ++lit;
                    CHECK(is_lit);
                } else if (form != StrandForm::Ribbon) { // what passes a tube leaves it
                    ++passed;
                    CHECK(is_lit);
                }
            }
            CHECK(lit > 100);
            CHECK((form == StrandForm::Ribbon || passed > 100));
            CHECK(scene->shadow_transmittance(
                      {.origin = {distance_m + 1.0f, 0, 0.1f}, .direction = {-1, 0, 0}, .far_m = 2.0f}) == Rgb(0.0f));
            CHECK(scene->shadow_transmittance(
                      {.origin = {distance_m + 1.0f, 0.02f, 0.1f}, .direction = {-1, 0, 0}, .far_m = 2.0f}) ==
                  Rgb(1.0f));
        }
    }
}

TEST_CASE("packets meet the strands that single rays meet") {
    StrandArrays arrays{.name = "fur"};
    SceneRandom random(9);
    for (int strand = 0; strand < 200; ++strand) {
        arrays.first_points.push_back(static_cast<std::uint32_t>(arrays.points.size()));
        vec3 at{random.uniform(-1, 1), random.uniform(-1, 1), 0.0f};
        for (int i = 0; i < 5; ++i) {
            arrays.points.emplace_back(at, 0.02f * static_cast<float>(4 - i));
            at += 0.3f * vec3(random.uniform(-0.5f, 0.5f), random.uniform(-0.5f, 0.5f), 1.0f);
        }
    }
    const auto scene = scene_of(arrays, {mat4(1.0f), translation({2, 0, 0})});
    const std::vector<Ray> rays = rays_around(2000, 1.0f, 6);
    std::vector<Hit> hits(rays.size());
    scene->closest_hits(rays, hits);
    std::vector<Rgb> passing(rays.size());
    scene->shadow_transmittances(rays, passing);
    int count = 0, differing = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Hit alone = scene->closest_hit(rays[i]);
        count += alone.is_hit();
        differing += hits[i].is_hit() != alone.is_hit() || hits[i].instance != alone.instance ||
                     hits[i].cell != alone.cell || (passing[i] == Rgb(0.0f)) != alone.is_hit();
    }
    CHECK(count > 300);
    CHECK(differing <= 2); // at edges
}

TEST_CASE("strands that cannot be drawn are left out, counted and said; their neighbours keep what is theirs") {
    StrandArrays arrays{.name = "fur",
                        .form = StrandForm::Round,
                        .points = {{0, 0, 0, not_a_number},
                                   {0, 0, 1, 0.1f},
                                   {1, 0, 0, 0.1f},
                                   {1, 0, 0, 0.1f},
                                   {2, 0, 0, 0.1f},
                                   {3, 0, 0, 0.1f},
                                   {3, 0, 1, 0.1f},
                                   {4, 0, 0, 0},
                                   {4, 0, 1, 0}},
                        .first_points = {0, 2, 4, 5, 7},
                        .maps = {{"uv", {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}}}},
                        .randoms = {0.0f, 0.1f, 0.2f, 0.3f, 0.4f}};
    const auto scene = scene_of(arrays);
    REQUIRE(scene->statistics().reports.size() == 1);
    CHECK(scene->statistics().reports[0] == "strands 'fur': left out 1 strand with a position or radius that is not "
                                            "finite and 3 strands with no length or no width");
    const Strands strands(arrays, Progress());
    CHECK(strands.strand_count() == 1);
    CHECK(strands.look_up("uv", 0, {0.5f, 0.0f}, {}) == vec2(3.0f));
    CHECK(strands.look_up("", 0, {0.5f, 0.0f}, {}) == vec2(3.0f));
    CHECK(strands.look_up("another", 0, {0.5f, 0.0f}, {}) == vec2(0.0f));
    CHECK(strands.look_up(strand_maps::random_and_thickness, 0, {0.5f, 0.0f}, {}) == vec2(0.3f, 0.2f));
    CHECK(strands.look_up(strand_maps::intercept_and_length, 0, {0.25f, 0.0f}, {}) == vec2(0.25f, 1.0f));
    CHECK(strands.look_up(strand_maps::is_strand, 0, {0.25f, 0.0f}, {}) == vec2(1.0f, 0.0f));
    CHECK(scene_of({.name = "bald", .form = StrandForm::Ribbon})->instance_count() == 0);
    arrays.first_points[1] = 7;
    CHECK_THROWS_AS(Strands(arrays, Progress()), InvalidInput);
}

TEST_CASE("values of points are straight between them, whatever strands before were left out") {
    const StrandArrays arrays{.name = "fur",
                              .form = StrandForm::Ribbon,
                              .points = {{0, 0, 0, not_a_number},
                                         {0, 0, 1, 0.1f},
                                         {1, 0, 0, 0.1f},
                                         {1, 0, 1, 0.1f},
                                         {2, 0, 0, 0.1f},
                                         {2, 0, 1, 0.1f},
                                         {2, 0, 3, 0.1f}},
                              .first_points = {0, 2, 4},
                              .maps = {{"along", {{0, 9}, {1, 9}, {2, 8}, {4, 8}, {8, 7}, {16, 5}, {32, 1}}},
                                       {"root", {{0, 0}, {1, 1}, {2, 2}}}}};
    const Strands strands(arrays, Progress());
    REQUIRE(strands.segment_count() == 3);
    CHECK(strands.look_up("along", 0, {0.0f, 0.3f}, {}) == vec2(2.0f, 8.0f));
    CHECK(strands.look_up("along", 0, {0.25f, 0.3f}, {}) == vec2(2.5f, 8.0f));
    CHECK(strands.look_up("along", 1, {0.5f, -0.3f}, {}) == vec2(12.0f, 6.0f));
    CHECK(strands.look_up("along", 2, {1.0f, 0.0f}, {}) == vec2(32.0f, 1.0f));
    CHECK(strands.look_up("root", 2, {1.0f, 0.0f}, {}) == vec2(2.0f));
}

TEST_CASE("what lies along: a strand's tangent, of a mesh the edge that is asked for, as its object stands") {
    const Strands strands(straight(StrandForm::Round, 0.1f), Progress());
    CHECK(strands.look_up(std::string(strand_maps::along_xy) + "01", 0, {0.5f, 0.0f}, {}, {1, 2, 3}) == vec2(1, 2));
    CHECK(strands.look_up(std::string(strand_maps::along_z) + "01", 0, {0.5f, 0.0f}, {}, {1, 2, 3}).x == 3.0f);
    const MeshArrays mesh{.name = "card", .positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 1}}, .triangles = {{0, 1, 2}}};
    const mat4 twice = glm::scale(mat4(1.0f), vec3(2.0f));
    const auto edge = [&](std::string_view name, const char* corners) {
        return strand_maps::of_edge(std::string(name) + corners, mesh, 0, twice);
    };
    CHECK(edge(strand_maps::along_xy, "01") == vec2(2, 0));
    CHECK(edge(strand_maps::along_xy, "20") == vec2(0, -4));
    CHECK(edge(strand_maps::along_z, "02").x == 2.0f);
    CHECK(edge(strand_maps::normal_xy, "") == vec2(0.0f));
}

TEST_CASE("rays to all sides of a strand leave it, and begin within its width") {
    constexpr float radius_m = 0.3f;
    for (const StrandForm form :
         {StrandForm::Round, StrandForm::RoundLinear, StrandForm::Ribbon, StrandForm::Spheres}) {
        CAPTURE(static_cast<int>(form));
        StrandArrays arrays = straight(form, radius_m);
        if (form == StrandForm::Spheres)
            arrays.points = {{0, 0, 0, radius_m}}, arrays.first_points.clear();
        const auto scene = scene_of(arrays);
        SceneRandom random(9);
        int passed = 0;
        for (const Ray& ray : rays_around(1000, 0.25f, 3)) {
            const Hit hit = scene->closest_hit(ray);
            if (!hit.is_hit() || std::abs(ray.direction.z) > 0.9f)
                continue;
            const ShadingPoint point = scene->shading_point(ray, hit);
            const SpawnPoint spawn = other_side_spawn_point(*scene, hit, scene->spawn_point(ray, hit, point));
            const vec3 direction = random.direction();
            if (std::abs(direction.z) > 0.99f) // along the strand, whose end is near
                continue;
            const vec3 origin = spawn.towards(direction);
            CHECK(glm::length(origin - spawn.position) < 1.01f * radius_m);
            CHECK_FALSE(scene->closest_hit({.origin = origin, .direction = direction}).is_hit());
            ++passed;
        }
        CHECK(passed > 200);
    }
}

TEST_CASE("the triangles of a tube are as wide, and those of a sphere as large, as what they stand for on average") {
    for (const StrandForm form : {StrandForm::Round, StrandForm::RoundLinear, StrandForm::Spheres}) {
        StrandArrays arrays = straight(form, 0.2f);
        if (form == StrandForm::Spheres)
            arrays.points = {{1, 2, 3, 0.2f}}, arrays.first_points.clear();
        const Strands strands(arrays, Progress());
        const TubeMesh mesh(strands);
        std::vector<TriangleBvh::Triangle> triangles(mesh.triangles_per_piece());
        double surface = 0.0;
        for (std::size_t piece = 0; piece < mesh.piece_count(); ++piece) {
            mesh.write(piece, triangles);
            for (const auto& [a, b, c] : triangles)
                surface += 0.5 * double{glm::length(glm::cross(b - a, c - a))};
        }
        const double expected = form == StrandForm::Spheres ? 4.0 * double{pi} * 0.04 : 2.0 * double{pi} * 0.2 * 4.0;
        CHECK(surface == close_to(expected, 1e-4));
    }
}

// Seen to fail: where only the middle of what lies between two bends was compared.
TEST_CASE("between its bends a strand is straight and as wide, and a straight one has none") {
    CHECK(StrandBends(Strands(straight(StrandForm::Round, 0.2f), Progress())).of(0).size() == 2);
    StrandArrays arrays{.name = "curls"};
    SceneRandom random(3);
    for (int strand = 0; strand < 200; ++strand) {
        arrays.first_points.push_back(static_cast<std::uint32_t>(arrays.points.size()));
        vec3 at(0.0f), way = random.direction();
        for (int point = 0; point < 12; ++point) {
            arrays.points.emplace_back(at, random.uniform(0.01f, 0.012f));
            at += 0.1f * way;
            way = glm::normalize(way + random.uniform(0.0f, 0.4f) * random.direction());
        }
    }
    const Strands strands(arrays, Progress());
    StrandBends bends(strands);
    std::size_t bend_count = 0;
    for (std::uint32_t strand = 0; strand < 200; ++strand) {
        const std::span<const StrandPoint> points = bends.of(strand);
        bend_count += points.size();
        for (std::uint32_t segment = 11 * strand; segment < 11 * (strand + 1); ++segment)
            for (const float along : {0.0f, 0.21f, 0.5f, 0.83f}) {
                const StrandPoint at = strands.on_spline(segment, along);
                float nearest_m = std::numeric_limits<float>::infinity(), radius_m = 0.0f;
                for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                    const vec3 way = points[i + 1].centre - points[i].centre;
                    const float share =
                        std::clamp(glm::dot(at.centre - points[i].centre, way) / glm::dot(way, way), 0.0f, 1.0f);
                    const float off_m = glm::length(points[i].centre + share * way - at.centre);
                    if (off_m < nearest_m) {
                        nearest_m = off_m;
                        radius_m = points[i].radius_m + share * (points[i + 1].radius_m - points[i].radius_m);
                    }
                }
                CHECK(nearest_m < 0.21f * at.radius_m);
                CHECK(std::abs(radius_m - at.radius_m) < 0.05f * at.radius_m);
            }
    }
    CHECK(bend_count < 200 * 60);
}
} // namespace strands_test
