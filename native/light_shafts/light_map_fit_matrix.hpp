// SPDX-License-Identifier: GPL-3.0-or-later
// How the texels of a light's map make the radiance of view rays: a sparse matrix, T, with a row for each ray.
// Based on: Joseph, An Improved Algorithm for Reprojecting Rays through Pixel Images, IEEE Transactions on Medical Imaging
//           1(3), 1982; Kol, dissertation, TU Delft 2018, section 5.4.2, where T is what marching would read.
// Differs:  a ray reads the map where it crosses the middle of a column of texels (of a row, where it goes more along the
//           columns), linearly between two of them, and linearly between two columns: at those crossings bilinear reading
//           is just that. What is read follows from a straight line, so that a weight is all that is stored of a column,
//           and no index: about a sixth of the bytes of compressed rows of bilinear weights, and no merging. Rays that lie
//           within a fraction of a texel of each other, as those of one camera with the same angle around the light do,
//           read one line: the map is sampled once for all of them, and a ray's part is a product of two short arrays.
//           Weights are rounded to 16 bits of the largest of some columns: 1e-6 of a ray's radiance.
//           Both products form the same weights by the same operations, so that T and its transpose are one matrix.
// Bound:    per column that a ray is lit in 2 bytes and three multiply-adds, in SIMD lanes over columns; per column of a line,
//           which some ten rays share, two texels of 16 bytes.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// A colour per texel, padded: rgb and nothing. Row by row, bottom to top, LightMapMatrix::pitch() apart.
using MapTexels = std::vector<vec4>;

/// Consecutive weights of a ray's row, one for each column (or row) of texels.
struct RowStretch {
    std::uint32_t ray;
    std::uint32_t first_weight;
    float across_at_first; ///< Position along the columns (rows), in texels; texel i has its centre at i.
    float across_per_line;
    std::uint16_t first_line; ///< Column (row) of the first weight.
    std::uint16_t count;      ///< At least 1.
    std::uint16_t strip;      ///< Of the map's rows, in which all its lines have their first texel.
    bool goes_along_y;        ///< Lines are rows of texels, not columns.
    float weight_unit = 0.0f; ///< Of weights that are rounded to 16 bits.
};

/// A straight line of the map within one strip, that one or more rays read.
struct MapLine {
    float across_at_first = 0.0f, across_per_line = 0.0f; ///< As a RowStretch.
    std::uint32_t first_reader = 0;                       ///< Up to the next line's.
    std::uint16_t first_line = 0, count = 0;
    bool goes_along_y = false;
};
/// Consecutive weights of a ray's row, on a line.
struct LineReader {
    std::uint32_t ray, first_weight;
    std::uint16_t offset, count; ///< Of the line's samples.
    float weight_unit;           ///< Weights are multiples of it.
};

class LightMapMatrix {
public:
    /// Rows of texels that the transpose adds up at a time: with their colours they stay in the second-level cache.
    static constexpr std::uint32_t rows_per_strip = 32;

    /// Rows of consecutive rays.
    struct Part {
        std::vector<RowStretch> stretches; ///< `ray` and `first_weight` count from the part's own beginning.
        std::vector<float> weights;        ///< `channels` for each line.
        std::uint32_t channels = 1;        ///< 1, or 4 where colours differ.
        std::uint32_t ray_count = 0;
        /// Of the ray at work. Line i of `line_weights` crosses the map at across_at_first + i * across_per_line. Dark lines at
        /// the ends, and many in a row between, are left out.
        void add_stretches(bool goes_along_y, std::uint32_t first_line, float across_at_first, float across_per_line,
                           std::span<const float> line_weights);
        void end_ray() { ++ray_count; }
        /// One weight for each line, if it does for all three channels.
        void merge_channels();
        /// Four weights for each line.
        void split_channels();
    };

    /// Takes over the parts, in order; each has the channels that is_coloured says. resolution: texels per side, [2, 65535].
    /// Consecutive rays share a line where they stay within so many texels of each other.
    LightMapMatrix(std::uint32_t resolution, bool is_coloured, std::vector<Part> parts, const Progress& progress,
                   float shared_texels = 0.0f);

    [[nodiscard]] std::uint32_t resolution() const { return resolution_; }
    /// From a texel to the one above it. What a ray writes to one row and reads from the next soon after must not lie a
    /// multiple of 4 KiB apart, or nearly: the CPU would take the one for the other, and wait.
    [[nodiscard]] std::uint32_t pitch() const { return pitch_of(resolution_); }
    [[nodiscard]] static constexpr std::uint32_t pitch_of(std::uint32_t resolution) {
        return (resolution + 187) / 256 * 256 + 68;
    }
    /// Of arrays of texels, with the gaps between rows.
    [[nodiscard]] std::size_t texel_count() const { return std::size_t{resolution_} * pitch(); }
    [[nodiscard]] std::size_t ray_count() const { return first_of_ray_.size() - 1; }
    [[nodiscard]] bool is_coloured() const { return is_coloured_; }
    /// Lines of texels that rays are lit in, all together; each stands for two texels.
    [[nodiscard]] std::size_t weight_count() const { return weights_.size() / (is_coloured_ ? 4 : 1); }
    /// Samples of the map that a product takes: of each line as many as columns.
    [[nodiscard]] std::size_t sample_count() const;
    [[nodiscard]] std::size_t byte_count() const;

    /// T times a white map, radiance per ray: the sums of the rows, added up when they were built.
    [[nodiscard]] const std::vector<vec4>& white() const { return white_; }
    /// What a product with T keeps from call to call.
    using Scratch = std::vector<vec4>;
    /// T texels: radiance per ray.
    void multiply(std::span<const vec4> texels, std::span<vec4> radiance, Scratch& scratch,
                  const Progress& progress) const;
    /// Transpose of T times `radiance`, per texel; overwrites. No product's bits depend on the number of threads.
    void multiply_transposed(std::span<const vec4> radiance, std::span<vec4> texels, const Progress& progress) const;
    /// The same with squares of the weights: the diagonal of T'WT for weights W of the rays.
    void square_columns(std::span<const vec4> ray_weights, std::span<vec4> texels, const Progress& progress) const;

private:
    /// Makes lines of the stretches of a strip.
    void append_lines(std::span<const RowStretch> stretches, float shared_texels);
    [[nodiscard]] std::span<const LineReader> readers_of(std::size_t line) const;
    void add_to_texels(std::span<const vec4> ray_values, bool squares, std::span<vec4> texels,
                       const Progress& progress) const;

    std::uint32_t resolution_;
    bool is_coloured_;
    std::vector<MapLine> lines_;      ///< Strip by strip, and one more for its first_reader.
    std::vector<LineReader> readers_; ///< Line by line, and on a line ray by ray; so are the weights.
    std::vector<std::uint16_t> weights_;
    std::vector<std::uint32_t> first_of_strip_; ///< Into lines_.
    std::vector<std::uint32_t>
        first_of_ray_; ///< Ray r owns readers_[of_ray_[first_of_ray_[r] .. first_of_ray_[r + 1])].
    std::vector<std::uint32_t> of_ray_;
    std::vector<vec4> white_;
};
} // namespace tyndall::light_shafts
