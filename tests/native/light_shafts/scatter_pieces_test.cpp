// SPDX-License-Identifier: GPL-3.0-or-later
// The closed form of the sun's scattering: its numerics over twelve decades of density, and its pieces against a march
// that asks Media for every way to the light.
#include "light_shafts/scatter_pieces.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>

namespace scatter_pieces_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

// Seen to fail, from 1e-6 per metre down, with the plain difference of exponentials planted in place of expm1.
TEST_CASE("a piece scatters the integral of its exponential, from clear air to soot, rising or falling") {
    for (const double sigma : {1e-9, 1e-6, 1e-3, 0.1, 10.0, 1e3})
        for (const double slope : {-1.0, -1e-3, 0.0, 0.5, 2.0}) {
            const float length_m = 7.0f, start = slope < 0.0 ? static_cast<float>(7.0 * sigma) : 0.25f;
            const ScatterPiece piece{.near_m = 1.0f,
                                     .far_m = 1.0f + length_m,
                                     .source_per_m = Rgb(2.0f),
                                     .depth_at_near = Rgb(start),
                                     .depth_per_m = Rgb(static_cast<float>(slope * sigma))};
            const double per_m = static_cast<float>(slope * sigma), gain = per_m * length_m;
            const double integral = gain == 0.0 ? length_m : -std::expm1(-gain) / per_m;
            const double expected = 2.0 * std::exp(-double{start}) * integral;
            CAPTURE(sigma);
            CAPTURE(slope);
            if (expected > 1e-30) // beyond: float's smallest numbers lose their digits
                CHECK(std::abs(scattered(piece, 1.0f, 8.0f).x / expected - 1.0) < 2e-6 + 1.2e-7 * double{start});
        }
}
TEST_CASE("an interval's parts add up to the whole") {
    const ScatterPiece piece{.near_m = 2.0f,
                             .far_m = 12.0f,
                             .source_per_m = {1, 2, 3},
                             .depth_at_near = {2, 0.1f, 0},
                             .depth_per_m = {-0.2f, 0.01f, 3.0f}};
    const Rgb whole = scattered(piece, 2.0f, 12.0f),
              parts = scattered(piece, 2.0f, 5.0f) + scattered(piece, 5.0f, 12.0f);
    for (int channel = 0; channel < 3; ++channel)
        CHECK(std::abs(parts[channel] / whole[channel] - 1.0f) < 1e-6f);
}

namespace {
/// A closed mesh that is no box and not convex: an octahedron with one corner pushed in.
std::shared_ptr<const TriangleMesh> dented() {
    return support::mesh_of(
        {.name = "dented",
         .positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -0.3f}, {0, 0, -1}},
         .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}});
}
/// A torus of 1,152 triangles: neither convex nor small, so that its cuts come from a hierarchy.
std::shared_ptr<const TriangleMesh> torus() {
    constexpr std::uint32_t around = 36, across = 16;
    MeshArrays arrays;
    arrays.name = "torus";
    for (std::uint32_t u = 0; u < around; ++u)
        for (std::uint32_t v = 0; v < across; ++v) {
            const float a = 6.2831853f * static_cast<float>(u) / around,
                        b = 6.2831853f * static_cast<float>(v) / across;
            const float radius = 0.7f + 0.3f * std::cos(b);
            arrays.positions.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.3f * std::sin(b));
            const std::uint32_t next_u = (u + 1) % around, next_v = (v + 1) % across;
            arrays.triangles.emplace_back(u * across + v, next_u * across + v, next_u * across + next_v);
            arrays.triangles.emplace_back(u * across + v, next_u * across + next_v, u * across + next_v);
        }
    return support::mesh_of(std::move(arrays));
}
} // namespace
TEST_CASE("pieces know the way to the light through boxes, meshes, nests and overlaps, along and against the ray") {
    const auto part = [](std::shared_ptr<const TriangleMesh> mesh, const mat4& place, int medium) {
        return support::Part{std::move(mesh), place, {.name = "fog", .medium_index = medium, .has_surface = false}};
    };
    const auto scaled = [](float x, float y, float z) { return glm::scale(mat4(1.0f), vec3(x, y, z)); };
    const auto scene = support::make_scene(
        {part(support::cube(), scaled(6, 5, 4), 0),
         part(support::cube(), support::translation({4, 0, 1}) * scaled(3, 2, 3), 1),
         part(dented(), scaled(3, -3, 3), 1), part(dented(), support::translation({-4, 1, 2}) * scaled(3, 3, 4), 2),
         part(torus(), support::translation({1, -1, -2}) * scaled(5, 4, -4), 2)},
        {{.name = "a", .lobes = {{{0.1f, 0.05f, 0.02f}, 0.3f}}},
         {.name = "b", .lobes = {{Rgb(0.05f), 0.0f}}, .sigma_a_per_m = {0.1f, 0.0f, 0.2f}},
         {.name = "c", .lobes = {{Rgb(0.2f), -0.5f}}}});
    const Media media(*scene, Progress());
    support::SceneRandom random(4);
    std::vector<vec3> suns = {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}};
    for (int index = 0; index < 5; ++index)
        suns.push_back(random.direction());
    double worst = 0.0;
    for (const vec3& towards_light : suns) {
        const DirectionalScatter scatter(media, {.towards_light = towards_light});
        for (int index = 0; index < 24; ++index) {
            ViewRay ray{8.0f * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)),
                        random.direction(), 0.0f, 30.0f};
            if (index == 0)
                ray.direction = towards_light;
            if (index == 1)
                ray.direction = -towards_light;
            std::vector<MediumSegment> segments;
            media.segments({.origin = ray.origin, .direction = ray.direction, .far_m = ray.far_m}, segments);
            std::vector<ScatterPiece> pieces;
            scatter.append_pieces(ray, segments, pieces);
            Rgb ours(0.0f);
            for (const ScatterPiece& piece : pieces)
                ours += scattered(piece, piece.near_m, piece.far_m);
            glm::dvec3 marched(0.0);
            constexpr int steps = 1500; // per segment, whose ends are known
            for (const MediumSegment& segment : segments) {
                const float step_m = (segment.far_m - segment.near_m) / steps;
                for (int step = 0; step < steps; ++step) {
                    const float t = segment.near_m + step_m * (static_cast<float>(step) + 0.5f);
                    marched += glm::dvec3(
                        step_m * media.scatter_per_m_sr(segment.set, glm::dot(ray.direction, towards_light)) *
                        media.transmittance({.origin = ray.origin, .direction = ray.direction, .far_m = t}) *
                        media.transmittance({.origin = ray.origin + t * ray.direction, .direction = towards_light}));
                }
            }
            if (!segments.empty())
                worst = std::max(worst, glm::length(glm::dvec3(ours) - marched) / glm::length(marched));
        }
    }
    CHECK(worst < 2e-3); // where the sun runs along a face, its way jumps: a march sees that to one step in 1,500
}
TEST_CASE("a sun in the world's endless medium is swallowed, in the channels that the medium takes part in") {
    SceneDescription description;
    description.media = {{.name = "haze", .lobes = {{{0.1f, 0.1f, 0.0f}, 0.0f}}}};
    description.world_medium_index = 0;
    const Scene scene(std::move(description), Progress());
    const Media media(scene, Progress());
    CHECK(DirectionalScatter(media, {}).is_black());
    CHECK(!DirectionalScatter(media, {.is_dimmed_by_media = false}).is_black());
}
} // namespace scatter_pieces_test
