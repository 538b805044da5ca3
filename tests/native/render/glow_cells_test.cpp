// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/simd.hpp"
#include "render/glow_cells.hpp"
#include "support/close_to.hpp"
#include "support/fog_draws.hpp"
#include "support/one_point.hpp"
#include "volume/phase_function.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <functional>

namespace glow_cells_test {
using namespace tyndall;
using namespace tyndall::support;
using glm::dvec3;
using render::GlowBesideLine;
using render::GlowCells;
using render::MediaLine;

namespace {
const light_shafts::ViewRay along_x{vec3(-3.0f, 0.1f, -0.2f), vec3(1, 0, 0), 0.0f, 6.0f};

/// Of a triangle as seen from a point: by its angles, which the formula under test does not use.
double solid_angle_sr(const std::array<vec3, 3>& corners, const dvec3& point) {
    std::array<dvec3, 3> sides, across;
    for (int index = 0; index < 3; ++index)
        sides[std::size_t(index)] = glm::normalize(dvec3(corners[std::size_t(index)]) - point);
    for (std::size_t index = 0; index < 3; ++index)
        across[index] = glm::normalize(glm::cross(sides[index], sides[(index + 1) % 3]));
    double excess = -glm::pi<double>();
    for (std::size_t index = 0; index < 3; ++index)
        excess += std::acos(glm::clamp(-glm::dot(across[index], across[(index + 2) % 3]), -1.0, 1.0));
    return excess;
}

struct Seen {
    std::shared_ptr<const Scene> scene;
    Media media;
    MediaLine line;
    explicit Seen(std::vector<Medium> fog)
        : scene(make_scene({box_of(0, {-2, 0, 0}, {1, 4, 4}), box_of(1, {1.5f, 0, 0}, {1.5f, 4, 4})}, std::move(fog))),
          media(*scene, Progress()) {
        line.assign(media, along_x, StepLimits{});
        REQUIRE(line.pieces().size() == 2);
    }
};

/// Checks the weights of 21 cells in each piece against sums of their own.
void check_weights(const Seen& seen, const GlowBesideLine& glow, double most_error,
                   const std::function<double(const dvec3& point)>& seen_sr) {
    GlowCells cells;
    cells.append(seen.line.pieces()[0], 0.5f, 0.5f); // a cell without a length is never drawn
    for (const MediaLine::Piece& piece : seen.line.pieces())
        for (int index = 0; index < 21; ++index) {
            const auto x_at = [&](int border) {
                const float at_m = glm::mix(piece.near_m, piece.far_m, static_cast<float>(border) / 21.0f);
                return (at_m - glow.foot_m) / glow.off_m;
            };
            cells.append(piece, x_at(index), x_at(index + 1));
        }
    cells.weigh(seen.line, glow);
    REQUIRE(cells.size() == 43);
    CHECK(cells.weight(0) == 0.0f);
    CHECK(cells.angle_rad(0) == 0.0f);
    const double off_m = glow.off_m;
    for (std::size_t cell = 1; cell < cells.size(); ++cell) {
        CAPTURE(cell);
        const double from = std::atan(double(cells.from_x(cell))), to = std::atan(double(cells.to_x(cell)));
        CHECK(cells.angle_rad(cell) == close_to(to - from, 1e-5));
        const MediaLine::Piece& piece = cells.piece(cell);
        const double x = std::tan(0.5 * (from + to)), at_m = glow.foot_m + off_m * x;
        const dvec3 point = dvec3(along_x.origin) + at_m * dvec3(along_x.direction);
        const dvec3 way = dvec3(along_x.origin) + dvec3(glow.from_origin) - point;
        double scattered = 0.0;
        for (const auto& [sigma_s, asymmetry_g, draine_alpha] : seen.line.lobes_of(piece))
            scattered +=
                double(sigma_s) * draine_per_sr(static_cast<float>(glm::dot(glm::normalize(way), dvec3(1, 0, 0))),
                                                asymmetry_g, draine_alpha);
        double passing = 0.0;
        for (int channel = 0; channel < 3; ++channel) {
            double depth = double(piece.depth[channel]) + (at_m - piece.near_m) * double(piece.sigma_t_per_m[channel]);
            if (glow.is_dimmed) {
                const auto& from_place = glow.light_side[at_m >= glow.light_side[1].at_m ? 1 : 0];
                depth +=
                    double(from_place.depth[channel]) + (at_m - from_place.at_m) * double(from_place.per_m[channel]);
            }
            passing += std::exp(-depth) / 3.0;
        }
        const double brightness = seen_sr(point) * scattered * passing;
        CHECK(cells.weight(cell) == close_to(brightness * (1.0 + x * x) * (to - from), most_error));
    }
}
const Medium even{.name = "even", .lobes = {{Rgb(0.4f), 0.0f}}};
const Medium coloured{.name = "coloured",
                      .lobes = {{Rgb(0.3f, 0.5f, 0.1f), 0.6f}, {Rgb(0.2f), -0.4f, 2.0f}},
                      .sigma_a_per_m = Rgb(0.1f, 0.0f, 0.3f)};
} // namespace

// Seen to fail with the second piece's lobes in the first one, and with the light's side left out.
TEST_CASE("cells of a line weigh what their middles scatter of a lamp, in even fog, in colours and behind more fog") {
    for (const auto& fog : {std::vector{even, even}, std::vector{even, coloured}, std::vector{coloured, even}})
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            const Seen seen(fog);
            for (const bool is_dimmed : {false, true}) {
                GlowBesideLine glow{
                    .from_origin = vec3(2.2f, 0.4f, -0.9f), .radius2 = 0.04f, .foot_m = 2.2f, .off_m = 1.1f};
                glow.light_side[0] = {0.0f, Rgb(1.2f, 0.7f, 0.4f), Rgb(-0.3f, -0.1f, 0.0f)};
                glow.light_side[1] = {2.2f, Rgb(0.54f, 0.48f, 0.4f), Rgb(0.1f, 0.2f, 0.15f)};
                glow.is_dimmed = is_dimmed;
                check_weights(seen, glow, 1e-4, [&](const dvec3& point) {
                    const dvec3 way = dvec3(along_x.origin) + dvec3(glow.from_origin) - point;
                    return 1.0 / (glm::dot(way, way) + 0.04);
                });
            }
        }
}

TEST_CASE(
    "cells of a line weigh the part of the sky that a triangle covers, from near, from far and through its plane") {
    const Seen seen({even, coloured});
    for (const float size_m : {0.02f, 0.5f, 3.0f}) {
        CAPTURE(size_m);
        const vec3 centre(-0.4f, 0.6f, 0.3f);
        const std::array corners{centre + size_m * vec3(-0.5f, -0.3f, 0.1f), centre + size_m * vec3(0.6f, -0.2f, 0.2f),
                                 centre + size_m * vec3(-0.1f, 0.5f, -0.3f)};
        const vec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        render::EmissiveTriangle triangle{};
        triangle.corners = corners;
        triangle.area_m2 = 0.5f * glm::length(across);
        triangle.normal = glm::normalize(across);
        const GlowBesideLine glow{.from_origin = centre - along_x.origin,
                                  .radius2 = size_m * size_m * 0.5f,
                                  .foot_m = 2.6f,
                                  .off_m = 0.7f + 0.5f * size_m,
                                  .triangle = &triangle};
        // From three radii a triangle counts as a point: a small one covers what its cosine says to its square.
        check_weights(seen, glow, size_m < 0.1f ? 2e-3 : 0.07,
                      [&](const dvec3& point) { return solid_angle_sr(corners, point); });
    }
}
} // namespace glow_cells_test
