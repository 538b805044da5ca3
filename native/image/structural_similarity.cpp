// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/structural_similarity.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "image/srgb.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall {
static constexpr std::size_t window = 11, reach = window / 2;
static constexpr double sigma_px = 1.5;

GreyPicture luma_of(std::span<const float> linear, std::size_t channel_count, std::size_t width_px) {
    require(channel_count >= 3 && width_px > 0 && linear.size() % (channel_count * width_px) == 0,
            "luma: ", linear.size(), " numbers are no rows of ", width_px, " pixels of ", channel_count, " channels");
    GreyPicture picture{.width_px = width_px, .height_px = linear.size() / channel_count / width_px, .values = {}};
    for (std::size_t pixel = 0; pixel < linear.size(); pixel += channel_count) {
        const auto byte = [&](std::size_t channel) {
            const float encoded = srgb_from_linear(std::clamp(linear[pixel + channel], 0.0f, 1.0f));
            return std::round(255.0f * encoded);
        };
        picture.values.push_back(0.299f * byte(0) + 0.587f * byte(1) + 0.114f * byte(2));
    }
    return picture;
}

namespace {
std::array<double, window> gaussian() {
    std::array<double, window> weights{};
    double sum = 0.0;
    for (std::size_t i = 0; i < window; ++i) {
        const double x = static_cast<double>(i) - static_cast<double>(reach);
        sum += weights[i] = std::exp(-0.5 * x * x / (sigma_px * sigma_px));
    }
    for (double& weight : weights)
        weight /= sum;
    return weights;
}

/// Weighted means over a window, of what the index is made of.
struct Means {
    double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    void add(double weight, const Means& other) {
        a += weight * other.a, b += weight * other.b;
        aa += weight * other.aa, bb += weight * other.bb, ab += weight * other.ab;
    }
};
/// Eq. 13.
double index_of(const Means& means, double c1, double c2) {
    const double product = means.a * means.b, squares = means.a * means.a + means.b * means.b;
    const double covariance = means.ab - product, variances = means.aa + means.bb - squares;
    return (2.0 * product + c1) * (2.0 * covariance + c2) / ((squares + c1) * (variances + c2));
}
} // namespace

double structural_similarity(const GreyPicture& a, const GreyPicture& b, const Progress& progress, double range) {
    require(a.width_px == b.width_px && a.height_px == b.height_px, "similarity: a picture of ", a.width_px, " x ",
            a.height_px, " pixels and one of ", b.width_px, " x ", b.height_px);
    require(a.width_px >= window && a.height_px >= window, "similarity: pictures of ", a.width_px, " x ", a.height_px,
            " pixels; 11 x 11 are a window");
    require(std::isfinite(range) && range > 0.0, "similarity: a range of ", range);
    const std::array<double, window> weights = gaussian();
    const double c1 = 0.01 * 0.01 * range * range, c2 = 0.03 * 0.03 * range * range;
    const std::size_t width = a.width_px, columns = width - 2 * reach, rows = a.height_px - 2 * reach;
    std::vector<double> of_rows(rows); // summed up in their order: the same bits for any number of threads
    parallel_for(
        rows, progress,
        [&](std::size_t row) {
            std::vector<Means> down(width); // windows' columns
            for (std::size_t i = 0; i < window; ++i)
                for (std::size_t x = 0; x < width; ++x) {
                    const double at_a = static_cast<double>(a.values[(row + i) * width + x]);
                    const double at_b = static_cast<double>(b.values[(row + i) * width + x]);
                    down[x].add(weights[i], {at_a, at_b, at_a * at_a, at_b * at_b, at_a * at_b});
                }
            for (std::size_t x = 0; x < columns; ++x) {
                Means means;
                for (std::size_t i = 0; i < window; ++i)
                    means.add(weights[i], down[x + i]);
                of_rows[row] += index_of(means, c1, c2);
            }
        },
        8);
    double sum = 0.0;
    for (const double of_row : of_rows)
        sum += of_row;
    return sum / static_cast<double>(rows * columns);
}
} // namespace tyndall
