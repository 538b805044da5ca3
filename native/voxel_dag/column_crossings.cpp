// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/column_crossings.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/wide_integer.hpp"
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <utility>

namespace tyndall::voxel_dag {
namespace {
constexpr std::int64_t voxel_steps = std::int64_t{1} << step_bits, half_voxel = voxel_steps / 2;

/// Voxels whose centres lie from `least` to `most`, at most those of the cube.
struct Centres {
    std::int64_t from, to;
    Centres(std::int64_t least, std::int64_t most, std::int64_t resolution)
        : from(std::max<std::int64_t>(floor_of_quotient(least - half_voxel - 1, voxel_steps) + 1, 0)),
          to(std::min(floor_of_quotient(most - half_voxel, voxel_steps), resolution - 1)) {}
};

/// Columns that one triangle crosses. Places are taken from its first corner.
template <typename Integer>
class Crossing {
public:
    explicit Crossing(const SnappedTriangle& triangle) : origin_(triangle[0]) {
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (std::size_t axis = 0; axis < 3; ++axis)
                corner_[corner][axis] = triangle[corner][axis] - origin_[axis];
        const auto& b = corner_[1];
        const auto& c = corner_[2];
        normal_ = {b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]};
        sign_ = normal_[0] < 0 ? -1 : 1;
    }
    template <typename Append>
    void visit(std::int64_t resolution, const Append& append) const {
        if (normal_[0] == 0)
            return; // seen edge on: no line passes through its inside
        const auto box = [&](std::size_t axis) {
            const auto [least, most] = std::minmax({corner_[0][axis], corner_[1][axis], corner_[2][axis]});
            return Centres(static_cast<std::int64_t>(least) + origin_[axis],
                           static_cast<std::int64_t>(most) + origin_[axis], resolution);
        };
        const Centres rows = box(2), columns = box(1);
        for (std::int64_t z = rows.from; z <= rows.to; ++z) {
            std::int64_t from = columns.from, to = columns.to;
            for (std::size_t edge = 0; edge < 3; ++edge)
                keep_within(edge, z, from, to);
            for (std::int64_t y = from; y <= to; ++y)
                append(std::clamp<std::int64_t>(first_beyond(y, z), 0, resolution), y, z, normal_[0] < 0);
        }
    }

private:
    [[nodiscard]] Integer centre(std::int64_t voxel, std::size_t axis) const {
        return Integer{voxel * voxel_steps + half_voxel - origin_[axis]};
    }
    /// The columns y within one edge, e >= tie with e = rest + y * slope.
    void keep_within(std::size_t edge, std::int64_t z, std::int64_t& from, std::int64_t& to) const {
        const auto &a = corner_[edge], &b = corner_[(edge + 1) % 3];
        const Integer along_y = sign_ * (b[1] - a[1]), along_z = sign_ * (b[2] - a[2]);
        // The mesh is moved by e^2 along y, and by less along z.
        const Integer tie = along_z > 0 || (along_z == 0 && along_y < 0) ? 0 : 1;
        const Integer slope = -along_z * voxel_steps;
        const Integer rest = along_y * (centre(z, 2) - a[2]) - along_z * (centre(0, 1) - a[1]) - tie;
        if (slope > 0)
            from = static_cast<std::int64_t>(std::max<Integer>(from, -floor_of_quotient<Integer>(rest, slope)));
        else if (slope < 0)
            to = static_cast<std::int64_t>(std::min<Integer>(to, floor_of_quotient<Integer>(rest, -slope)));
        else if (rest < 0)
            to = from - 1;
    }
    /// x of the first voxel whose centre lies beyond the plane, which is moved by e: a centre on it lies before.
    [[nodiscard]] std::int64_t first_beyond(std::int64_t y, std::int64_t z) const {
        const std::int64_t voxel = origin_[0] >> step_bits;
        const Integer above = Integer{origin_[0] - voxel * voxel_steps - half_voxel};
        const Integer distance = sign_ * (normal_[0] * above - normal_[1] * centre(y, 1) - normal_[2] * centre(z, 2));
        const auto before =
            static_cast<std::int64_t>(floor_of_quotient<Integer>(distance, sign_ * normal_[0] * voxel_steps));
        return voxel + before + 1;
    }

    Steps origin_;
    std::array<std::array<Integer, 3>, 3> corner_;
    std::array<Integer, 3> normal_;
    Integer sign_; ///< 1 where the corners turn counter-clockwise as seen against x.
};

/// Products of three differences of such triangles, a step beyond them, fit 64 bits.
bool is_narrow(const SnappedTriangle& triangle) {
    constexpr std::int64_t most = std::int64_t{1} << 19;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, greatest] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
        if (greatest - least >= most)
            return false;
    }
    return true;
}
} // namespace

ColumnCrossings cross_columns(const SnappedMesh& mesh, const Progress& progress, bool sums_before) {
    const std::int64_t resolution = std::int64_t{1} << mesh.level;
    const std::size_t layer_count = (static_cast<std::size_t>(resolution) + tile_side - 1) / tile_side;
    const std::size_t count = mesh.triangles.size(), block_size = std::max<std::size_t>(1 << 12, count / 256 + 1);
    struct Block {
        std::vector<std::uint64_t> entries;
        std::vector<std::size_t> next; ///< By layer of tiles: how many, and then where they go.
    };
    std::vector<Block> blocks((count + block_size - 1) / block_size + 1); // the last for those before all voxels
    std::vector<std::int32_t> before(sums_before ? static_cast<std::size_t>(resolution * resolution) : 0);
    parallel_blocks(count, block_size, progress, [&](std::size_t begin, std::size_t end) {
        Block& block = blocks[begin / block_size];
        block.next.resize(layer_count);
        const auto append = [&](std::int64_t first, std::int64_t y, std::int64_t z, bool is_into) {
            if (first == resolution)
                return; // beyond all voxels
            if (sums_before && first == 0) {
                std::atomic_ref(before[static_cast<std::size_t>(z * resolution + y)])
                    .fetch_add(is_into ? 1 : -1, std::memory_order_relaxed);
                return;
            }
            block.entries.push_back(ColumnCrossings::entry(static_cast<std::uint32_t>(first),
                                                           static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(z),
                                                           is_into));
            ++block.next[static_cast<std::size_t>(z) / tile_side];
        };
        for (std::size_t index = begin; index < end; ++index) {
            const SnappedTriangle triangle = mesh.triangle(index);
            if (is_narrow(triangle))
                Crossing<std::int64_t>(triangle).visit(resolution, append);
            else
                Crossing<Int128>(triangle).visit(resolution, append);
        }
    });

    Block& last = blocks.back();
    last.next.resize(layer_count);
    for (std::size_t column = 0; column < before.size(); ++column)
        for (std::int32_t left = std::abs(before[column]); left > 0; --left) {
            const auto y = static_cast<std::uint32_t>(column % static_cast<std::size_t>(resolution)),
                       z = static_cast<std::uint32_t>(column / static_cast<std::size_t>(resolution));
            last.entries.push_back(ColumnCrossings::entry(0, y, z, before[column] > 0));
            ++last.next[z / tile_side];
        }
    std::vector<std::size_t> first_of_layer{0};
    for (std::size_t layer = 0; layer < layer_count; ++layer) {
        std::size_t end = first_of_layer.back();
        for (Block& block : blocks)
            end += std::exchange(block.next[layer], end);
        first_of_layer.push_back(end);
    }
    ColumnCrossings crossings{.entries = large_vector<std::uint64_t>(first_of_layer.back())};
    parallel_for(
        blocks.size(), progress,
        [&](std::size_t index) {
            for (const std::uint64_t entry : blocks[index].entries)
                crossings.entries[blocks[index].next[ColumnCrossings::tile_row(entry) >> (most_level - tile_level)]++] =
                    entry;
        },
        1);
    blocks.clear();
    parallel_for(
        layer_count, progress,
        [&](std::size_t layer) {
            std::sort(crossings.entries.begin() + static_cast<std::ptrdiff_t>(first_of_layer[layer]),
                      crossings.entries.begin() + static_cast<std::ptrdiff_t>(first_of_layer[layer + 1]));
        },
        1);
    return crossings;
}
} // namespace tyndall::voxel_dag
