// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/simd.hpp"
#include "light_shafts/row_query_scatter.hpp"
#include "support/shaft_settings.hpp"
#include <doctest/doctest.h>

namespace row_query_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// Random pieces that cover a part of each ray; depths per metre around `sigma_per_m`, of either sign.
PieceRows random_pieces(std::span<const ViewRay> rays, float sigma_per_m, bool is_grey) {
    SceneRandom random(21);
    PieceRows rows;
    for (const ViewRay& ray : rays) {
        float near_m = ray.near_m;
        for (int piece = 0; piece < 3; ++piece) {
            const float far_m = near_m + (ray.far_m - near_m) * random.uniform(0.1f, 1.0f);
            ScatterPiece made{.near_m = near_m, .far_m = far_m};
            made.source_per_m = Rgb(random.uniform(), random.uniform(), random.uniform());
            for (int c = 0; c < 3; ++c) {
                made.depth_per_m[c] = sigma_per_m * random.uniform(-0.2f, 1.0f);
                made.depth_at_near[c] = random.uniform(0.0f, 2.0f) + sigma_per_m * near_m;
            }
            if (is_grey) {
                made.depth_per_m = Rgb(made.depth_per_m.x);
                made.depth_at_near = Rgb(made.depth_at_near.x);
            }
            rows.pieces.push_back(made);
            near_m = far_m;
        }
        rows.end_ray();
    }
    return rows;
}

/// The rows' lit intervals with each piece integrated on its own, as Visibility::add_scattered does.
class ByIntervals final : public Visibility {
public:
    explicit ByIntervals(const slope_rows::Rows& rows) : rows_(rows) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override {
        row_query::Uncovered uncovered;
        row_query::lit_intervals(rows_, rays, lit, uncovered);
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    const slope_rows::Rows& rows_;
    Statistics statistics_;
};
} // namespace

// A term of the series carries 3e-7 of the exponential and 1e-6 of a line's number times its depth.
TEST_CASE("the fused sum over lit lines equals the integral over lit intervals") {
    const Soup soup(make_soup(200, 3.0f, 0.5f, vec3(0.0f), 12));
    for (const std::size_t index : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{6}, std::size_t{7}}) {
        const Setting setting = settings()[index];
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 40);
        const slope_rows::Rows rows = make_rows(setting, soup, rays, 700);
        for (const float sigma_per_m : {1e-9f, 0.1f, 3.0f, 30.0f, 1000.0f})
            for (const bool is_grey : {true, false})
                for (const SimdTarget target : available_simd_targets()) {
                    CAPTURE(sigma_per_m);
                    CAPTURE(is_grey);
                    CAPTURE(static_cast<int>(target));
                    const ForcedSimdTarget force(target);
                    const PieceRows pieces = random_pieces(rays, sigma_per_m, is_grey);
                    std::vector<Rgb> fused(rays.size(), Rgb(0.0f)), expected(rays.size(), Rgb(0.0f));
                    std::vector<float> fused_m(rays.size(), 0.0f), expected_m(rays.size(), 0.0f);
                    row_query::Unanswered unanswered;
                    row_query::add_scattered(rows, rays, pieces, fused, fused_m, unanswered);
                    ByIntervals(rows).add_scattered(rays, pieces, expected, expected_m);
                    std::vector<bool> is_skipped(rays.size());
                    for (const std::uint32_t ray : unanswered.steep)
                        is_skipped[ray] = true;
                    CHECK((sigma_per_m > 10.0f || unanswered.steep.empty()));
                    CHECK(unanswered.outside.empty());
                    double worst = 0.0, worst_length = 0.0;
                    for (std::size_t r = 0; r < rays.size(); ++r) {
                        if (is_skipped[r])
                            continue;
                        const double scale = double{glm::length(expected[r])} + 1e-12;
                        worst = std::max(worst, double{glm::length(fused[r] - expected[r])} / scale);
                        worst_length = std::max(worst_length, double{std::abs(fused_m[r] - expected_m[r])});
                    }
                    CHECK(worst < 2e-4);
                    CHECK(worst_length < 1e-4);
                }
    }
}

// Both paths sum the same terms: one ray in a call is asked with lines side by side, many with rays side by side. Gains
// per line from thin (parabolas) over dense (tables) to those that only the first path takes.
TEST_CASE("a ray scatters the same light alone and among its neighbours") {
    const Soup soup(make_soup(200, 3.0f, 0.5f, vec3(0.0f), 12));
    const Setting setting = settings()[0];
    const auto rays = make_rays(setting, 80);
    const slope_rows::Rows rows = make_rows(setting, soup, rays, 700);
    const auto order = row_query::by_wedge(rows.layout, rays, Progress{});
    std::vector<ViewRay> sorted;
    for (const std::uint32_t ray : order)
        sorted.push_back(rays[ray]);
    for (const float sigma_per_m : {0.01f, 0.1f, 2.0f, 20.0f})
        for (const bool is_grey : {true, false})
            for (const SimdTarget target : available_simd_targets()) {
                CAPTURE(sigma_per_m);
                CAPTURE(is_grey);
                CAPTURE(static_cast<int>(target));
                const ForcedSimdTarget force(target);
                const PieceRows pieces = random_pieces(sorted, sigma_per_m, is_grey);
                std::vector<Rgb> together(sorted.size(), Rgb(0.0f));
                row_query::Unanswered unanswered, alone_unanswered;
                row_query::add_scattered(rows, sorted, pieces, together, {}, unanswered);
                double worst = 0.0, mean = 0.0;
                for (std::size_t r = 0; r < sorted.size(); ++r) {
                    PieceRows own;
                    own.pieces.assign(pieces.pieces.begin() + pieces.first[r],
                                      pieces.pieces.begin() + pieces.first[r + 1]);
                    own.end_ray();
                    Rgb alone(0.0f);
                    row_query::add_scattered(rows, std::span(sorted).subspan(r, 1), own, std::span(&alone, 1), {},
                                             alone_unanswered);
                    worst = std::max(worst,
                                     double{glm::length(together[r] - alone)} / (double{glm::length(alone)} + 1e-12));
                    mean += double{glm::length(alone)};
                }
                CHECK(mean > 0.0);
                CHECK(worst < 2e-5); // 16 roundings of a power, and 3e-7 of each exponential
                CHECK(unanswered.steep.size() == alone_unanswered.steep.size());
            }
}

// Seen to fail where the lanes behind the last piece, which hold what an earlier call left there, had a say.
TEST_CASE("what was asked before changes no bit of an answer") {
    const Soup soup(make_soup(200, 3.0f, 0.5f, vec3(0.0f), 12));
    const Setting setting = settings()[0];
    const auto rays = make_rays(setting, 40);
    const slope_rows::Rows rows = make_rows(setting, soup, rays, 700);
    const PieceRows grey = random_pieces(rays, 0.1f, true), coloured = random_pieces(rays, 0.1f, false);
    for (const SimdTarget target : available_simd_targets()) {
        CAPTURE(static_cast<int>(target));
        const ForcedSimdTarget force(target);
        const auto ask = [&](std::size_t count, const PieceRows& pieces) {
            PieceRows own;
            own.first.assign(pieces.first.begin(), pieces.first.begin() + static_cast<std::ptrdiff_t>(count) + 1);
            own.pieces.assign(pieces.pieces.begin(), pieces.pieces.begin() + pieces.first[count]);
            std::vector<Rgb> radiance(count, Rgb(0.0f));
            row_query::Unanswered unanswered;
            row_query::add_scattered(rows, std::span(rays).first(count), own, radiance, {}, unanswered);
            return radiance;
        };
        for (std::size_t count = 1; count < 40; ++count) {
            static_cast<void>(ask(rays.size(), grey));
            const std::vector<Rgb> after_grey = ask(count, grey);
            static_cast<void>(ask(rays.size(), coloured));
            CHECK(ask(count, grey) == after_grey);
        }
    }
}
} // namespace row_query_test
