// SPDX-License-Identifier: GPL-3.0-or-later
// What squares of pixels tell the pixels between them, against one pixel after the other.
#include "core/simd.hpp"
#include "render/carry_over_kernel.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <random>

namespace carry_over_test {
using namespace tyndall;
using light_shafts::dark_air;
using light_shafts::ViewRay;

namespace {
constexpr float endless_m = std::numeric_limits<float>::infinity();
constexpr std::uint32_t first_square = 3, end_square = 14;
constexpr float share_y = 0.375f;

/// Two lines of squares and a line of pixels among them: walls, sky, and some that know nothing.
struct Line {
    std::vector<ViewRay> pixels;
    std::vector<float> lower_far_m, upper_far_m, of_lower, of_upper;
    std::vector<Rgb> radiance;

    std::uint32_t side;

    Line(std::size_t pixel_count, std::uint32_t side_px) : side(side_px) {
        std::mt19937 random(8);
        const auto far_m = [&] {
            constexpr std::array ends_m{3.0f, 3.1f, 3.25f, 8.0f, endless_m};
            return ends_m[random() % ends_m.size()];
        };
        const auto value = [&] {
            return random() % 5 == 0 ? dark_air : 0.5f + static_cast<float>(random() % 100) / 99;
        };
        for (std::uint32_t square = first_square; square < end_square; ++square) {
            lower_far_m.push_back(far_m());
            upper_far_m.push_back(far_m());
            of_lower.push_back(value());
            of_upper.push_back(value());
        }
        for (std::vector<float>* const values : {&lower_far_m, &upper_far_m, &of_lower, &of_upper})
            values->resize(values->size() + render::PixelsBetweenSquares::padding, 5.0f);
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel) {
            pixels.push_back({vec3(0), vec3(0, 0, -1), 0.0f, far_m()});
            radiance.push_back(random() % 6 == 0 ? Rgb(0.0f) : Rgb(0.0f, 0.2f, 0.0f));
        }
    }
    [[nodiscard]] render::PixelsBetweenSquares between(std::uint32_t x) const {
        return {.x = x,
                .side = side,
                .first_square = first_square,
                .end_square = end_square,
                .lower_far_m = lower_far_m.data(),
                .upper_far_m = upper_far_m.data(),
                .lower_heterogeneity = of_lower.data(),
                .upper_heterogeneity = of_upper.data(),
                .share_y = share_y};
    }
    [[nodiscard]] float one(std::uint32_t x, float far_m) const {
        const float at =
            std::clamp((static_cast<float>(x) - static_cast<float>(side / 2)) * (1.0f / static_cast<float>(side)),
                       static_cast<float>(first_square), static_cast<float>(end_square - 1));
        const auto before = static_cast<std::uint32_t>(at);
        const float share_x = at - static_cast<float>(before);
        float sum = 0.0f, weight_sum = 0.0f;
        for (int corner = 0; corner < 4; ++corner) {
            const bool is_right = corner % 2 == 1, is_upper = corner / 2 == 1;
            const float near = (is_right ? share_x : 1.0f - share_x) * (is_upper ? share_y : 1.0f - share_y);
            if (near == 0.0f)
                continue;
            const std::size_t square = before - first_square + (is_right ? 1 : 0);
            const float other_m = (is_upper ? upper_far_m : lower_far_m)[square],
                        value = (is_upper ? of_upper : of_lower)[square];
            const float weight = near * render::agreement(far_m, other_m);
            if (value == dark_air || std::isnan(weight) || weight <= 0.0f)
                continue;
            sum += weight * value;
            weight_sum += weight;
        }
        return weight_sum > render::least_neighbour_weight ? sum / weight_sum : dark_air;
    }
};
} // namespace

TEST_CASE(
    "a vector of pixels finds the bits of one after the other, on every instruction set, however many there are") {
    for (const std::size_t count : {1u, 3u, 16u, 47u, 60u})
        for (const auto& [x, side] : {std::pair{0u, 4u}, {9u, 4u}, {14u, 4u}, {3u, 2u}, {8u, 2u}, {5u, 3u}}) {
            const Line line(count, side);
            for (const SimdTarget target : available_simd_targets())
                for (const bool fills_dark : {false, true}) {
                    const ForcedSimdTarget forced(target);
                    CAPTURE(simd_target_name());
                    std::vector<float> found(count + 1, 7.0f);
                    const std::size_t dark_count = render::carry_over(line.between(x), line.pixels, line.radiance,
                                                                      fills_dark, std::span(found).first(count));
                    std::size_t expected_dark = 0;
                    for (std::size_t pixel = 0; pixel < count; ++pixel) {
                        const bool is_one = !fills_dark && line.radiance[pixel] == Rgb(0.0f);
                        const float expected =
                            is_one ? 1.0f : line.one(x + static_cast<std::uint32_t>(pixel), line.pixels[pixel].far_m);
                        REQUIRE(found[pixel] == expected);
                        expected_dark += expected == dark_air ? 1 : 0;
                    }
                    CHECK(dark_count == expected_dark);
                    CHECK(found.back() == 7.0f); // not its own
                }
        }
}
} // namespace carry_over_test
