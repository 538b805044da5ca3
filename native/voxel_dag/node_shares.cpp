// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/node_shares.hpp"
#include "core/parallel.hpp"

namespace tyndall::voxel_dag {
namespace {
constexpr std::uint32_t least_level = leaf_level + 2;        ///< Of 16^3: smaller records have no entry.
constexpr std::uint32_t least_parallel_level = 9;            ///< As in StoredWalk.
constexpr std::uint32_t side = 8, place_count = side * side; ///< Of a silhouette that a parent takes.

/// Of a node seen along each axis: of 8 x 8 places, the shares that are covered. The lower one of the other two axes
/// counts places, the higher one rows.
struct Silhouettes {
    std::array<std::array<float, place_count>, 3> along;
};
constexpr std::array<std::array<std::uint32_t, 2>, 3> others{{{1, 2}, {0, 2}, {0, 1}}};

Silhouettes turned(std::uint32_t element, const Silhouettes& from) {
    if (element == 0)
        return from;
    Silhouettes result;
    const std::uint32_t mirrored = cube_group.octant[element][0];
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t to = turned_axes[element][axis];
        const std::uint32_t low = turned_axes[element][others[axis][0]], high = turned_axes[element][others[axis][1]];
        for (std::uint32_t v = 0; v < side; ++v)
            for (std::uint32_t u = 0; u < side; ++u) {
                const std::uint32_t at_low = (mirrored >> low & 1) != 0 ? side - 1 - u : u;
                const std::uint32_t at_high = (mirrored >> high & 1) != 0 ? side - 1 - v : v;
                result.along[to][low < high ? at_low + side * at_high : at_high + side * at_low] =
                    from.along[axis][u + side * v];
            }
    }
    return result;
}

AxisShares shares_of(const Silhouettes& silhouettes) {
    std::array<double, 3> shares{};
    bool has_sheet = false;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        std::uint64_t full = 0, any = 0;
        for (std::uint32_t place = 0; place < place_count; ++place) {
            const float share = silhouettes.along[axis][place];
            shares[axis] += static_cast<double>(share) / place_count;
            full |= std::uint64_t{share > 0.95f} << place;
            any |= std::uint64_t{share > 0.0f} << place;
        }
        has_sheet |= 2 * std::popcount(full) >= std::popcount(any) && is_wide<side>(full);
    }
    return axis_shares(shares) | (has_sheet ? is_sheet : 0);
}

class Builder {
public:
    Builder(const PackedDag& dag, const Progress& progress) : dag_(dag), progress_(progress) {}

    /// Of all records of 16^3 and more.
    std::vector<KeyedValue> run() {
        std::vector<KeyedValue> found;
        for (std::uint32_t level = least_level; level < dag_.level; ++level)
            visit_shared(level, found);
        if (dag_.level >= least_level)
            visit(dag_.level, dag_.root_bit, found);
        return found;
    }

private:
    static constexpr std::size_t records_at_once = 64;

    void visit_shared(std::uint32_t level, std::vector<KeyedValue>& found) {
        const std::vector<std::uint32_t>& records = dag_.levels[level - leaf_level - 1].directory;
        std::vector<Silhouettes> silhouettes(level > least_level ? records.size() : 0);
        std::vector<std::vector<KeyedValue>> parts((records.size() + records_at_once - 1) / records_at_once);
        parallel_for(
            parts.size(), progress_,
            [&](std::size_t part) {
                const std::size_t begin = part * records_at_once;
                for (std::size_t rank = begin; rank < std::min(begin + records_at_once, records.size()); ++rank) {
                    const Silhouettes of_record = visit(level, records[rank], parts[part]);
                    if (level > least_level)
                        silhouettes[rank] = of_record;
                }
            },
            1);
        for (const std::vector<KeyedValue>& part : parts)
            found.insert(found.end(), part.begin(), part.end());
        shared_.push_back(std::move(silhouettes));
    }

    /// Of a record as it is stored; appends it and those that lie inside.
    Silhouettes visit(std::uint32_t level, std::uint64_t bit, std::vector<KeyedValue>& found) const {
        if (level == least_level)
            return visit_least(bit, found);
        const PackedNode node{.bit = bit};
        const PackedHeader header = packed_header(dag_, level, node);
        std::array<Silhouettes, 8> children;
        std::array<std::vector<KeyedValue>, 8> parts;
        const auto visit_child = [&](std::size_t i) {
            const auto octant = static_cast<std::uint32_t>(i);
            if ((header.child_mask >> octant & 1) == 0)
                return;
            const PackedNode child = packed_child(dag_, level, node, header, octant);
            const std::optional<std::uint32_t> rank = packed_rank(dag_, level, header, octant);
            if (!rank)
                children[octant] = visit(level - 1, child.bit, level >= least_parallel_level ? parts[octant] : found);
            else if (level - 1 > least_level)
                children[octant] = turned(child.turn, shared_[level - 1 - least_level][*rank]);
            else { // not kept: soon made again
                std::vector<KeyedValue> found_before;
                children[octant] = turned(child.turn, visit_least(child.bit, found_before));
            }
        };
        if (level >= least_parallel_level)
            parallel_for(8, progress_, visit_child, 1);
        else
            for (std::size_t octant = 0; octant < 8; ++octant)
                visit_child(octant);
        if (level >= least_parallel_level)
            for (const std::vector<KeyedValue>& part : parts)
                found.insert(found.end(), part.begin(), part.end());
        return joined(header.child_mask, children, bit, found);
    }

    static Silhouettes joined(std::uint32_t child_mask, const std::array<Silhouettes, 8>& children, std::uint64_t bit,
                              std::vector<KeyedValue>& found) {
        Silhouettes result;
        for (std::uint32_t axis = 0; axis < 3; ++axis)
            for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
                const std::uint32_t right = quarter & 1, upper = quarter >> 1;
                const std::uint32_t front = right << others[axis][0] | upper << others[axis][1];
                const std::uint32_t behind = front | 1u << axis;
                std::array<float, place_count> covered{};
                if ((child_mask >> front & 1) != 0)
                    covered = children[front].along[axis];
                if ((child_mask >> behind & 1) != 0)
                    for (std::uint32_t place = 0; place < place_count; ++place)
                        covered[place] += children[behind].along[axis][place] * (1.0f - covered[place]);
                for (std::uint32_t v = 0; v < side / 2; ++v)
                    for (std::uint32_t u = 0; u < side / 2; ++u) {
                        const std::uint32_t first = 2 * u + 2 * side * v;
                        const float mean = 0.25f * (covered[first] + covered[first + 1] + covered[first + side] +
                                                    covered[first + side + 1]);
                        result.along[axis][u + right * side / 2 + side * (v + upper * side / 2)] = mean;
                    }
            }
        found.push_back({bit, shares_of(result)});
        return result;
    }

    /// Of a record of 16^3, from its leaves.
    Silhouettes visit_least(std::uint64_t bit, std::vector<KeyedValue>& found) const {
        std::array<std::array<std::uint64_t, 16>, 3> flat{}; // by columns of bricks
        const PackedNode node{.bit = bit};
        const PackedHeader header = packed_header(dag_, least_level, node);
        for (std::uint32_t left = header.child_mask; left != 0; left &= left - 1) {
            const auto octant = static_cast<std::uint32_t>(std::countr_zero(left));
            const PackedNode child = packed_child(dag_, least_level, node, header, octant);
            const PackedHeader inner = packed_header(dag_, least_level - 1, child);
            for (std::uint32_t of_it = inner.child_mask; of_it != 0; of_it &= of_it - 1) {
                const auto stored = static_cast<std::uint32_t>(std::countr_zero(of_it));
                const PackedLeaf leaf = packed_leaf(dag_, packed_pair(dag_, inner, stored));
                const std::uint64_t mask = turned_leaf(cube_group.product[child.turn][leaf.tag], leaf.mask);
                const std::uint32_t there = cube_group.octant[child.turn][stored];
                for (std::uint32_t axis = 0; axis < 3; ++axis) {
                    std::uint32_t column = 0;
                    for (std::uint32_t other = 0; other < 2; ++other)
                        column |= ((octant >> others[axis][other] & 1) << 1 | (there >> others[axis][other] & 1))
                                  << 2 * other;
                    flat[axis][column] |= flattened(mask, axis);
                }
            }
        }
        Silhouettes result;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const std::uint32_t low = others[axis][0], high = others[axis][1];
            const std::uint64_t four = std::uint64_t{1} | 1u << (1u << low) | 1u << (1u << high) |
                                       1u << ((1u << low) + (1u << high)); // 2 x 2 columns of voxels
            for (std::uint32_t column = 0; column < 16; ++column) {
                for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
                    const std::uint32_t right = quarter & 1, upper = quarter >> 1;
                    const int count =
                        std::popcount(flat[axis][column] & four << (right * (8u << low) + upper * (8u << high)));
                    result.along[axis][2 * (column & 3) + right + side * (2 * (column >> 2) + upper)] =
                        0.25f * static_cast<float>(count);
                }
            }
        }
        found.push_back({bit, shares_of(result)});
        return result;
    }

    const PackedDag& dag_;
    const Progress& progress_;
    std::vector<std::vector<Silhouettes>> shared_; ///< By level from least_level on, and rank; of that level none.
};
} // namespace

NodeShares::NodeShares(const TraceTables& tables, const Progress& progress) {
    const PackedDag& dag = *tables.dag;
    if (dag.is_empty() || dag.level < least_level)
        return;
    records_ = RetrievalMap(Builder(dag, progress).run(), progress);
    // The topmost nodes again, as trace_tables.cpp lists them: level by level.
    std::vector<PackedNode> nodes{{.bit = dag.root_bit}}, below;
    for (std::uint32_t level = dag.level; level > tables.bottom; --level) {
        progress.poll();
        below.clear();
        for (const PackedNode& node : nodes) {
            top_.push_back(turned_shares(node.turn, records_.at(node.bit)));
            const PackedHeader header = packed_header(dag, level, node);
            const auto& stored = cube_group.octant[cube_group.inverse[node.turn]];
            for (std::uint32_t there = 0; there < 8; ++there)
                if ((header.child_mask >> stored[there] & 1) != 0)
                    below.push_back(packed_child(dag, level, node, header, stored[there]));
        }
        nodes.swap(below);
    }
}

AxisShares NodeShares::of_eight(const TraceTables& tables, const Cursor& cursor) {
    std::array<std::array<std::uint64_t, 4>, 3> flat{};
    Cursor at = cursor;
    CursorNode node{};
    for (std::uint32_t left = at.open(node); left != 0; left &= left - 1) {
        const auto along = static_cast<std::uint32_t>(std::countr_zero(left));
        Cursor leaf = at;
        leaf.go_down(leaf_level + 1, node, along);
        const std::uint64_t mask = turned_leaf(leaf.turn(), tables.dag->leaves[leaf.place()]);
        const std::uint32_t there = along ^ at.against();
        for (std::uint32_t axis = 0; axis < 3; ++axis)
            flat[axis][(there >> others[axis][0] & 1) | (there >> others[axis][1] & 1) << 1] |= flattened(mask, axis);
    }
    std::array<double, 3> shares{};
    bool has_sheet = false;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        std::uint64_t rows = 0; // of 8 x 8
        for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
            const std::uint64_t four = rows_of(flat[axis][quarter], axis);
            for (std::uint32_t v = 0; v < 4; ++v)
                rows |= (four >> 4 * v & 15) << (4 * (quarter & 1) + side * (v + 4 * (quarter >> 1)));
        }
        shares[axis] = std::popcount(rows) / 64.0;
        has_sheet |= is_wide<side>(rows);
    }
    return axis_shares(shares) | (has_sheet ? is_sheet : 0);
}
} // namespace tyndall::voxel_dag
