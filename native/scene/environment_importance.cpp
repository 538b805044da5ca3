// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment_importance.hpp"
#include "scene/world.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

namespace tyndall {
static constexpr float uniform_share = 0.01f;
/// By how much wider cells may raise the second moment of what directions find: their noise, where nothing shadows.
static constexpr double most_loss = 0.01;

/// Rec. 709 luminance of the magnitudes: a channel below 0 matters, too.
static float importance_of(const vec4& radiance) {
    return glm::dot(glm::abs(Rgb(radiance)), Rgb(0.2126f, 0.7152f, 0.0722f));
}

/// Height of the lower edge of a row on the unit sphere, [-1, 1].
static double edge_height(std::uint32_t row, std::uint32_t rows) {
    return std::sin((static_cast<double>(row) / rows - 0.5) * std::numbers::pi);
}
static float row_height(std::size_t row, std::uint32_t rows) {
    return static_cast<float>(edge_height(static_cast<std::uint32_t>(row + 1), rows) -
                              edge_height(static_cast<std::uint32_t>(row), rows));
}

namespace {
/// Of cells: the integral of the bilinear image (1/8, 3/4, 1/8 of texels along each axis), times their solid angle; and the
/// sum over their texels of that squared over the height of a texel's row, from which follows what wider cells cost.
struct Cells {
    std::vector<float> weights, squares;
    [[nodiscard]] double total() const { return std::accumulate(weights.begin(), weights.end(), 0.0); }
};

/// The rows of an image's texels, one after the other, each computed where it is asked for.
class TexelRows {
public:
    explicit TexelRows(const EnvironmentImage& image) : image_(image), width_(image.width), height_(image.height) {}

    /// `mixed`: with the uniform share.
    void append(std::size_t row, bool mixed, Cells& cells) {
        const float solid_angle = row_height(row, image_.height);
        const float* const below = along((row + height_ - 1) % height_);
        const float* const here = along(row);
        const float* const above = along((row + 1) % height_);
        for (std::size_t column = 0; column < width_; ++column) {
            float weight = (0.125f * below[column] + 0.75f * here[column] + 0.125f * above[column]) * solid_angle;
            if (mixed)
                weight = (1.0f - uniform_share) * weight + uniform_ * solid_angle;
            cells.weights.push_back(weight);
            cells.squares.push_back(solid_angle > 0.0f ? weight * weight / solid_angle : 0.0f);
        }
    }
    /// `total` / (2 width) is the weight that a uniform image of the same sum has per unit of height.
    void mix(double total) {
        uniform_ = static_cast<float>(uniform_share * total / (2.0 * static_cast<double>(width_)));
    }
    [[nodiscard]] float uniform() const { return uniform_; }

private:
    [[nodiscard]] const float* along(std::size_t row) {
        for (const Row& kept : rows_)
            if (kept.row == row)
                return kept.values.data();
        Row& kept = rows_[next_++ % rows_.size()];
        kept.row = row;
        kept.values.resize(width_);
        const vec4* const pixels = &image_.pixels[row * width_];
        for (std::size_t column = 0; column < width_; ++column)
            kept.values[column] = 0.125f * importance_of(pixels[(column + width_ - 1) % width_]) +
                                  0.75f * importance_of(pixels[column]) +
                                  0.125f * importance_of(pixels[(column + 1) % width_]);
        return kept.values.data();
    }

    struct Row {
        std::size_t row = std::numeric_limits<std::size_t>::max();
        std::vector<float> values;
    };
    const EnvironmentImage& image_;
    std::size_t width_, height_;
    float uniform_ = 0.0f;
    std::array<Row, 4> rows_; ///< The last ones, of which three are in use.
    std::size_t next_ = 0;
};
} // namespace

/// Two cells in one, of a row.
static void halve_row(std::vector<float>& values) {
    for (std::size_t cell = 0; cell < values.size() / 2; ++cell)
        values[cell] = values[2 * cell] + values[2 * cell + 1];
    values.resize(values.size() / 2);
}
/// Four cells in one.
static std::vector<float> halved(const std::vector<float>& values, std::size_t columns) {
    std::vector<float> half;
    half.reserve(values.size() / 4);
    for (std::size_t first = 0; first + 2 * columns <= values.size(); first += 2 * columns)
        for (std::size_t cell = first; cell < first + columns; cell += 2)
            half.push_back(values[cell] + values[cell + 1] + values[cell + columns] + values[cell + columns + 1]);
    return half;
}

/// Second moment of the texels' radiance over the PDF of cells in a row of this height that are so many texels wide.
static double moment_of(std::span<const float> weights, std::span<const float> squares, double height, double texels) {
    double moment = 0.0;
    for (std::size_t cell = 0; cell < weights.size(); ++cell)
        if (weights[cell] > 0.0f)
            moment += double{squares[cell]} * height * texels / weights[cell];
    return moment;
}

namespace {
/// Squares of texels, the widest that lose little; of one texel, they are left to be computed again.
struct Squares {
    std::uint32_t side = 1, columns, rows;
    Cells cells;
};
} // namespace

/// What the uniform share adds to squares of the pure weights. A cell spans `height` along a row of its texels, each side.
static void mix(Squares& squares, float uniform) {
    for (std::uint32_t row = 0; row < squares.rows; ++row) {
        const double height = edge_height(row + 1, squares.rows) - edge_height(row, squares.rows);
        const double solid = height * squares.side, pure = 1.0 - uniform_share;
        for (std::uint32_t column = 0; column < squares.columns; ++column) {
            const std::size_t cell = std::size_t{row} * squares.columns + column;
            const double weight = squares.cells.weights[cell], square = squares.cells.squares[cell];
            squares.cells.weights[cell] = static_cast<float>(pure * weight + uniform * solid);
            squares.cells.squares[cell] = static_cast<float>(pure * pure * square + 2.0 * pure * uniform * weight +
                                                             double{uniform} * uniform * solid);
        }
    }
}

static Squares squares_of(const EnvironmentImage& image, TexelRows& texels) {
    Squares found{.columns = image.width, .rows = image.height, .cells = {}};
    const bool is_even = image.width % 2 == 0 && image.height % 2 == 0;
    Squares next{.side = 2, .columns = image.width / 2, .rows = image.height / 2, .cells = {}};
    if (is_even)
        for (std::vector<float>* values : {&next.cells.weights, &next.cells.squares})
            values->reserve(std::size_t{next.columns} * next.rows);
    double total = 0.0;
    Cells two_rows;
    for (std::uint32_t row = 0; row < image.height; ++row) {
        texels.append(row, false, two_rows);
        if (is_even && row % 2 == 0)
            continue;
        total += two_rows.total();
        if (is_even)
            for (const auto& [of, to] : {std::pair(&two_rows.weights, &next.cells.weights),
                                         std::pair(&two_rows.squares, &next.cells.squares)}) {
                const std::vector<float> half = halved(*of, image.width);
                to->insert(to->end(), half.begin(), half.end());
            }
        two_rows.weights.clear(), two_rows.squares.clear();
    }
    texels.mix(total);
    if (!is_even)
        return found;
    mix(next, texels.uniform());
    while (true) {
        double moment = 0.0;
        for (std::uint32_t row = 0; row < next.rows; ++row)
            moment += moment_of(std::span(next.cells.weights).subspan(std::size_t{row} * next.columns, next.columns),
                                std::span(next.cells.squares).subspan(std::size_t{row} * next.columns, next.columns),
                                edge_height(row + 1, next.rows) - edge_height(row, next.rows), next.side);
        const double mixed = next.cells.total();
        if (mixed > 0.0 && !(moment <= (1.0 + most_loss) * mixed))
            return found;
        found = std::move(next);
        if (found.columns % 2 != 0 || found.rows % 2 != 0)
            return found;
        next = {.side = 2 * found.side,
                .columns = found.columns / 2,
                .rows = found.rows / 2,
                .cells = {.weights = halved(found.cells.weights, found.columns),
                          .squares = halved(found.cells.squares, found.columns)}};
    }
}

/// The widest cells of a row that lose little of it.
static PiecewiseConstant1d columns_of(Cells row, double height, std::uint32_t side) {
    const double most = (1.0 + most_loss) * row.total();
    for (double texels = 2.0 * side; row.weights.size() % 2 == 0; texels *= 2.0) {
        Cells wider = row;
        halve_row(wider.weights);
        halve_row(wider.squares);
        if (!(moment_of(wider.weights, wider.squares, height, texels) <= most))
            break;
        row = std::move(wider);
    }
    return PiecewiseConstant1d(row.weights);
}

EnvironmentImportance::EnvironmentImportance(const EnvironmentImage& image) {
    TexelRows texels(image);
    const Squares squares = squares_of(image, texels);
    std::vector<PiecewiseConstant1d> columns_of_row;
    std::vector<float> row_weights;
    for (std::uint32_t row = 0; row < squares.rows; ++row) {
        Cells cells;
        if (squares.side == 1) {
            texels.append(row, true, cells);
        } else {
            const auto first = static_cast<std::ptrdiff_t>(std::size_t{row} * squares.columns);
            const auto part = [&](const std::vector<float>& values) {
                return std::vector<float>(values.begin() + first, values.begin() + first + squares.columns);
            };
            cells = {.weights = part(squares.cells.weights), .squares = part(squares.cells.squares)};
        }
        edge_heights_.push_back(edge_height(row, squares.rows));
        const double height = edge_height(row + 1, squares.rows) - edge_heights_.back();
        row_weights.push_back(static_cast<float>(cells.total()));
        columns_of_row.push_back(columns_of(std::move(cells), height, squares.side));
        per_sr_.push_back(static_cast<float>(columns_of_row.back().cells() / (2.0 * std::numbers::pi) / height));
    }
    edge_heights_.push_back(1.0);
    cells_ = PiecewiseConstant2d(std::move(columns_of_row), row_weights);
}

EnvironmentImportance::Sample EnvironmentImportance::sample(vec2 u) const {
    const auto [column, row, offset] = cells_.sample(u);
    const double low = edge_heights_[row], high = edge_heights_[row + 1];
    const double height = low + static_cast<double>(offset.y) * (high - low);
    const auto radius = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - height * height)));
    return {.uv = {(static_cast<float>(column) + offset.x) / static_cast<float>(cells_.columns(row)),
                   angle_of(static_cast<float>(height), radius) * std::numbers::inv_pi_v<float> + 0.5f},
            .height = height,
            .pdf_per_sr = cells_.probability(column, row) * per_sr_[row]};
}

float EnvironmentImportance::pdf_per_sr(vec2 uv) const {
    const auto cell = [](float share, std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>(std::max(share, 0.0f) * static_cast<float>(count)), count - 1u);
    };
    const std::uint32_t row = cell(uv.y, cells_.rows()), column = cell(uv.x, cells_.columns(row));
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
