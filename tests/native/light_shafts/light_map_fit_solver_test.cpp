// SPDX-License-Identifier: GPL-3.0-or-later
// The light map fit's solver finds the map where strokes determine it, leaves alone what they do not see, never makes things
// worse, and can be stopped and continued.
#include "core/parallel.hpp"
#include "support/light_map_fits.hpp"
#include <doctest/doctest.h>

namespace light_map_fit_solver_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

TEST_CASE("light map fit: strokes that show a map's shafts from all sides give the map back") {
    // 12 texels a side, 4 cameras of 2,500 rays each: far more equations than unknowns.
    std::vector<Strokes> strokes;
    for (const vec3& position : {vec3(20, -9, 3), vec3(-14, 16, 9), vec3(2, -21, -4), vec3(-19, -3, 6)})
        strokes.push_back(strokes_from(position, 50));
    const Fitted made = begin_fit(grey_fog, strokes, config_of(16));
    const LightMapMatrix& t = made.fit->matrix();
    const Progress progress;
    const std::vector<vec4> known = random_colours(t.texel_count(), 9);
    const std::vector<vec4> target = product(t, known);
    LightMapSolver solver(t, target, std::vector<float>(target.size(), 1.0f), MapTexels(known.size(), vec4(1.0f)),
                          MapTexels(known.size(), vec4(1.0f)), 1e-9f);
    for (int step = 0; step < 400 && solver.step(); ++step) {
    }
    std::vector<vec4> seen(known.size(), vec4(0.0f)), squares(known.size());
    t.square_columns(std::vector<vec4>(target.size(), vec4(1.0f)), squares, progress);
    float most = 0.0f;
    for (const vec4& square : squares)
        most = std::max(most, square.x);
    double worst = 0.0;
    std::size_t determined_count = 0;
    for (std::size_t texel = 0; texel < known.size(); ++texel)
        if (squares[texel].x > 0.05f * most) { // those at the fog's corners are hardly seen
            ++determined_count;
            worst = std::max(worst, glm::length(glm::dvec3(vec3(solver.texels()[texel] - known[texel]))));
        }
    CHECK(determined_count > 60);
    CHECK(worst < 5e-3);
    CHECK(solver.history().back().residual < 1e-4);
}

TEST_CASE("light map fit: no step makes any channel's objective worse, nor a texel negative") {
    std::array strokes{strokes_from({20, -9, 3}, 40, {0.0f, 0.2f, 2.0f}),
                       strokes_from({-14, 16, 9}, 40, {1.5f, 0.0f, 0.1f})};
    for (const float regularisation : {0.0f, 1e-6f, 1e-3f, 1.0f}) {
        const Fitted made = begin_fit(grey_fog, strokes, config_of(64, regularisation));
        Progress progress;
        made.fit->iterate(60, progress);
        const std::span<const FitStep> history = made.fit->history();
        REQUIRE(history.size() > 10);
        for (std::size_t step = 1; step < history.size(); ++step)
            for (std::size_t channel = 0; channel < 3; ++channel)
                CHECK(history[step].objective[channel] <= history[step - 1].objective[channel]);
        std::size_t black_count = 0;
        for (const Rgb& texel : made.fit->map().texels) {
            CHECK(glm::all(glm::greaterThanEqual(texel, Rgb(0.0f))));
            black_count += texel.x == 0.0f;
        }
        CHECK(black_count > (regularisation < 1.0f ? 50u : 0u)); // some are held at 0: there is something to test
        CHECK(history.back().residual < 0.9 * history.front().residual);
    }
}

TEST_CASE("light map fit: what no stroke sees stays as it was, and a heavy prior keeps the rest, too") {
    Progress progress;
    const std::array one_corner{strokes_from({20, -9, 3}, 6, {4.0f, 0.0f, 0.0f})};
    LightMap current{.place = begin_fit(grey_fog, one_corner, config_of(64)).fit->map().place, .texels = {}};
    for (const vec4& texel : random_colours(64 * 64, 7))
        current.texels.emplace_back(texel);
    const Fitted made = begin_fit(grey_fog, one_corner, config_of(64, 1e-4f), current);
    made.fit->iterate(20, progress);
    const LightMap map = made.fit->map();
    REQUIRE(map.place == current.place); // it covers what is seen: it does not swim
    std::vector<vec4> seen(made.fit->matrix().texel_count());
    made.fit->matrix().multiply_transposed(std::vector<vec4>(made.fit->matrix().ray_count(), vec4(1.0f)), seen,
                                           progress);
    std::size_t unseen_count = 0, changed_count = 0;
    for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
        if (seen[texel / 64 * made.fit->matrix().pitch() + texel % 64] == vec4(0.0f)) {
            ++unseen_count;
            CHECK(map.texels[texel] == current.texels[texel]);
        } else
            changed_count += map.texels[texel] != current.texels[texel];
    CHECK(unseen_count > 500);
    CHECK(changed_count > 100);
    const Fitted held = begin_fit(grey_fog, one_corner, config_of(64, 1e6f), current);
    held.fit->iterate(20, progress);
    CHECK(relative_rms(padded(held.fit->map()), padded(current)) < 1e-4);
}

TEST_CASE("light map fit: steps taken in two calls are the steps of one") {
    Progress progress;
    const Fitted once = begin_fit(grey_fog, red_and_blue, config_of(48)),
                 twice = begin_fit(grey_fog, red_and_blue, config_of(48));
    once.fit->iterate(24, progress);
    twice.fit->iterate(8, progress);
    twice.fit->iterate(16, progress);
    CHECK(once.fit->map().texels == twice.fit->map().texels);
}

TEST_CASE("light map fit: a cancelled call leaves the map of its last whole step") {
    const Fitted made = begin_fit(grey_fog, red_and_blue, config_of(48));
    Progress progress, cancelled;
    made.fit->iterate(5, progress);
    const std::vector<Rgb> before = made.fit->map().texels;
    cancelled.cancel();
    CHECK_THROWS_AS(made.fit->iterate(5, cancelled), Cancelled);
    CHECK(made.fit->map().texels == before);
    CHECK(made.fit->history().size() == 6);
    CHECK(made.fit->iterate(5, progress));
    CHECK(made.fit->history().size() == 11);
}

TEST_CASE("light map fit: its bits do not depend on the number of threads, nor its map on the order of the strokes") {
    const auto fitted = [](std::span<const Strokes> strokes, int thread_count) {
        return with_threads(thread_count, [&] {
            Progress progress;
            const Fitted made = begin_fit(grey_fog, strokes, config_of(48, 1e-2f));
            made.fit->iterate(40, progress);
            return padded(made.fit->map());
        });
    };
    const std::vector<vec4> one = fitted(red_and_blue, 1), two = fitted(red_and_blue, 2);
    CHECK(one == two);
    std::array turned{red_and_blue[1], red_and_blue[0]};
    for (Strokes& view : turned)
        std::ranges::reverse(view.pixels);
    // Sums in another order: after 40 steps towards the same minimum.
    CHECK(relative_rms(fitted(turned, 2), one) < 1e-3);
}

TEST_CASE("light map fit: a channel's map depends on what was painted in that channel alone") {
    Progress progress;
    std::array other(red_and_blue);
    for (Strokes& view : other)
        for (StrokePixel& pixel : view.pixels)
            pixel.desired.x = 0.7f;
    const Fitted a = begin_fit(grey_fog, red_and_blue, config_of(48)), b = begin_fit(grey_fog, other, config_of(48));
    a.fit->iterate(20, progress);
    b.fit->iterate(20, progress);
    std::size_t red_differs = 0;
    for (std::size_t texel = 0; texel < a.fit->map().texels.size(); ++texel) {
        const Rgb of_a = a.fit->map().texels[texel], of_b = b.fit->map().texels[texel];
        red_differs += of_a.x != of_b.x;
        CHECK(std::abs(of_a.y - of_b.y) <= 1e-5f);
        CHECK(std::abs(of_a.z - of_b.z) <= 1e-5f);
    }
    CHECK(red_differs > 100);
}

TEST_CASE("light map fit: a heavier stroke gets closer to its colour") {
    Progress progress;
    const auto error_of_first = [&](float weight) { // where two strokes over the same pixels contradict each other
        std::array strokes{strokes_from({20, -9, 3}, 24, Rgb(2.0f)), strokes_from({20, -9, 3}, 24, Rgb(0.5f))};
        for (StrokePixel& pixel : strokes[0].pixels)
            pixel.weight = weight;
        const Fitted made = begin_fit(grey_fog, strokes, config_of(32, 1e-6f));
        made.fit->iterate(60, progress);
        const LightMapMatrix& t = made.fit->matrix();
        const std::vector<vec4> found = product(t, padded(made.fit->map())),
                                white = product(t, MapTexels(t.texel_count(), vec4(1.0f)));
        double sum = 0.0, whole = 0.0;
        for (std::size_t ray = 0; ray < t.ray_count(); ++ray)
            if (made.fit->pixel_of_ray()[ray] < t.ray_count() / 2) {
                sum += found[ray].x;
                whole += white[ray].x;
            }
        return sum / whole;
    };
    // Least squares of two contradicting equations is their weighted mean.
    CHECK(std::abs(error_of_first(1.0f) - 1.25) < 0.02);
    CHECK(std::abs(error_of_first(3.0f) - 1.625) < 0.02);
}

TEST_CASE("light map fit: where it ends, no texel could do better: it is at rest, or at 0 and would go below") {
    const std::array strokes{strokes_from({20, -9, 3}, 32, {2.0f, 0.1f, 0.0f})};
    const Fitted made = begin_fit(grey_fog, strokes, config_of(48));
    const LightMapMatrix& t = made.fit->matrix();
    const Progress progress;
    std::vector<vec4> target = t.white(), diagonal(t.texel_count());
    for (vec4& radiance : target)
        radiance *= vec4(2.0f, 0.1f, 0.0f, 0.0f);
    constexpr float regularisation = 0.1f;
    const MapTexels prior = random_colours(t.texel_count(), 12);
    LightMapSolver solver(t, target, std::vector<float>(target.size(), 1.0f), prior, prior, regularisation);
    for (int step = 0; step < 500 && solver.step(); ++step) {
    }
    t.square_columns(std::vector<vec4>(target.size(), vec4(1.0f)), diagonal, progress);
    double trace = 0.0;
    for (const vec4& texel : diagonal)
        trace += texel.x;
    const double lambda = regularisation * trace / static_cast<double>(solver.seen_texel_count());
    const std::vector<vec4> found = product(t, solver.texels());
    std::vector<vec4> missing(target.size()), pull(t.texel_count());
    for (std::size_t ray = 0; ray < target.size(); ++ray)
        missing[ray] = target[ray] - found[ray];
    t.multiply_transposed(missing, pull, progress);
    double worst = 0.0;
    std::size_t held_count = 0;
    for (std::size_t texel = 0; texel < diagonal.size(); ++texel)
        for (int channel = 0; channel < 3 && diagonal[texel].x > 0.0f; ++channel) {
            const double x = solver.texels()[texel][channel], own = lambda * (x - prior[texel][channel]);
            const double force = pull[texel][channel] - own;
            held_count += x == 0.0;
            worst = std::max(worst, (x > 0.0 ? std::abs(force) : std::max(force, 0.0)) / lambda);
        }
    CHECK(worst < 2e-3); // of a texel's range: float32 sums of a thousand rays
    CHECK(held_count > 20);
}
} // namespace light_map_fit_solver_test
