// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/close_to.hpp"
#include "volume/phase_function.hpp"
#include <doctest/doctest.h>

namespace phase_function_test {
using namespace tyndall;
using tyndall::support::close_to;

/// Integral over the sphere of weight(cosine) * phase. The angle is split at 30 degrees from the peak, where its
/// fourth root flattens what a lobe of g = 0.999 does within a tenth of a degree.
template <typename Weight>
static double over_sphere(float g, const Weight& weight, float alpha = 0.0f) {
    constexpr int steps = 200000;
    double sum = 0.0;
    for (int step = 0; step < steps; ++step) {
        const double s = (step + 0.5) / steps, angle = std::numbers::pi * s * s * s * s;
        const double cosine = std::copysign(1.0, g) * std::cos(angle);
        sum += weight(cosine) * draine_per_sr(static_cast<float>(cosine), g, alpha) * std::sin(angle) *
               (4.0 * std::numbers::pi * s * s * s / steps);
    }
    return 2.0 * std::numbers::pi * sum;
}

TEST_CASE("the phase function scatters all of the light, and g is its mean cosine") {
    for (const float g : {-0.99f, -0.7f, -1e-4f, 0.0f, 0.3f, 0.85f, 0.95f, 0.99f}) {
        CAPTURE(g);
        // A float cosine next to 1 is off by 3e-8, the denominator of a narrow lobe by that over (1 - g)^2.
        const double bound = 1e-5 + 1e-7 / ((1.0 - std::abs(g)) * (1.0 - std::abs(g)));
        CHECK(std::abs(over_sphere(g, [](double) { return 1.0; }) - 1.0) < bound);
        CHECK(std::abs(over_sphere(g, [](double cosine) { return cosine; }) - double{g}) < bound);
    }
}
TEST_CASE("Draine's function scatters all of the light, with the mean cosine of its closed form") {
    for (const float g : {-0.7f, 0.0f, 0.3f, 0.95f})
        for (const float alpha : {0.5f, 1.0f, 20.0f, 250.0f}) {
            CAPTURE(g);
            CAPTURE(alpha);
            CHECK(std::abs(over_sphere(
                               g, [](double) { return 1.0; }, alpha) -
                           1.0) < 1e-4);
            // Draine 2003, eq. 6
            const double g2 = double{g} * g;
            const double mean = g * (1.0 + alpha * (3.0 + 2.0 * g2) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g2) / 3.0);
            CHECK(std::abs(over_sphere(
                               g, [](double cosine) { return cosine; }, alpha) -
                           mean) < 1e-4);
        }
    for (const float cosine : {-1.0f, -0.3f, 0.0f, 0.8f}) // Rayleigh's
        CHECK(draine_per_sr(cosine, 0.0f, 1.0f) ==
              close_to(3.0 / (16.0 * std::numbers::pi) * (1.0 + double{cosine} * cosine), 1e-5));
}
TEST_CASE("light that goes straight on in a narrow lobe keeps its precision") {
    // With the printed denominator, 1 + g^2 - 2 g, float32 is 10 % off here.
    const float g = 0.999f;
    const double exact = (1.0 + double{g}) / (4.0 * std::numbers::pi * (1.0 - double{g}) * (1.0 - double{g}));
    CHECK(std::abs(henyey_greenstein_per_sr(1.0f, g) / exact - 1.0) < 1e-6);
}
} // namespace phase_function_test
