// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/stored_order.hpp"
#include "voxel_dag/stored_walk.hpp"

namespace tyndall::voxel_dag {
static std::uint64_t bit_count(std::uint64_t bits) { return static_cast<std::uint64_t>(std::popcount(bits)); }

std::uint64_t StoredOrder::byte_count() const {
    std::uint64_t bytes = 8 * counts.size();
    for (const std::vector<std::uint32_t>& directory : directories)
        bytes += 4 * directory.size();
    return bytes;
}

std::uint64_t pair_mask(const PackedDag& dag, std::uint32_t pair) {
    const PackedLeaf leaf = packed_leaf(dag, pair);
    return turned_leaf(leaf.tag, leaf.mask);
}

/// Of a record of 8^3, the voxels in octants below `past`.
static std::uint64_t voxels_of_8(const PackedDag& dag, const PackedHeader& header, std::uint32_t past) {
    std::uint64_t count = 0;
    for (std::uint32_t left = header.child_mask & ((1u << past) - 1); left != 0; left &= left - 1)
        count += bit_count(
            packed_leaf(dag, packed_pair(dag, header, static_cast<std::uint32_t>(std::countr_zero(left)))).mask);
    return count;
}
/// The same of a record of 16^3.
static std::uint64_t voxels_of_16(const PackedDag& dag, const PackedNode& node, const PackedHeader& header,
                                  std::uint32_t past) {
    std::uint64_t count = 0;
    for (std::uint32_t left = header.child_mask & ((1u << past) - 1); left != 0; left &= left - 1) {
        const auto octant = static_cast<std::uint32_t>(std::countr_zero(left));
        const PackedNode child = packed_child(dag, leaf_level + 2, node, header, octant);
        count += voxels_of_8(dag, packed_header(dag, leaf_level + 1, child), 8);
    }
    return count;
}

namespace {
/// What counts say of one child, or of several together.
struct Counted {
    std::uint64_t voxels = 0, nodes = 0, bits = 0;
    Counted& operator+=(const Counted& other) {
        voxels += other.voxels, nodes += other.nodes, bits += other.bits;
        return *this;
    }
};
constexpr std::uint32_t width_bits = 6;

/// The counts of a record, found and read.
class EntryCounts {
public:
    EntryCounts(const StoredOrder& order, std::uint32_t level, std::uint64_t bit, std::uint32_t child_count)
        : order_(order), is_lowest_(level == counted_level), bit_(bit) {
        const std::uint32_t field_count = is_lowest_ ? 1 : 3;
        if (child_count > 1)
            for (std::uint32_t field = 0; field < field_count; ++field, bit_ += width_bits)
                widths_[field] = static_cast<std::uint32_t>(read_bits(order.counts, bit_, width_bits));
        inside_bit_ = bit_ + std::uint64_t{child_count - 1} * (widths_[0] + widths_[1] + widths_[2]);
    }
    /// Of the first children together.
    [[nodiscard]] Counted first(std::uint32_t count) const {
        Counted sum;
        std::uint64_t bit = bit_;
        const auto take = [&](std::uint32_t width) {
            bit += width;
            return read_bits(order_.counts, bit - width, width);
        };
        for (std::uint32_t child = 0; child < count; ++child) {
            sum.voxels += take(widths_[0]);
            sum.nodes += is_lowest_ ? 1 : take(widths_[1]);
            sum.bits += take(widths_[2]);
        }
        return sum;
    }
    /// Where the counts of the children that lie inside begin.
    [[nodiscard]] std::uint64_t inside_bit() const { return inside_bit_; }

private:
    const StoredOrder& order_;
    bool is_lowest_;
    std::uint64_t bit_, inside_bit_;
    std::array<std::uint32_t, 3> widths_{};
};

class Counting {
public:
    Counting(const PackedDag& dag, const Progress& progress) : dag_(dag), progress_(progress) {}

    StoredOrder run() {
        BitWriter counts;
        for (std::uint32_t level = counted_level; level < dag_.level; ++level)
            count_shared(level, counts);
        order_.root_bit = counts.size();
        if (dag_.level >= counted_level)
            order_.node_count = count(dag_.level, dag_.root_bit, counts).nodes;
        else
            order_.node_count = dag_.level >= least_mean_level ? 1 : 0;
        order_.counts = std::move(counts).padded_words();
        return std::move(order_);
    }

private:
    static constexpr std::uint32_t least_parallel_level = 9; // as in StoredWalk
    static constexpr std::size_t block = 64;

    void count_shared(std::uint32_t level, BitWriter& counts) {
        const std::vector<std::uint32_t>& records = dag_.levels[level - leaf_level - 1].directory;
        std::vector<Counted> counted(records.size());
        std::vector<BitWriter> parts(records.size());
        parallel_for(
            records.size(), progress_,
            [&](std::size_t rank) { counted[rank] = count(level, records[rank], parts[rank]); }, block);
        std::vector<std::uint32_t>& directory = order_.directories.emplace_back();
        for (const BitWriter& part : parts) {
            require(counts.size() >> 32 == 0, "voxel DAG: counts of voxels take more than 512 MiB");
            directory.push_back(static_cast<std::uint32_t>(counts.size()));
            counts.append(part);
        }
        shared_.push_back(std::move(counted));
    }

    Counted count(std::uint32_t level, std::uint64_t bit, BitWriter& out) const {
        const PackedNode node{.bit = bit};
        const PackedHeader header = packed_header(dag_, level, node);
        std::array<std::uint32_t, 8> octants{};
        std::uint32_t child_count = 0;
        for (std::uint32_t left = header.child_mask; left != 0; left &= left - 1)
            octants[child_count++] = static_cast<std::uint32_t>(std::countr_zero(left));
        std::array<Counted, 8> counted;
        std::array<BitWriter, 8> inside;
        const auto count_child = [&](std::size_t child) {
            const std::optional<std::uint32_t> rank = packed_rank(dag_, level, header, octants[child]);
            if (rank && level > counted_level) {
                counted[child] = shared_[level - 1 - counted_level][*rank];
                counted[child].bits = 0;
                return;
            }
            const PackedNode at = packed_child(dag_, level, node, header, octants[child]);
            if (level == counted_level)
                counted[child] = {voxels_of_16(dag_, at, packed_header(dag_, level - 1, at), 8), 1, 0};
            else
                counted[child] = count(level - 1, at.bit, inside[child]);
        };
        if (level >= least_parallel_level)
            parallel_for(child_count, progress_, count_child, 1);
        else
            for (std::size_t child = 0; child < child_count; ++child)
                count_child(child);
        write(level, std::span(counted).first(child_count), out);
        Counted all{.voxels = 0, .nodes = 1, .bits = 0};
        for (std::size_t child = 0; child < child_count; ++child) {
            out.append(inside[child]);
            all += counted[child];
        }
        all.bits = out.size();
        return all;
    }

    static void write(std::uint32_t level, std::span<const Counted> counted, BitWriter& out) {
        if (counted.size() == 1)
            return;
        Counted largest;
        for (const Counted& child : counted.first(counted.size() - 1))
            largest = {std::max(largest.voxels, child.voxels), std::max(largest.nodes, child.nodes),
                       std::max(largest.bits, child.bits)};
        const auto width_of = [](std::uint64_t value) { return static_cast<std::uint32_t>(std::bit_width(value)); };
        const std::array widths{width_of(largest.voxels), width_of(largest.nodes), width_of(largest.bits)};
        const std::size_t field_count = level == counted_level ? 1 : 3;
        for (std::size_t field = 0; field < field_count; ++field)
            out.append(widths[field], width_bits);
        for (const Counted& child : counted.first(counted.size() - 1)) {
            const std::array fields{child.voxels, child.nodes, child.bits};
            for (std::size_t field = 0; field < field_count; ++field)
                out.append(fields[field], widths[field]);
        }
    }

    const PackedDag& dag_;
    const Progress& progress_;
    StoredOrder order_;
    std::vector<std::vector<Counted>> shared_; ///< By level from counted_level on, and rank.
};
} // namespace

StoredOrder stored_order_of(const PackedDag& dag, const Progress& progress) {
    progress.poll();
    return dag.is_empty() ? StoredOrder{} : Counting(dag, progress).run();
}

void require_usable(const StoredOrder& order, const PackedDag& dag) {
    const std::size_t level_count = dag.is_empty() || dag.level < counted_level ? 0 : dag.level - counted_level;
    require(order.directories.size() == level_count, "voxel DAG: counts of ", order.directories.size(),
            " levels of shared records instead of ", level_count);
    const std::uint64_t bit_count = 64 * order.counts.size();
    constexpr std::uint64_t slack_bits = 64; // behind the last bit that is read
    const auto is_there = [&](std::uint64_t bit) { return bit + slack_bits <= bit_count; };
    for (std::size_t i = 0; i < level_count; ++i) {
        const std::uint32_t level = static_cast<std::uint32_t>(i) + counted_level;
        require(order.directories[i].size() == dag.levels[level - leaf_level - 1].directory.size(),
                "voxel DAG: counts of ", order.directories[i].size(), " shared records of level ", level,
                " instead of ", dag.levels[level - leaf_level - 1].directory.size());
        require(std::ranges::all_of(order.directories[i], is_there), "voxel DAG: the directory of counts of level ",
                level, " leaves them");
    }
    require(dag.is_empty() || is_there(order.root_bit), "voxel DAG: the root's counts are not there");
}

StoredPlace stored_child(const PackedDag& dag, const StoredOrder& order, std::uint32_t level, const StoredPlace& place,
                         const PackedHeader& header, std::uint32_t octant) {
    if (level == leaf_level + 1)
        return {.node = {.bit = packed_pair(dag, header, octant), .turn = place.node.turn},
                .first_entry = place.first_entry + voxels_of_8(dag, header, octant)};
    StoredPlace child{.node = packed_child(dag, level, place.node, header, octant)};
    if (level < counted_level) {
        child.first_entry = place.first_entry + voxels_of_16(dag, place.node, header, octant);
        return child;
    }
    const auto child_count = static_cast<std::uint32_t>(std::popcount(header.child_mask));
    const auto index = static_cast<std::uint32_t>(std::popcount(header.child_mask & ((1u << octant) - 1)));
    const EntryCounts counts(order, level, place.counts_bit, child_count);
    const Counted before = counts.first(index);
    child.first_entry = place.first_entry + before.voxels;
    child.number = place.number + 1 + before.nodes;
    if (level > counted_level) {
        const std::optional<std::uint32_t> rank = packed_rank(dag, level, header, octant);
        child.counts_bit =
            rank ? order.directories[level - 1 - counted_level][*rank] : counts.inside_bit() + before.bits;
    }
    return child;
}

std::optional<StoredCube> find_stored(const PackedDag& dag, const StoredOrder& order, const Voxel& voxel,
                                      std::uint32_t level) {
    if (dag.is_empty() || std::ranges::any_of(voxel, [&](std::uint32_t at) { return at >> dag.level != 0; }))
        return std::nullopt;
    const std::uint64_t code = morton_code(voxel);
    StoredPlace place = stored_root(dag, order);
    for (std::uint32_t at = dag.level; at > leaf_level; --at) {
        if (at <= level && at >= least_mean_level)
            return StoredCube{.first_entry = place.first_entry, .entry_count = 0, .number = place.number};
        const PackedHeader header = packed_header(dag, at, place.node);
        if (at <= level)
            return StoredCube{.first_entry = place.first_entry, .entry_count = voxels_of_8(dag, header, 8)};
        const auto there = static_cast<std::uint32_t>(code >> 3 * (at - 1) & 7);
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[place.node.turn]][there];
        if ((header.child_mask >> octant & 1) == 0)
            return std::nullopt;
        place = stored_child(dag, order, at, place, header, octant);
    }
    const std::uint64_t mask = pair_mask(dag, static_cast<std::uint32_t>(place.node.bit));
    const std::uint32_t at = turned_voxel(cube_group.inverse[place.node.turn], static_cast<std::uint32_t>(code & 63));
    // Within a brick a voxel, an octant of 8 and the whole are runs of bits.
    const std::uint32_t kept = std::min(level, leaf_level), first_bit = at >> 3 * kept << 3 * kept;
    const std::uint64_t run = kept == leaf_level ? mask : mask >> first_bit & ((1ull << (1u << 3 * kept)) - 1);
    if (run == 0)
        return std::nullopt;
    return StoredCube{.first_entry = place.first_entry + bit_count(mask & ((1ull << first_bit) - 1)),
                      .entry_count = bit_count(run)};
}

namespace {
struct Reordering {
    struct Sum {};
    static constexpr std::uint32_t least_level = leaf_level;

    Sum at_end(const StoredPlace& place, const MortonPlace& morton, std::uint64_t voxel_count) const {
        const std::uint32_t turn = place.node.turn, back = cube_group.inverse[turn];
        std::uint32_t* const to = &stored[place.first_entry - first_entry];
        std::uint64_t voxel = morton.first_voxel;
        if (turn == 0) {
            std::copy_n(&values[voxel], voxel_count, to);
            return {};
        }
        const std::uint64_t mask = pair_mask(dag, static_cast<std::uint32_t>(place.node.bit));
        for (std::uint64_t left = turned_leaf(turn, mask); left != 0; left &= left - 1) {
            const std::uint32_t at = turned_voxel(back, static_cast<std::uint32_t>(std::countr_zero(left)));
            to[bit_count(mask & ((std::uint64_t{1} << at) - 1))] = values[voxel++];
        }
        return {};
    }
    static Sum joined(const StoredPlace&, const MortonPlace&, const std::array<Sum, 8>&) { return {}; }

    const PackedDag& dag;
    std::uint64_t first_entry;
    std::span<const std::uint32_t> values;
    std::span<std::uint32_t> stored;
};

struct Renumbering {
    struct Sum {};
    static constexpr std::uint32_t least_level = least_mean_level;

    Sum at_end(const StoredPlace& place, const MortonPlace& morton, std::uint64_t) const { return copy(place, morton); }
    Sum joined(const StoredPlace& place, const MortonPlace& morton, const std::array<Sum, 8>&) const {
        return copy(place, morton);
    }
    Sum copy(const StoredPlace& place, const MortonPlace& morton) const {
        stored[place.number - first_number] = values[morton.number];
        return {};
    }

    std::uint64_t first_number;
    std::span<const std::uint32_t> values;
    std::span<std::uint32_t> stored;
};
} // namespace

void to_stored_order(const PackedDag& dag, const StoredOrder& order, const StoredSubtree& subtree,
                     std::span<const std::uint32_t> values, std::span<std::uint32_t> stored, const Progress& progress) {
    require(values.size() == subtree.voxel_count && stored.size() == subtree.voxel_count, "voxel DAG: ", values.size(),
            " values for ", subtree.voxel_count, " voxels");
    if (dag.is_empty())
        return;
    const Reordering reordering{
        .dag = dag, .first_entry = subtree.place.first_entry, .values = values, .stored = stored};
    StoredWalk(dag, order, reordering, progress).run(subtree);
}

void nodes_to_stored_order(const PackedDag& dag, const StoredOrder& order, const StoredSubtree& subtree,
                           std::span<const std::uint32_t> values, std::span<std::uint32_t> stored,
                           const Progress& progress) {
    require(values.size() == subtree.node_count && stored.size() == subtree.node_count, "voxel DAG: ", values.size(),
            " values for ", subtree.node_count, " nodes");
    if (subtree.node_count == 0)
        return;
    const Renumbering renumbering{.first_number = subtree.place.number, .values = values, .stored = stored};
    StoredWalk(dag, order, renumbering, progress).run(subtree);
}
} // namespace tyndall::voxel_dag
