// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "light_shafts/ray_outline.hpp"
#include "light_shafts/row_query.hpp"
#include "light_shafts/slope_rows.hpp"
#include "support/shaft_settings.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace slope_rows_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
struct Comparison {
    double relative_rmse = 0.0, bias = 0.0;
    std::size_t compared = 0, near_epipole = 0, outside = 0;
};
Comparison compare(const Setting& setting, const Soup& soup, std::span<const ViewRay> rays,
                   std::span<const double> truth_m, std::uint32_t lines, bool from_map) {
    const slope_rows::Rows rows = make_rows(setting, soup, rays, lines, from_map);
    LitRows lit;
    row_query::Uncovered uncovered;
    row_query::lit_intervals(rows, rays, lit, uncovered);
    std::vector<bool> is_skipped(rays.size());
    for (const std::uint32_t ray : uncovered.near_epipole)
        is_skipped[ray] = true;
    Comparison result{.near_epipole = uncovered.near_epipole.size(), .outside = uncovered.outside.size()};
    double square_sum = 0.0, difference_sum = 0.0, truth_sum = 0.0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
        if (is_skipped[r])
            continue;
        double length_m = 0.0;
        for (std::uint32_t i = lit.first[r]; i < lit.first[r + 1]; ++i)
            length_m += double{lit.intervals[i].far_m} - double{lit.intervals[i].near_m};
        square_sum += (length_m - truth_m[r]) * (length_m - truth_m[r]);
        difference_sum += length_m - truth_m[r];
        truth_sum += truth_m[r];
        ++result.compared;
    }
    const auto count = static_cast<double>(result.compared);
    result.relative_rmse = std::sqrt(square_sum / count) / (truth_sum / count);
    result.bias = difference_sum / truth_sum;
    return result;
}

} // namespace

TEST_CASE("slope rows, and depth maps rectified to rows, converge to brute force at first order, for every light and "
          "camera") {
    const Soup soup(make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3));
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 40);
        std::vector<double> truth_m;
        for (const ViewRay& ray : rays)
            truth_m.push_back(marched_lit_length_m(soup.soup, setting.light, ray, 400));
        for (const bool from_map : {false, true}) {
            CAPTURE(from_map);
            const Comparison coarse = compare(setting, soup, rays, truth_m, 128, from_map),
                             fine = compare(setting, soup, rays, truth_m, 1024, from_map);
            CHECK(fine.outside == 0);
            CHECK(fine.near_epipole < rays.size() / 50);
            CHECK(fine.relative_rmse < 0.02);
            CHECK(fine.relative_rmse < 0.35 * coarse.relative_rmse);
        }
    }
}

TEST_CASE("the bits of slope rows do not depend on the number of threads") {
    const Soup soup(make_soup(3000, 3.0f, 0.2f, vec3(0.0f), 5));
    const Setting setting = settings().front();
    const auto rays = make_rays(setting, 40);
    const slope_rows::Rows one = with_threads(1, [&] { return make_rows(setting, soup, rays, 256); });
    const slope_rows::Rows two = with_threads(2, [&] { return make_rows(setting, soup, rays, 256); });
    REQUIRE(one.layout.sample_count == two.layout.sample_count);
    CHECK(std::equal(one.slopes.get(), one.slopes.get() + one.layout.sample_count, two.slopes.get()));
}

// A box is dropped if it lies outside the slices, outside their lines, or below every view ray: its triangles would
// have left no trace, so that the rows are the same bit by bit.
TEST_CASE("boxes of occluders that are skipped would not have changed a sample") {
    const Soup soup(make_soup(4000, 8.0f, 0.2f, vec3(0.0f), 15));
    OccluderMesh everywhere = *soup.occluders.meshes.begin()->second;
    everywhere.bounds = {.min = vec3(-1e4f), .max = vec3(1e4f)};
    for (OccluderBlock& block : everywhere.blocks)
        block.bounds = everywhere.bounds;
    Occluders never_skipped;
    never_skipped.add(&everywhere, &soup.identity);
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const slope_rows::Rows rows = make_rows(setting, soup, make_rays(setting, 40), 300);
        slope_rows::Rows all(rows.layout);
        Progress progress;
        slope_rows::raster(all, never_skipped, progress);
        CHECK(std::equal(rows.slopes.get(), rows.slopes.get() + rows.layout.sample_count, all.slopes.get()));
    }
}

// Dozens of light samples are laid out for a few rays each: none of the others may fall outside of their rows.
TEST_CASE("rows for the outline of a picture's rays cover all of its rays") {
    const Soup soup(make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3));
    Progress progress;
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 150);
        CHECK(outline(setting.view.is_orthographic, rays, progress).size() < rays.size() / 8);
        const slope_rows::Rows rows = make_rows(setting, soup, rays, 300);
        LitRows lit;
        row_query::Uncovered uncovered;
        row_query::lit_intervals(rows, rays, lit, uncovered);
        CHECK(uncovered.outside.empty());
    }
}

TEST_CASE("rays in no order are their own outline") {
    const Setting setting = settings().front();
    auto rays = make_rays(setting, 20);
    SceneRandom random(4);
    for (std::size_t i = rays.size() - 1; i > 0; --i)
        std::swap(rays[i], rays[static_cast<std::size_t>(random.uniform() * static_cast<float>(i))]);
    for (ViewRay& ray : rays)
        ray.far_m = 5.0f;
    Progress progress;
    const auto outer = outline(setting.view.is_orthographic, rays, progress);
    // Chance puts three in a line now and then.
    CHECK(outer.size() > rays.size() / 2);
    for (const RaySpan& span : outer)
        CHECK(span.last.far_m == 5.0f);
}

TEST_CASE("every SIMD target fills the same rows, save for samples at the ends of segments") {
    const Soup soup(make_soup(300, 3.0f, 0.4f, vec3(0.0f), 6));
    for (const Setting& setting : {settings()[0], settings()[3], settings()[6], settings()[8]}) {
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 40);
        const slope_rows::Rows best = make_rows(setting, soup, rays, 512);
        for (const SimdTarget target : available_simd_targets()) {
            CAPTURE(static_cast<int>(target));
            const slope_rows::Rows forced = [&] {
                const ForcedSimdTarget force(target);
                return make_rows(setting, soup, rays, 512);
            }();
            REQUIRE(forced.layout.rows.size() == best.layout.rows.size());
            std::size_t different = 0, compared = 0;
            for (std::size_t s = 0; s < best.layout.rows.size(); ++s) {
                const auto a = best.row(static_cast<std::int32_t>(s)), b = forced.row(static_cast<std::int32_t>(s));
                for (std::int32_t i = std::max(a.first, b.first); i < std::min(a.end, b.end); ++i, ++compared) {
                    const float x = a.slopes[i - a.first], y = b.slopes[i - b.first];
                    different += x != y && !(std::abs(x - y) <= 1e-4f * (1.0f + std::abs(x)));
                }
            }
            // Fused multiply-adds round differently: an end within 1e-6 of a line's centre may fall on its other side.
            CHECK(compared > best.layout.sample_count / 2);
            CHECK(different < compared / 2000);
        }
    }
}

TEST_CASE("blocks of 16 answer as the lines one by one do") {
    SceneRandom random(9);
    constexpr std::int32_t line_count = 1024;
    std::vector<float> slopes(line_count), lowest(line_count / 16 + 16), highest(line_count / 16 + 16);
    for (const float change : {0.001f, 0.02f, 0.5f}) {
        float value = 0.0f;
        for (float& slope : slopes)
            slope = value = random.uniform() < change ? random.uniform(-1.0f, 1.0f) : value;
        for (std::size_t block = 0; block < line_count / 16; ++block) {
            const auto begin = slopes.begin() + static_cast<std::ptrdiff_t>(block) * 16;
            lowest[block] = *std::min_element(begin, begin + 16);
            highest[block] = *std::max_element(begin, begin + 16);
        }
        const slope_rows::RowView row{slopes.data(), lowest.data(), highest.data(), 0, line_count};
        for (int trial = 0; trial < 200; ++trial) {
            const float slope = random.uniform(-1.1f, 1.1f);
            const auto first = static_cast<std::int32_t>(random.uniform(0.0f, 1000.0f));
            const std::int32_t last =
                first + static_cast<std::int32_t>(random.uniform(0.0f, 1023.0f - static_cast<float>(first)));
            std::vector<std::int32_t> expected, borders;
            for (std::int32_t i = first; i <= last; ++i) {
                const bool is_lit = slope >= slopes[static_cast<std::size_t>(i)];
                if (is_lit != (expected.size() % 2 == 1))
                    expected.push_back(i);
            }
            if (expected.size() % 2 == 1)
                expected.push_back(last + 1);
            row_query::lit_runs(row, slope, first, last, borders);
            CHECK(borders == expected);
        }
    }
}
} // namespace slope_rows_test
