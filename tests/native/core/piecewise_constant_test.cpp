// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/piecewise_constant.hpp"
#include "core/sobol.hpp"
#include "support/chi_square.hpp"
#include <doctest/doctest.h>

namespace piecewise_constant_test {
using namespace tyndall;

TEST_CASE("cells are drawn as often as they weigh, and the offset within a cell is uniform") {
    constexpr std::uint32_t columns = 5, rows = 3, parts = 2;
    const std::vector<float> weights{0, 1, 2, 0, 3, 0, 0, 0, 0, 0, 5, 0.5f, 0, 0, 8};
    std::vector<PiecewiseConstant1d> columns_of_row;
    std::vector<float> row_weights;
    for (std::uint32_t row = 0; row < rows; ++row) {
        const std::span cells = std::span(weights).subspan(row * columns, columns);
        columns_of_row.emplace_back(cells);
        row_weights.push_back(std::accumulate(cells.begin(), cells.end(), 0.0f));
    }
    const PiecewiseConstant2d grid(std::move(columns_of_row), row_weights);
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    constexpr std::uint32_t count = 100000;
    std::vector<double> observed(weights.size() * parts * parts), expected(observed.size());
    for (std::uint32_t index = 0; index < count; ++index) {
        const auto bits = pcg4d({index, 4, 5, 6});
        const auto [column, row, offset] = grid.sample({unit_float(bits[0]), unit_float(bits[1])});
        const auto part =
            static_cast<std::uint32_t>(offset.x * parts) + parts * static_cast<std::uint32_t>(offset.y * parts);
        observed[(row * columns + column) * parts * parts + part] += 1.0;
    }
    double sum = 0.0;
    for (std::uint32_t cell = 0; cell < columns * rows; ++cell) {
        CHECK(std::abs(grid.probability(cell % columns, cell / columns) - weights[cell] / total) < 1e-6);
        sum += grid.probability(cell % columns, cell / columns);
        for (std::uint32_t part = 0; part < parts * parts; ++part)
            expected[cell * parts * parts + part] = count * weights[cell] / total / (parts * parts);
    }
    CHECK(std::abs(sum - 1.0) < 1e-6);
    CHECK(support::is_plausible(support::chi_square_p_value(observed, expected), 1));
}
TEST_CASE("u = 0 and the largest u below 1 stay in cells that weigh something") {
    const PiecewiseConstant1d cells(std::vector<float>{0, 0, 1e-30f, 1e-30f, 0, 0});
    CHECK(cells.sample(0.0f).cell == 2);
    CHECK(cells.sample(0x1.fffffep-1f).cell == 3);
    CHECK(cells.sample(0x1.fffffep-1f).offset < 1.0f);
}
TEST_CASE("without any weight every cell is as likely") {
    const PiecewiseConstant1d cells(std::vector<float>(4, 0.0f));
    for (std::uint32_t cell = 0; cell < 4; ++cell)
        CHECK(cells.probability(cell) == 0.25f);
}
} // namespace piecewise_constant_test
