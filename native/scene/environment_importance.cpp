// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment_importance.hpp"
#include "scene/world.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
static constexpr float uniform_share = 0.01f;
/// By how much wider cells may raise the second moment of what directions find: their noise, where nothing shadows.
static constexpr double most_loss = 0.01;

/// Rec. 709 luminance of the magnitudes: a channel below 0 matters, too.
static float importance_of(const Rgb& radiance) { return glm::dot(glm::abs(radiance), Rgb(0.2126f, 0.7152f, 0.0722f)); }

/// Height of the lower edge of a row on the unit sphere, [-1, 1].
static double edge_height(std::uint32_t row, std::uint32_t rows) {
    return std::sin((static_cast<double>(row) / rows - 0.5) * std::numbers::pi);
}
static float row_height(std::size_t row, std::uint32_t rows) {
    return static_cast<float>(edge_height(static_cast<std::uint32_t>(row + 1), rows) -
                              edge_height(static_cast<std::uint32_t>(row), rows));
}

/// The integral of the bilinear image over each texel's square (1/8, 3/4, 1/8 along each axis), times its solid angle.
static std::vector<float> weights_of(const EnvironmentImage& image) {
    const std::size_t width = image.width, height = image.height;
    std::vector<float> along_rows(width * height), weights(width * height);
    for (std::size_t row = 0; row < height; ++row)
        for (std::size_t column = 0; column < width; ++column) {
            const Rgb* pixels = &image.pixels[row * width];
            along_rows[row * width + column] = 0.125f * importance_of(pixels[(column + width - 1) % width]) +
                                               0.75f * importance_of(pixels[column]) +
                                               0.125f * importance_of(pixels[(column + 1) % width]);
        }
    double total = 0.0;
    for (std::size_t row = 0; row < height; ++row) {
        const float solid_angle = row_height(row, image.height);
        const float* below = &along_rows[(row + height - 1) % height * width];
        const float* here = &along_rows[row * width];
        const float* above = &along_rows[(row + 1) % height * width];
        for (std::size_t column = 0; column < width; ++column) {
            const float mean = 0.125f * below[column] + 0.75f * here[column] + 0.125f * above[column];
            weights[row * width + column] = mean * solid_angle;
            total += weights[row * width + column];
        }
    }
    // total / (2 width) is the weight that a uniform image of the same sum has per unit of height.
    const auto uniform = static_cast<float>(uniform_share * total / (2.0 * static_cast<double>(width)));
    for (std::size_t row = 0; row < height; ++row) {
        const float solid_angle = row_height(row, image.height);
        for (std::size_t column = 0; column < width; ++column) {
            float& weight = weights[row * width + column];
            weight = (1.0f - uniform_share) * weight + uniform * solid_angle;
        }
    }
    return weights;
}

namespace {
/// Weights of texels and of squares of them.
struct Cells {
    std::uint32_t columns, rows;
    std::vector<float> weights;
};
} // namespace

/// Four cells in one.
static Cells halved(const Cells& cells) {
    Cells half{.columns = cells.columns / 2, .rows = cells.rows / 2, .weights = {}};
    half.weights.resize(std::size_t{half.columns} * half.rows);
    for (std::uint32_t row = 0; row < half.rows; ++row)
        for (std::uint32_t column = 0; column < half.columns; ++column) {
            const float* lower = &cells.weights[std::size_t{2} * row * cells.columns + std::size_t{2} * column];
            const float* upper = lower + cells.columns;
            half.weights[std::size_t{row} * half.columns + column] = lower[0] + lower[1] + upper[0] + upper[1];
        }
    return half;
}

/// Second moment of a texel's radiance over the PDF of its cell, less that over its own PDF, which is 1.
static double loss_of(const Cells& cells, const Cells& texels) {
    const std::uint32_t side = texels.rows / cells.rows;
    double moment = 0.0, total = 0.0;
    for (std::uint32_t row = 0; row < texels.rows; ++row) {
        const double share = edge_height(row + 1, texels.rows) - edge_height(row, texels.rows);
        const double of_cell = edge_height(row / side + 1, cells.rows) - edge_height(row / side, cells.rows);
        const double area = share / (of_cell * side);
        for (std::uint32_t column = 0; column < texels.columns; ++column) {
            const double weight = texels.weights[std::size_t{row} * texels.columns + column];
            const double cell = cells.weights[std::size_t{row / side} * cells.columns + column / side];
            total += weight;
            if (weight > 0.0)
                moment += weight * weight / (cell * area);
        }
    }
    return total > 0.0 ? moment / total - 1.0 : 0.0;
}

/// The widest cells that lose little.
static Cells cells_of(const EnvironmentImage& image) {
    const Cells texels{.columns = image.width, .rows = image.height, .weights = weights_of(image)};
    Cells found = texels;
    while (found.columns % 2 == 0 && found.rows % 2 == 0) {
        Cells wider = halved(found);
        if (!(loss_of(wider, texels) <= most_loss))
            break;
        found = std::move(wider);
    }
    return found;
}

EnvironmentImportance::EnvironmentImportance(const EnvironmentImage& image) {
    const Cells cells = cells_of(image);
    columns_ = cells.columns;
    rows_ = cells.rows;
    cells_ = PiecewiseConstant2d(cells.weights, columns_);
    for (std::uint32_t row = 0; row <= rows_; ++row)
        edge_heights_.push_back(edge_height(row, rows_));
    for (std::uint32_t row = 0; row < rows_; ++row)
        per_sr_.push_back(
            static_cast<float>(columns_ / (2.0 * std::numbers::pi) / (edge_heights_[row + 1] - edge_heights_[row])));
}

EnvironmentImportance::Sample EnvironmentImportance::sample(vec2 u) const {
    const auto [column, row, offset] = cells_.sample(u);
    const double low = edge_heights_[row], high = edge_heights_[row + 1];
    const double height = low + static_cast<double>(offset.y) * (high - low);
    const auto radius = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - height * height)));
    return {.uv = {(static_cast<float>(column) + offset.x) / static_cast<float>(columns_),
                   angle_of(static_cast<float>(height), radius) * std::numbers::inv_pi_v<float> + 0.5f},
            .height = height,
            .pdf_per_sr = cells_.probability(column, row) * per_sr_[row]};
}

float EnvironmentImportance::pdf_per_sr(vec2 uv) const {
    const auto cell = [](float share, std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>(std::max(share, 0.0f) * static_cast<float>(count)), count - 1u);
    };
    const std::uint32_t column = cell(uv.x, columns_), row = cell(uv.y, rows_);
    return cells_.probability(column, row) * per_sr_[row];
}

/// The polynomial is that of Moshier's Cephes, between -tan(pi / 8) and tan(pi / 8).
float angle_of(float y, float x) {
    const float along = std::abs(x), across = std::abs(y), more = std::max(along, across);
    if (!(more > 0.0f))
        return 0.0f;
    const float less = std::min(along, across);
    const bool is_steep = less > 0.41421356f * more;
    const float t = is_steep ? (less - more) / (less + more) : less / more, t2 = t * t;
    float angle =
        (((8.05374449538e-2f * t2 - 1.38776856032e-1f) * t2 + 1.99777106478e-1f) * t2 - 3.33329491539e-1f) * t2 * t + t;
    angle = is_steep ? angle + 0.25f * pi : angle;
    angle = across > along ? 0.5f * pi - angle : angle;
    angle = x < 0.0f ? pi - angle : angle;
    return y < 0.0f ? -angle : angle;
}
} // namespace tyndall
