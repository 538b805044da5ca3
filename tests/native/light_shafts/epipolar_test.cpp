// SPDX-License-Identifier: GPL-3.0-or-later
// The whole methods through their interface, on scenes, with EXACT as the truth.
#include "light_shafts/visibility.hpp"
#include "support/relative_error.hpp"
#include "support/scenes.hpp"
#include "support/shaft_settings.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace epipolar_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
struct Case {
    Setting setting;
    std::unique_ptr<Scene> scene;
    std::vector<ViewRay> rays;
};
std::shared_ptr<const TriangleMesh> soup_mesh(float scale) {
    TriangleSoup soup = make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3);
    for (vec3& position : soup.positions)
        position *= scale;
    return mesh_of({.name = "soup", .positions = soup.positions, .triangles = soup.triangles});
}
/// The setting at another size and place.
Case make_case(Setting setting, float scale, const vec3& offset) {
    Case made;
    setting.scale_m = scale;
    setting.view.position = scale * setting.view.position + offset;
    setting.light.position = scale * setting.light.position + offset;
    setting.centre = offset;
    made.setting = setting;
    made.rays = make_rays(setting, 32);
    made.scene = make_scene({{.mesh = soup_mesh(scale), .world_from_object = translation(offset)}});
    return made;
}
std::vector<double> lit_lengths_m(const Visibility& visibility, std::span<const ViewRay> rays) {
    LitRows rows;
    visibility.lit_intervals(rays, rows);
    std::vector<double> lengths(rays.size(), 0.0);
    for (std::size_t r = 0; r < rays.size(); ++r)
        for (std::uint32_t i = rows.first[r]; i < rows.first[r + 1]; ++i)
            lengths[r] += double{rows.intervals[i].far_m} - double{rows.intervals[i].near_m};
    return lengths;
}
std::vector<double> lengths_by(MakeVisibility make, const Case& made, std::uint32_t resolution,
                               std::span<const ViewRay> asked = {}, bool walks_maps = false) {
    Progress progress;
    const Config config{.resolution = resolution, .walks_maps = walks_maps};
    const auto visibility = make(*made.scene, made.setting.view, made.setting.light, made.rays, config, progress);
    return lit_lengths_m(*visibility, asked.empty() ? std::span<const ViewRay>(made.rays) : asked);
}
} // namespace

TEST_CASE("EPIPOLAR and SHADOW_MAP converge to EXACT: eight times the resolution, a quarter of the error at most") {
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const Case made = make_case(setting, 1.0f, vec3(0.0f));
        const auto exact = lengths_by(make_exact_strip, made, 0);
        for (const auto make : {make_epipolar, make_shadow_map}) {
            const double coarse = relative_rmse(lengths_by(make, made, 128), exact);
            const double fine = relative_rmse(lengths_by(make, made, 1024), exact);
            CAPTURE(coarse);
            CAPTURE(fine);
            CHECK(fine < 0.25 * coarse + 1e-4);
            CHECK(fine < 0.02);
        }
    }
}

TEST_CASE("size and place of a scene do not matter: microns, thousands of kilometres, 60 km from the origin") {
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto plain = lengths_by(make_epipolar, make_case(setting, 1.0f, vec3(0.0f)), 512);
        for (const float scale : {0x1p-20f, 0x1p-10f, 0x1p20f}) { // powers of two: the same roundings
            CAPTURE(scale);
            auto scaled = lengths_by(make_epipolar, make_case(setting, scale, vec3(0.0f)), 512);
            for (double& length : scaled)
                length /= double{scale};
            CHECK(relative_rmse(scaled, plain) < 2e-3);
        }
        // 60 km out positions of camera and light are rounded to 4 mm, in a scene of 6 m.
        const Case far_away = make_case(setting, 1.0f, vec3(60000.0f, -60000.0f, 1000.0f));
        const auto exact = lengths_by(make_exact_strip, far_away, 0);
        CHECK(relative_rmse(lengths_by(make_epipolar, far_away, 512), exact) < 0.02);
        CHECK(relative_rmse(lengths_by(make_shadow_map, far_away, 512), exact) < 0.03);
    }
}

/// Through and next to the epipole, on both sides.
static std::vector<ViewRay> rays_at_epipole(const Setting& setting) {
    const vec3 epipole = setting.light.is_directional ? setting.light.towards_light
                                                      : glm::normalize(setting.light.position - setting.view.position);
    const auto [side, up] = orthonormal_basis(epipole);
    std::vector<ViewRay> rays;
    for (const float sign : {1.0f, -1.0f})
        for (const float angle_rad : {0.0f, 1e-7f, 1e-5f, 1e-3f, 3e-3f})
            for (int turn = 0; turn < 8; ++turn) {
                const auto phi = static_cast<float>(turn);
                const vec3 off = std::cos(phi) * side + std::sin(phi) * up;
                rays.push_back({setting.view.position, glm::normalize(sign * epipole + angle_rad * off), 0.01f, 9.0f});
            }
    return rays;
}

TEST_CASE("rays through and next to the epipole are answered exactly") {
    for (const std::size_t index : {std::size_t{1}, std::size_t{2}, std::size_t{4}, std::size_t{5}}) {
        const Case made = make_case(settings()[index], 1.0f, vec3(0.0f));
        CAPTURE(made.setting.name);
        const std::vector<ViewRay> rays = rays_at_epipole(made.setting);
        const auto exact = lengths_by(make_exact_strip, made, 0, rays);
        for (const auto make : {make_epipolar, make_shadow_map}) {
            const auto found = lengths_by(make, made, 512, rays);
            for (std::size_t r = 0; r < rays.size(); ++r) {
                CAPTURE(r);
                CHECK(std::abs(found[r] - exact[r]) < 1e-4);
            }
        }
    }
}

// Seen to fail where the map is not handed on: then they are exact.
TEST_CASE(
    "where maps are walked, those rays are as right as the map, and all others as right as without; of lamps they are "
    "the same bits") {
    double coarse = 0.0, fine = 0.0;
    for (const std::size_t index : {std::size_t{1}, std::size_t{2}, std::size_t{4}, std::size_t{5}}) {
        const Case made = make_case(settings()[index], 1.0f, vec3(0.0f));
        CAPTURE(made.setting.name);
        const std::vector<ViewRay> rays = rays_at_epipole(made.setting);
        const auto exact = lengths_by(make_exact_strip, made, 0, rays);
        coarse += relative_rmse(lengths_by(make_shadow_map, made, 64, rays, true), exact);
        fine += relative_rmse(lengths_by(make_shadow_map, made, 1024, rays, true), exact);
        const auto walked = lengths_by(make_shadow_map, made, 512, {}, true);
        const auto asked = lengths_by(make_shadow_map, made, 512);
        std::size_t differing = 0;
        for (std::size_t r = 0; r < walked.size(); ++r)
            differing += walked[r] != asked[r];
        if (!made.setting.light.is_directional)
            CHECK(differing < walked.size() / 20);
        const auto every = lengths_by(make_exact_strip, made, 0);
        CHECK(relative_rmse(walked, every) < 1.2 * relative_rmse(asked, every) + 1e-4);
    }
    CHECK(coarse > 0.0);
    CHECK(coarse < 4 * 0.4);
    CHECK(fine < coarse / 4.0);
}

TEST_CASE("rays that were not announced are right as well") {
    const Case made = make_case(settings()[0], 1.0f, vec3(0.0f));
    std::vector<ViewRay> rays;
    SceneRandom random(31);
    for (int i = 0; i < 200; ++i)
        rays.push_back({made.setting.view.position, random.direction(), 0.0f, 30.0f});
    const auto exact = lengths_by(make_exact_strip, made, 0, rays);
    CHECK(relative_rmse(lengths_by(make_epipolar, made, 1024, rays), exact) < 0.01);
}

TEST_CASE("where no slices exist, EXACT answers and the statistics say so") {
    const Setting along{"orthographic along the sun", orthographic({0, 1, 0}), sun({0, 1, 0})};
    const Case made = make_case(along, 1.0f, vec3(0.0f));
    Progress progress;
    const auto visibility = make_epipolar(*made.scene, along.view, made.setting.light, made.rays, {}, progress);
    const auto& reports = visibility->statistics().reports;
    REQUIRE(!reports.empty());
    CHECK(reports.back() == "the sun shines along the orthographic view: EXACT instead of EPIPOLAR");
    CHECK(relative_rmse(lengths_by(make_epipolar, made, 256), lengths_by(make_exact_strip, made, 0)) == 0.0);
}

TEST_CASE("a light without shadows, and a scene without occluders, leave every ray lit and build nothing") {
    Case made = make_case(settings()[0], 1.0f, vec3(0.0f));
    made.setting.light.casts_shadow = false;
    const auto lengths = lengths_by(make_epipolar, made, 256);
    for (std::size_t r = 0; r < made.rays.size(); ++r)
        CHECK(lengths[r] == double{made.rays[r].far_m} - double{made.rays[r].near_m});
}
} // namespace epipolar_test
