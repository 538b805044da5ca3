// SPDX-License-Identifier: GPL-3.0-or-later
// Sampling in proportion to weights, by inverting their cumulative sums: of an interval's cells, of a grid's cells.
// Based on: Pharr, Jakob, Humphreys, Physically Based Rendering, 4th ed. 2023, sections A.4.7 and A.5.6.
// Differs:  the PDF is read from the same rounded sums that are inverted, so that it is exactly what is drawn.
// Bound:    4 bytes per cell; a sample is two binary searches.
#pragma once
#include "core/math.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall {
class PiecewiseConstant1d {
public:
    PiecewiseConstant1d() = default;
    /// Weights are finite and not negative; if all are 0, every cell is as likely.
    explicit PiecewiseConstant1d(std::span<const float> weights);

    struct Sample {
        std::uint32_t cell;
        float offset; ///< Within the cell, [0, 1): what is left of u, uniform again.
    };
    [[nodiscard]] std::uint32_t cells() const { return static_cast<std::uint32_t>(sums_.size() - 1); }
    [[nodiscard]] Sample sample(float u) const;
    [[nodiscard]] float probability(std::uint32_t cell) const { return sums_[cell + 1] - sums_[cell]; }

private:
    std::vector<float> sums_; ///< cells + 1, from 0 to 1.
};

/// Rows of cells; each may have another number of them.
class PiecewiseConstant2d {
public:
    PiecewiseConstant2d() = default;
    PiecewiseConstant2d(std::vector<PiecewiseConstant1d> columns_of_row, std::span<const float> row_weights)
        : rows_(row_weights), columns_of_row_(std::move(columns_of_row)) {}
    [[nodiscard]] std::uint32_t rows() const { return static_cast<std::uint32_t>(columns_of_row_.size()); }
    [[nodiscard]] std::uint32_t columns(std::uint32_t row) const { return columns_of_row_[row].cells(); }

    struct Sample {
        std::uint32_t column, row;
        vec2 offset; ///< Within the cell, [0, 1)^2.
    };
    [[nodiscard]] Sample sample(vec2 u) const;
    [[nodiscard]] float probability(std::uint32_t column, std::uint32_t row) const {
        return rows_.probability(row) * columns_of_row_[row].probability(column);
    }

private:
    PiecewiseConstant1d rows_;
    std::vector<PiecewiseConstant1d> columns_of_row_;
};
} // namespace tyndall
