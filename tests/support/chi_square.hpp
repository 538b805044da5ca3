// SPDX-License-Identifier: GPL-3.0-or-later
// Pearson's chi-square test of samples against the counts that a PDF promises, for every sampler of the project.
// A sampler is drawn from with fixed seeds, so a test that passes keeps passing; the significance says how likely a
// right sampler would have been refused when the seed was first chosen.
#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace tyndall::support {
/// Q(a, x), the regularised upper incomplete gamma function: series below a + 1, Lentz's continued fraction above.
inline double upper_gamma(double a, double x) {
    if (x <= 0.0)
        return 1.0;
    const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (int n = 1; n < 10000 && term > sum * 1e-16; ++n)
            sum += term *= x / (a + n);
        return 1.0 - sum * scale;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, fraction = d;
    for (int n = 1; n < 10000; ++n) {
        const double numerator = -n * (n - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= d * c;
        if (std::abs(d * c - 1.0) < 1e-16)
            break;
    }
    return fraction * scale;
}

/// Probability that samples of exactly the expected distribution stray as far as `observed` does, or farther. Cells that
/// expect fewer than 5 are pooled; a sample in a cell that expects none gives 0.
inline double chi_square_p_value(std::span<const double> observed, std::span<const double> expected) {
    std::vector<std::size_t> order(expected.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return expected[a] < expected[b]; });
    double statistic = 0.0, pooled_expected = 0.0, pooled_observed = 0.0;
    int cell_count = 0;
    const auto add = [&](double seen, double promised) {
        statistic += (seen - promised) * (seen - promised) / promised;
        ++cell_count;
    };
    for (const std::size_t cell : order) {
        if (expected[cell] <= 0.0 && observed[cell] > 0.0)
            return 0.0;
        pooled_expected += expected[cell];
        pooled_observed += observed[cell];
        if (pooled_expected < 5.0)
            continue;
        add(pooled_observed, pooled_expected);
        pooled_expected = pooled_observed = 0.0;
    }
    if (pooled_expected > 0.0)
        add(pooled_observed, pooled_expected);
    return cell_count < 2 ? 1.0 : upper_gamma(0.5 * (cell_count - 1), 0.5 * statistic);
}

/// Sidak's correction: of test_count tests of right samplers, none is refused with probability 1 - significance.
inline bool is_plausible(double p_value, int test_count, double significance = 0.01) {
    return p_value > 1.0 - std::pow(1.0 - significance, 1.0 / test_count);
}
} // namespace tyndall::support
