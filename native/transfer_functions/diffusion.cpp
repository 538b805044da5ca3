// SPDX-License-Identifier: GPL-3.0-or-later
// A plate under tension through points, as a sum of cosines, which are flat at the borders.
// Based on: Wessel, Bercovici, Interpolation with splines in tension: a Green's function approach, Mathematical Geology
//           30(1), 1998; Finch, Snyder, Hoppe, Freeform vector graphics with controlled thin-plate splines, SIGGRAPH
//           Asia 2011, for what such a field is to an artist.
// Differs:  the Green's function is that of the square with flat borders, diagonal in cosines, and cut off after
//           `modes` of them per axis: the field meets its constraints anywhere, not at texels. It bends over a 256th of
//           the sides at least, so that the peaks of Laplace's equation are as wide as a cosine can show. Constraints
//           nearer to one another than `sharing_radius` are tied by springs, the stiffer the nearer they are: two at one
//           place have their mean there, and one that is dragged over another does not tilt the whole plate.
// Bound:    modes^2 * n^2 multiplications for n constraints, and 4 * modes * size * (modes + size) for the field.
#include "transfer_functions/diffusion.hpp"
#include "core/parallel.hpp"
#include "transfer_functions/matrix_product.hpp"
#include <algorithm>
#include <array>
#include <numbers>

namespace tyndall::transfer_functions {
namespace {
constexpr std::size_t modes = 128; ///< Cosines per axis, the constant one included.
constexpr float least_smoothness = 1.0f / 256.0f;
constexpr double sharing_radius = 1.0 / 64.0;

constexpr std::size_t padded(std::size_t count, std::size_t to) { return (count + to - 1) / to * to; }

/// cos(mode pi x) of positions along one axis.
double cosine(std::size_t mode, double position) {
    return std::cos(static_cast<double>(mode) * std::numbers::pi * position);
}

/// Of a point force: the amplitude of cos(k pi x) cos(l pi y), over the two cosines at the force's place.
double compliance(std::size_t k, std::size_t l, double smoothness) {
    if (k + l == 0)
        return 0.0;
    const double lambda = std::numbers::pi * std::numbers::pi * static_cast<double>(k * k + l * l);
    const double norm = (k == 0 ? 1.0 : 2.0) * (l == 0 ? 1.0 : 2.0);
    return norm / (lambda + smoothness * smoothness * lambda * lambda);
}

using Rgba = std::array<double, 4>;

/// Multiplied with alpha.
std::vector<Rgba> values_of(std::span<const Constraint> constraints) {
    std::vector<Rgba> values;
    for (const Constraint& constraint : constraints) {
        const glm::dvec4 colour(constraint.colour);
        values.push_back({colour.x * colour.w, colour.y * colour.w, colour.z * colour.w, colour.w});
    }
    return values;
}

/// What a pair's springs give way, of what opposite forces at sharing_radius bend the plate: 1 at one place, 0 from there.
double nearness(const Constraint& a, const Constraint& b) {
    const dvec2 way = (dvec2(a.position) - dvec2(b.position)) / sharing_radius;
    const double share = std::max(1.0 - glm::dot(way, way), 0.0);
    return share * share;
}

/// Of the field at one place less that at another, sharing_radius away, bent by a force at the one; mean over the square.
double compliance_nearby(std::span<const double> compliances) {
    double sum = 0.0;
    for (std::size_t k = 0; k < modes; ++k)
        for (std::size_t l = 0; l < modes; ++l)
            sum += compliances[k * modes + l] / ((k == 0 ? 1.0 : 2.0) * (l == 0 ? 1.0 : 2.0)) *
                   (1.0 - cosine(k, sharing_radius));
    return sum;
}

/// Solves matrix * x = right in place, by Gauss with partial pivoting.
void solve(std::vector<std::vector<double>>& matrix, std::vector<Rgba>& right) {
    const std::size_t count = matrix.size();
    for (std::size_t step = 0; step < count; ++step) {
        std::size_t pivot = step;
        for (std::size_t row = step + 1; row < count; ++row)
            if (std::abs(matrix[row][step]) > std::abs(matrix[pivot][step]))
                pivot = row;
        std::swap(matrix[step], matrix[pivot]);
        std::swap(right[step], right[pivot]);
        for (std::size_t row = step + 1; row < count; ++row) {
            const double factor = matrix[row][step] / matrix[step][step];
            for (std::size_t column = step; column < count; ++column)
                matrix[row][column] -= factor * matrix[step][column];
            for (std::size_t c = 0; c < 4; ++c)
                right[row][c] -= factor * right[step][c];
        }
    }
    for (std::size_t row = count; row-- > 0;)
        for (std::size_t c = 0; c < 4; ++c) {
            for (std::size_t column = row + 1; column < count; ++column)
                right[row][c] -= matrix[row][column] * right[column][c];
            right[row][c] /= matrix[row][row];
        }
}

/// Constraints, and cosines at their places.
struct Places {
    std::size_t count, padded_count;
    std::vector<double> x;            ///< cos(k pi x), per constraint and mode.
    std::vector<double> y, y_by_mode; ///< cos(l pi y), per constraint and mode; and per mode and constraint.

    explicit Places(std::span<const Constraint> constraints)
        : count(constraints.size()), padded_count(padded(count, values_per_line<double>)), x(count * modes),
          y(count * modes), y_by_mode(modes * padded_count) {
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t mode = 0; mode < modes; ++mode) {
                x[i * modes + mode] = cosine(mode, static_cast<double>(constraints[i].position.x));
                y[i * modes + mode] = cosine(mode, static_cast<double>(constraints[i].position.y));
                y_by_mode[mode * padded_count + i] = y[i * modes + mode];
            }
    }
};

/// Forces at the constraints, and behind them the field's mean: the field that they bend has the values.
std::vector<Rgba> forces(std::span<const Constraint> constraints, const Places& places,
                         std::span<const double> compliances, const Progress& progress) {
    const std::size_t count = places.count;
    std::vector<std::vector<double>> matrix(count + 1, std::vector<double>(count + 1, 1.0));
    parallel_blocks(count, 8, progress, [&](std::size_t first, std::size_t end) {
        const std::size_t rows = end - first;
        std::vector<double> left(rows * modes), product(rows * places.padded_count);
        for (std::size_t row = first; row < end; ++row)
            std::fill_n(matrix[row].begin(), count, 0.0);
        for (std::size_t k = 0; k < modes; ++k) {
            for (std::size_t row = 0; row < rows; ++row)
                for (std::size_t l = 0; l < modes; ++l)
                    left[row * modes + l] = compliances[k * modes + l] * places.y[(first + row) * modes + l];
            multiply(left.data(), places.y_by_mode.data(), rows, modes, places.padded_count, product.data());
            for (std::size_t row = 0; row < rows; ++row)
                for (std::size_t column = 0; column < count; ++column)
                    matrix[first + row][column] += places.x[(first + row) * modes + k] * places.x[column * modes + k] *
                                                   product[row * places.padded_count + column];
        }
    });
    const double tie = compliance_nearby(compliances);
    for (std::size_t row = 0; row < count; ++row)
        for (std::size_t column = 0; column < count; ++column) {
            const double give = tie * nearness(constraints[row], constraints[column]);
            matrix[row][row] += give; // a constraint with itself: nothing, in sum
            matrix[row][column] -= give;
        }
    matrix[count][count] = 0.0;
    std::vector<Rgba> values = values_of(constraints);
    values.push_back({});
    solve(matrix, values);
    return values;
}
} // namespace

Diffusion::Diffusion(std::span<const Constraint> constraints, float smoothness, std::uint32_t size,
                     const Progress& progress)
    : size_(size), stride_(padded(size, values_per_line<float>)), cosines_(modes * stride_),
      amplitudes_(std::size_t{size} * 4 * modes) {
    lowest_ = vec4(std::numeric_limits<float>::infinity());
    highest_ = -lowest_;
    for (const Constraint& constraint : constraints) {
        const bool has_colour = constraint.colour.w > 0.0f;
        for (int c = has_colour ? 0 : 3; c < 4; ++c) {
            lowest_[c] = std::min(lowest_[c], constraint.colour[c]);
            highest_[c] = std::max(highest_[c], constraint.colour[c]);
        }
    }
    std::vector<double> compliances(modes * modes);
    for (std::size_t k = 0; k < modes; ++k)
        for (std::size_t l = 0; l < modes; ++l)
            compliances[k * modes + l] = compliance(k, l, static_cast<double>(std::max(smoothness, least_smoothness)));
    const Places places(constraints);
    const std::vector<Rgba> force = forces(constraints, places, compliances, progress);

    for (std::size_t mode = 0; mode < modes; ++mode)
        for (std::size_t texel = 0; texel < size; ++texel)
            cosines_[mode * stride_ + texel] =
                static_cast<float>(cosine(mode, (static_cast<double>(texel) + 0.5) / static_cast<double>(size)));

    // First along y, for 8 cosines along x at a time: their amplitude at each row of texels.
    parallel_blocks(modes, 8, progress, [&](std::size_t first, std::size_t end) {
        const std::size_t rows = (end - first) * 4;
        std::vector<double> bent(rows * places.count), both(rows * modes);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t i = 0; i < places.count; ++i)
                bent[row * places.count + i] = places.x[i * modes + first + row / 4] * force[i][row % 4];
        multiply(bent.data(), places.y.data(), rows, places.count, modes, both.data());
        std::vector<float> left(rows * modes), along_x(rows * stride_);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t l = 0; l < modes; ++l)
                left[row * modes + l] =
                    static_cast<float>(both[row * modes + l] * compliances[(first + row / 4) * modes + l]);
        if (first == 0)
            for (std::size_t c = 0; c < 4; ++c)
                left[c * modes] = static_cast<float>(force[places.count][c]);
        multiply(left.data(), cosines_.data(), rows, modes, stride_, along_x.data());
        for (std::size_t texel = 0; texel < size; ++texel)
            for (std::size_t row = 0; row < rows; ++row)
                amplitudes_[(texel * 4 + row % 4) * modes + first + row / 4] = along_x[row * stride_ + texel];
    });
}

void Diffusion::row(std::uint32_t row, std::span<vec4> colours) const {
    std::vector<float> field(4 * stride_);
    multiply(&amplitudes_[std::size_t{row} * 4 * modes], cosines_.data(), 4, modes, stride_, field.data());
    for (std::size_t texel = 0; texel < size_; ++texel) {
        const vec3 with_alpha(field[texel], field[stride_ + texel], field[2 * stride_ + texel]);
        const float alpha = glm::clamp(field[3 * stride_ + texel], lowest_.w, highest_.w);
        colours[texel] =
            alpha > 0.0f ? vec4(glm::clamp(with_alpha / alpha, vec3(lowest_), vec3(highest_)), alpha) : vec4(0.0f);
    }
}
} // namespace tyndall::transfer_functions
