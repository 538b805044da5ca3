// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces that let a part of the light pass, in slope rows and shadow maps: EXACT, which looks textures up along every
// cut, is the truth.
#include "core/simd.hpp"
#include "light_shafts/slope_rows_partial.hpp"
#include "light_shafts/slope_rows_visibility.hpp"
#include "support/partial_materials.hpp"
#include "support/scenes.hpp"
#include "support/shaft_settings.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <numbers>
#include <tbb/global_control.h>

namespace partial_rows_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// Cards of one material that stand around the origin, turned this way and that, one of them mirrored.
std::vector<Part> cards(const Material& material, int count = 4) {
    std::vector<Part> parts;
    for (int card = 0; card < count; ++card) {
        const auto c = static_cast<float>(card);
        const vec3 size = card == 1 ? vec3(-1.3f, 1.1f, 1.0f) : vec3(1.2f, 1.6f, 1.0f);
        parts.push_back(
            {.mesh = square(),
             .world_from_object = glm::scale(
                 glm::rotate(translation({1.8f * std::cos(1.7f * c), 1.5f * std::sin(1.7f * c), 0.5f * c - 0.8f}),
                             0.5f + 0.9f * c, glm::normalize(vec3(1.0f, 0.4f - 0.5f * c, 0.3f))),
                 size),
             .material = material});
    }
    return parts;
}

std::vector<Rgb> lit_lengths_m(const Visibility& visibility, std::span<const ViewRay> rays) {
    LitRows rows;
    visibility.lit_intervals(rays, rows);
    std::vector<Rgb> lengths(rays.size(), Rgb(0.0f));
    for (std::size_t r = 0; r < rays.size(); ++r)
        for (std::uint32_t i = rows.first[r]; i < rows.first[r + 1]; ++i)
            lengths[r] += (rows.intervals[i].far_m - rows.intervals[i].near_m) * rows.intervals[i].transmittance;
    return lengths;
}
std::vector<Rgb> lengths_by(MakeVisibility make, const Scene& scene, const Setting& setting,
                            std::span<const ViewRay> rays, std::uint32_t resolution, std::uint32_t seed = 0) {
    Progress progress;
    const Config config{.resolution = resolution, .seed = seed};
    return lit_lengths_m(*make(scene, setting.view, setting.light, rays, config, progress), rays);
}
struct Deviation {
    double rmse = 0.0, bias = 0.0; ///< Of all channels, over the mean.
};
Deviation error_of(const std::vector<Rgb>& values, const std::vector<Rgb>& truth) {
    double squares = 0.0, differences = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double difference = double{values[i][c]} - double{truth[i][c]};
            squares += difference * difference;
            differences += difference;
            sum += double{truth[i][c]};
        }
    return {std::sqrt(squares * 3.0 * static_cast<double>(values.size())) / sum, differences / sum};
}

/// What eight times the resolution must do to the error.
struct Expected {
    double most_error;        ///< Of the fine rows.
    double most_share = 0.35; ///< Of the coarse error: first order would be 1/8, noise 1/sqrt(8).
};
/// Coarse and fine rows of both methods against EXACT, in every view and light.
void check_convergence(const std::vector<Part>& parts, const Expected& expected) {
    const auto scene = make_scene(parts);
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 24);
        const auto exact = lengths_by(make_exact_strip, *scene, setting, rays, 0);
        for (const auto make : {make_epipolar, make_shadow_map}) {
            const auto coarse = error_of(lengths_by(make, *scene, setting, rays, 128), exact);
            const auto fine = error_of(lengths_by(make, *scene, setting, rays, 1024), exact);
            CAPTURE(coarse.rmse);
            CAPTURE(fine.rmse);
            CHECK(fine.rmse < expected.most_share * coarse.rmse + 5e-4);
            CHECK(fine.rmse < expected.most_error);
            CHECK(std::abs(fine.bias) < 0.15 * expected.most_error);
        }
    }
}
} // namespace

// Seen to fail with u read as v, mirrored images read as repeated ones, alpha ignored, and faces of a cube of which the
// texture is not in perspective.
TEST_CASE("alpha that is 0 or 1: rows and maps converge to EXACT, whatever the image, its filter and its extension") {
    SUBCASE("checkerboard") { check_convergence(cards(checkerboard_alpha()), {.most_error = 0.015}); }
    SUBCASE("disc") { check_convergence(cards(disc_alpha()), {.most_error = 0.015}); }
    SUBCASE("disc, four times on a card, and mirrored") {
        Material material = disc_alpha(TextureExtension::Mirror);
        material.program[0].uv_matrix = glm::mat3(2, 0.3f, 0, -0.2f, 3, 0, -0.7f, 0.4f, 1);
        check_convergence(cards(material), {.most_error = 0.015});
    }
    SUBCASE("disc that ends with its image") {
        Material material = disc_alpha(TextureExtension::Clip);
        material.program[0].uv_matrix = glm::mat3(2, 0, 0, 0, 1.5f, 0, -0.6f, -0.2f, 1);
        check_convergence(cards(material), {.most_error = 0.015});
    }
    SUBCASE("disc that goes on with its border") {
        Material material = disc_alpha(TextureExtension::Extend);
        material.program[0].uv_matrix = glm::mat3(2, 0, 0, 0, 1.5f, 0, -0.6f, -0.2f, 1);
        check_convergence(cards(material), {.most_error = 0.015});
    }
    SUBCASE("leaves among opaque triangles") {
        std::vector<Part> parts = cards(disc_alpha());
        const TriangleSoup soup = make_soup(30, 3.0f, 0.6f, vec3(0.0f), 3);
        parts.push_back({.mesh = mesh_of({.name = "soup", .positions = soup.positions, .triangles = soup.triangles})});
        check_convergence(parts, {.most_error = 0.02});
    }
}

TEST_CASE("surfaces that read their points: where they lie, how they are seen, images on a box around them") {
    // EXACT cuts a triangle into 32 pieces where no texels tell where its transparency changes.
    const Expected stepped{.most_error = 0.03, .most_share = 0.6};
    SUBCASE("stripes") { check_convergence(cards(striped()), stepped); }
    SUBCASE("an image on a box") {
        Texture texture = alpha_image("disc", 64, [](float u, float v) {
            return (u - 0.35f) * (u - 0.35f) + 0.5f * (v - 0.6f) * (v - 0.6f) < 0.09f ? 1.0f : 0.0f;
        });
        check_convergence(cards(boxed(std::move(texture))), stepped);
    }
    SUBCASE("seen at an angle") { check_convergence(cards(transparent_at_edges()), stepped); }
}

TEST_CASE("what passes in part is right on average, and its noise falls with the resolution") {
    const Expected noisy{.most_error = 0.06, .most_share = 0.6};
    SUBCASE("alpha that rises along u") { check_convergence(cards(gradient_alpha()), noisy); }
    SUBCASE("a veil") { check_convergence(cards(veil(0.3f)), noisy); }
    SUBCASE("coloured panes, behind one another") { check_convergence(cards(pane({0.9f, 0.2f, 0.05f})), noisy); }
}

// Seen to fail with mirrored instances that keep their winding.
TEST_CASE("back faces that let light pass: as shadow rays see them, under every light") {
    check_convergence(cards(one_way()), {.most_error = 0.015});
}

// Seen to fail with one draw for all triangles.
TEST_CASE("layers multiply: three veils over one another let through the cube, whichever triangles they are") {
    std::vector<Part> parts;
    for (int layer = 0; layer < 3; ++layer)
        parts.push_back(
            {.mesh = square(),
             .world_from_object = glm::scale(translation({0, 0, 3.0f + 0.1f * static_cast<float>(layer)}), vec3(30.0f)),
             .material = veil(0.5f)});
    const auto scene = make_scene(parts);
    const Setting setting{"below veils", perspective({0, -6, 0.5f}), sun({0.1f, 0.2f, 1.0f})};
    const auto rays = make_rays(setting, 16);
    const auto exact = lengths_by(make_exact_strip, *scene, setting, rays, 0);
    for (const auto make : {make_epipolar, make_shadow_map})
        for (std::uint32_t seed = 0; seed < 3; ++seed) {
            // 256 rays cross some 500 lines each: a standard deviation of 0.33 / 0.125 / sqrt(128,000), if they share none.
            CHECK(std::abs(error_of(lengths_by(make, *scene, setting, rays, 2048, seed), exact).bias) < 0.02);
        }
}

// Seen to fail with a plain hash per line.
TEST_CASE("one veil is held far better than by chance: its thresholds are even along the lines") {
    std::vector<Part> parts{{.mesh = square(),
                             .world_from_object = glm::scale(translation({0, 0, 3.0f}), vec3(60.0f)),
                             .material = veil(0.3f)}};
    const auto scene = make_scene(parts);
    const Setting setting{"below a veil", perspective({0, -6, 0.5f}), sun({0.1f, 0.2f, 1.0f})};
    const auto rays = make_rays(setting, 16);
    const auto exact = lengths_by(make_exact_strip, *scene, setting, rays, 0);
    // By chance it would be sqrt(0.3 * 0.7 / 500) / 0.3, 7 %, for rays of some 500 lines.
    CHECK(error_of(lengths_by(make_epipolar, *scene, setting, rays, 1024), exact).rmse < 0.02);
}

TEST_CASE("bits do not depend on the number of threads; targets of SIMD agree") {
    std::vector<Part> parts = cards(disc_alpha());
    for (Part& part : cards(veil(0.4f), 3))
        parts.push_back(part);
    const auto scene = make_scene(parts);
    for (const std::size_t index : {std::size_t{0}, std::size_t{3}, std::size_t{6}}) {
        const Setting setting = settings()[index];
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 24);
        for (const auto make : {make_epipolar, make_shadow_map}) {
            const auto all = lengths_by(make, *scene, setting, rays, 1024);
            {
                const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
                CHECK(lengths_by(make, *scene, setting, rays, 1024) == all);
            }
            for (const SimdTarget target : available_simd_targets()) {
                const ForcedSimdTarget forced(target);
                CAPTURE(simd_target_name());
                // Roundings move single lines across the border of a texel.
                CHECK(error_of(lengths_by(make, *scene, setting, rays, 1024), all).rmse < 2e-3);
            }
        }
    }
}

TEST_CASE("a coloured surface costs three sets of rows, but only where it may shade the lit air") {
    Progress progress;
    const auto sets = [&](const vec3& place) {
        std::vector<Part> parts = cards(disc_alpha());
        parts.push_back({.mesh = square(), .world_from_object = translation(place), .material = pane({1, 0.5f, 0})});
        const auto scene = make_scene(parts);
        const Setting setting = settings()[0];
        const auto rays = make_rays(setting, 16);
        const auto visibility = make_epipolar(*scene, setting.view, setting.light, rays, {.resolution = 64}, progress);
        CHECK(visibility->statistics().reports.empty());
        const auto& counts = visibility->statistics().counts;
        const auto found =
            std::ranges::find(counts, "slope rows: sets for coloured surfaces", &Statistics::Count::name);
        return found == counts.end() ? 1.0 : found->value;
    };
    CHECK(sets({0, 0, 0}) == 3.0);
    CHECK(sets({0, 0, -40}) == 1.0); // below all view rays, and the sun shines from above
}
} // namespace partial_rows_test
