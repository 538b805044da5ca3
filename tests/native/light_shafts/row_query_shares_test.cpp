// SPDX-License-Identifier: GPL-3.0-or-later
// Lit shares of steps from slope rows against the lit intervals of the same rows, however many lines a step has.
#include "light_shafts/visibility.hpp"
#include "support/soup.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

namespace row_query_shares_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
std::vector<ViewRay> rays_through_soup(std::size_t count) {
    support::SceneRandom random(4);
    std::vector<ViewRay> rays;
    for (std::size_t ray = 0; ray < count; ++ray) {
        const float far_m = ray % 7 == 0 ? 7.5f : 8.0f + 6.0f * random.uniform();
        rays.push_back({.origin = {0, -8, 1},
                        .direction = glm::normalize(vec3(random.uniform() - 0.5f, 1.0f, random.uniform() - 0.5f)),
                        .near_m = ray % 5 == 0 ? 6.0f : 1.0f,
                        .far_m = far_m});
    }
    return rays;
}
} // namespace

TEST_CASE("shares of steps are those of the lit intervals: to a line where steps are short, to 4 samples elsewhere") {
    const std::vector<ViewRay> rays = rays_through_soup(300);
    const auto scene = support::make_scene(
        {{.mesh = support::soup_mesh(2000, {.min = vec3(-5, -5, -3), .max = vec3(5, 5, 6)}, 0.8f, 9)}});
    const LightSample sun{.towards_light = glm::normalize(vec3(0.4f, 0.1f, 1.0f))};
    Progress progress;
    for (const std::uint32_t lines : {256u, 2048u, 8192u})
        for (const std::uint32_t step_count : {1u, 7u, 64u, 500u}) {
            CAPTURE(lines);
            CAPTURE(step_count);
            const auto visibility = make_epipolar(*scene, {.position = rays[0].origin}, sun, rays,
                                                  {.method = Method::Epipolar, .resolution = lines}, progress);
            std::vector<float> begin_m, step_m;
            for (const ViewRay& ray : rays) {
                begin_m.push_back(ray.near_m);
                step_m.push_back((ray.far_m - ray.near_m) / static_cast<float>(step_count));
            }
            const StepRows steps{begin_m, step_m, step_count};
            std::vector<float> shares(rays.size() * step_count, -1.0f), of_intervals = shares;
            visibility->find_lit_shares(rays, steps, shares);
            visibility->Visibility::find_lit_shares(rays, steps, of_intervals);
            double away2 = 0.0, bias = 0.0, lit = 0.0;
            for (std::size_t at = 0; at < shares.size(); ++at) {
                REQUIRE(shares[at] >= 0.0f);
                REQUIRE(shares[at] <= 1.0f);
                const double away = double{shares[at]} - double{of_intervals[at]};
                away2 += away * away;
                bias += away;
                lit += double{of_intervals[at]};
            }
            const auto count = static_cast<double>(shares.size());
            REQUIRE(lit / count > 0.2);
            REQUIRE(lit / count < 0.9);
            // Samples of shares between 0 and 1, of which groups of 16 lines are one each at worst; a ray has half of the
            // lines, more or less.
            const double groups = std::clamp(0.5 * lines / step_count / 16.0, 1.0, std::max(4.0, 256.0 / step_count));
            CHECK(std::sqrt(away2 / count) < 0.4 / std::sqrt(groups));
            CHECK(std::abs(bias / lit) < 0.02);
        }
}

TEST_CASE("a step counts by how much of it is lit") {
    std::vector<float> shares(4, 0.0f);
    add_lit_share(-1.0f, 0.25f, 1.0f, shares);
    add_lit_share(0.5f, 2.5f, 0.5f, shares);
    add_lit_share(3.0f, 9.0f, 1.0f, shares);
    add_lit_share(3.5f, 3.5f, 1.0f, shares);
    CHECK(shares == std::vector<float>{0.5f, 0.5f, 0.25f, 1.0f});
}
} // namespace row_query_shares_test
