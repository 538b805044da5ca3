// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query.hpp"
#include "light_shafts/shadow_map.hpp"
#include "support/relative_error.hpp"
#include "support/shaft_settings.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <numbers>

namespace shadow_map_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// Lit length by walking along the texels of the map: each of `steps` midpoints asks its own texel.
double walked_lit_length_m(const ShadowMap& map, const LightSample& light, const ViewRay& ray, int steps) {
    const double step_m = (double{ray.far_m} - double{ray.near_m}) / steps;
    int lit = 0;
    for (int i = 0; i < steps; ++i) {
        const vec3 point = ray.origin + static_cast<float>(ray.near_m + (i + 0.5) * step_m) * ray.direction;
        if (light.is_directional) {
            const DepthMap& face = map.faces[0];
            const vec3 p = point - face.origin;
            lit += glm::dot(p, face.z_axis) >= face.depth_at(glm::dot(p, face.x_axis), glm::dot(p, face.y_axis));
        } else {
            const FacePoint p = face_point(map, point - light.position);
            lit += p.face == nullptr || 1.0f / p.z >= p.face->depth_at(p.x, p.y);
        }
    }
    return lit * step_m;
}

struct Lengths {
    std::vector<double> lit_m;
    std::size_t interval_count = 0;
};
Lengths row_lengths(const slope_rows::Rows& rows, std::span<const ViewRay> rays) {
    LitRows lit;
    row_query::Uncovered uncovered;
    row_query::lit_intervals(rows, rays, lit, uncovered);
    Lengths lengths{.lit_m = std::vector<double>(rays.size(), 0.0), .interval_count = lit.intervals.size()};
    for (std::size_t r = 0; r < rays.size(); ++r)
        for (std::uint32_t i = lit.first[r]; i < lit.first[r + 1]; ++i)
            lengths.lit_m[r] += double{lit.intervals[i].far_m} - double{lit.intervals[i].near_m};
    return lengths;
}
} // namespace

TEST_CASE("rows of a map become the walk along its texels, once they are finer than the texels") {
    const Soup soup(make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3));
    Progress progress;
    for (const std::size_t index : {std::size_t{0}, std::size_t{3}, std::size_t{6}, std::size_t{9}}) {
        const Setting setting = settings()[index];
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 24);
        // One map of 128 texels for all: that of the coarse rows.
        slope_rows::Rows coarse(slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light), rays,
                                                        {.lines = 256}, progress));
        const ShadowMap map = raster_shadow_map(coarse.layout, setting.light, 128, soup.occluders, progress);
        std::vector<double> walked, truth;
        for (const ViewRay& ray : rays) {
            walked.push_back(walked_lit_length_m(map, setting.light, ray, 4000));
            truth.push_back(marched_lit_length_m(soup.soup, setting.light, ray, 500));
        }
        rectify(map, coarse, progress);
        slope_rows::Rows fine(slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light), rays,
                                                      {.lines = 2048}, progress));
        rectify(map, fine, progress);
        const double coarse_error = relative_rmse(row_lengths(coarse, rays).lit_m, walked);
        const double fine_error = relative_rmse(row_lengths(fine, rays).lit_m, walked);
        const double map_error = relative_rmse(walked, truth);
        CAPTURE(coarse_error);
        CAPTURE(fine_error);
        CAPTURE(map_error);
        CHECK(fine_error < 0.3 * coarse_error);
        CHECK(fine_error < 0.25 * map_error);
    }
}

TEST_CASE("a shadow across the seams of a cube of faces has no gap: as many lit parts as brute force finds") {
    // A ceiling over the lamp: the border of its shadow runs through four faces, view rays cross all seams.
    TriangleSoup square;
    square.positions = {{-9, -9, 1.0f}, {9, -9, 1.0f}, {9, 9, 1.0f}, {-9, 9, 1.0f}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    const Soup soup(square);
    Setting setting{"lamp below a ceiling", perspective({0.3f, -8.0f, 3.0f}), lamp({0.1f, 0.2f, 0.3f})};
    const auto rays = make_rays(setting, 48);
    const slope_rows::Rows rows = make_rows(setting, soup, rays, 1024, true);
    LitRows lit;
    row_query::Uncovered uncovered;
    row_query::lit_intervals(rows, rays, lit, uncovered);
    std::size_t different = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
        int expected = 0;
        bool was_lit = false;
        for (int i = 0; i < 400; ++i) {
            const double t = rays[r].near_m + (i + 0.5) / 400 * (rays[r].far_m - rays[r].near_m);
            const bool now_lit = is_lit(soup.soup, setting.light, dvec3(rays[r].origin) + t * dvec3(rays[r].direction));
            expected += now_lit && !was_lit;
            was_lit = now_lit;
        }
        different += static_cast<int>(lit.first[r + 1] - lit.first[r]) != expected;
    }
    CHECK(different < rays.size() / 50); // parts shorter than a texel
}

TEST_CASE("a narrow spot has one face, a wide one and a point light six") {
    const Soup soup(make_soup(20, 3.0f, 0.8f, vec3(0.0f), 3));
    Setting setting = settings()[3];
    const auto rays = make_rays(setting, 16);
    Progress progress;
    const slope_rows::Layout layout =
        slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light), rays, {.lines = 64}, progress);
    Light spot;
    spot.kind = LightKind::Spot;
    setting.light.spot = &spot;
    const auto face_count = [&](float half_angle_rad) {
        spot.spot_half_angle_rad = half_angle_rad;
        return raster_shadow_map(layout, setting.light, 64, soup.occluders, progress).faces.size();
    };
    CHECK(face_count(0.5f) == 1);
    CHECK(face_count(0.25f * std::numbers::pi_v<float>) == 6);
    CHECK(face_count(1.5f) == 6);
    setting.light.spot = nullptr;
    CHECK(raster_shadow_map(layout, setting.light, 64, soup.occluders, progress).faces.size() == 6);
}

TEST_CASE("inside its cone a narrow spot's single face shadows as the cube does") {
    const Soup soup(make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3));
    Setting setting = settings()[3];
    Light spot;
    spot.kind = LightKind::Spot;
    spot.spot_half_angle_rad = 0.6f;
    spot.spot_axis = glm::normalize(-setting.light.position);
    setting.light.spot = &spot;
    Progress progress;
    const auto rays = make_rays(setting, 24);
    const slope_rows::Layout layout =
        slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light), rays, {.lines = 64}, progress);
    const ShadowMap map = raster_shadow_map(layout, setting.light, 2048, soup.occluders, progress);
    SceneRandom random(5);
    int different = 0;
    for (int i = 0; i < 4000; ++i) {
        const vec3 point = 3.0f * random.direction();
        const vec3 from_light = point - setting.light.position;
        if (glm::dot(glm::normalize(from_light), spot.spot_axis) < std::cos(0.59f))
            continue;
        const FacePoint p = face_point(map, from_light);
        different += (1.0f / p.z >= p.face->depth_at(p.x, p.y)) != is_lit(soup.soup, setting.light, dvec3(point));
    }
    CHECK(different < 30); // points within half a texel of a shadow's border
}
} // namespace shadow_map_test
