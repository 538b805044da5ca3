// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/sound_dag.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/trace_tables.hpp"
#include <atomic>

namespace tyndall::voxel_dag {
namespace {
constexpr std::uint32_t smallest_level = leaf_level + 1;
constexpr std::uint32_t least_split_level = 9; // as in StoredWalk

/// What the tree has of a record, or below it.
struct InTree {
    std::uint64_t voxels = 0;
    std::uint64_t nodes = 0; ///< Of 2^least_mean_level voxels a side and more.
    InTree& operator+=(const InTree& other) {
        voxels += other.voxels, nodes += other.nodes;
        return *this;
    }
};
/// A record with all that lies inside.
struct Extent {
    InTree in_tree;
    std::uint64_t end = 0, counts_end = 0; ///< Behind its bits, and those of its counts.
    std::uint64_t records = 1;
};

class Checking {
public:
    Checking(const PackedDag& dag, const StoredOrder* order, const Progress& progress)
        : dag_(dag), order_(order), progress_(progress), past_(64 * dag.records.size() - 64),
          past_counts_(order == nullptr ? 0 : 64 * order->counts.size() - 64) {}

    void run() {
        check_pairs();
        require(dag_.level > leaf_level || dag_.root_bit == 0, "voxel DAG: its one brick is not the first pair");
        InTree whole{.voxels = pair_voxels_[0], .nodes = 0};
        if (dag_.level > leaf_level) {
            for (std::uint32_t level = smallest_level; level <= dag_.level; ++level)
                tables_.push_back(make_record_table(dag_.levels[level - smallest_level]));
            check_smallest_shared();
            for (std::uint32_t level = smallest_level + 1; level < dag_.level; ++level)
                check_shared(level);
            require(dag_.levels.back().directory.empty(), "voxel DAG: there are records beside the root");
            const Extent root = dag_.level == smallest_level
                                    ? smallest(dag_.root_bit)
                                    : record(dag_.level, dag_.root_bit, order_ == nullptr ? 0 : order_->root_bit);
            whole = root.in_tree;
            record_count_ += root.records;
        }
        require(whole.voxels == dag_.voxel_count, "voxel DAG: its records have ", whole.voxels, " voxels instead of ",
                dag_.voxel_count);
        require(record_count_ + dag_.leaves.size() == dag_.node_count, "voxel DAG: it has ",
                record_count_ + dag_.leaves.size(), " nodes and leaves instead of ", dag_.node_count);
        require(order_ == nullptr || whole.nodes == order_->node_count, "voxel DAG: the tree has ", whole.nodes,
                " nodes instead of ", order_ == nullptr ? 0 : order_->node_count);
    }

private:
    /// What is read first of a record.
    struct Head {
        std::uint64_t fields;
        std::uint32_t count, classes;
    };
    /// What a record's counts say.
    struct Counts {
        std::array<InTree, 8> children{};
        std::array<std::uint64_t, 8> begins{}; ///< Of the counts of those that lie inside.
        std::uint64_t inside = 0;
    };

    [[noreturn]] static void lies(std::uint32_t level, std::uint64_t bit, const std::string& how) {
        refuse("voxel DAG: the record at bit ", bit, ", of 2^", level, " voxels a side, ", how);
    }
    [[nodiscard]] const RecordTable& table(std::uint32_t level) const { return tables_[level - smallest_level]; }
    static std::uint64_t low(std::uint64_t bits, std::uint32_t width) {
        return bits & ((std::uint64_t{1} << width) - 1);
    }
    [[nodiscard]] std::uint64_t at(std::uint64_t bit) const { return read_bits(dag_.records, bit, most_field_bits); }
    /// A place up to which bits may be read.
    void require_there(std::uint32_t level, std::uint64_t record, std::uint64_t bit) const {
        if (bit > past_)
            lies(level, record, "leaves the records");
    }

    void check_pairs() {
        const std::uint32_t width = dag_.leaf_bits + dag_.tag_bits;
        require(dag_.leaf_bits > 0, "voxel DAG: numbers of leaves have no bits");
        // Bits behind the last pair are 0, which is one, too.
        pair_voxels_.resize((64 * dag_.pairs.size() - 64) / width);
        parallel_for(
            pair_voxels_.size(), progress_,
            [&](std::size_t pair) {
                const std::uint64_t field = read_bits(dag_.pairs, pair * width, width);
                const std::uint64_t leaf = low(field, dag_.leaf_bits), tag = field >> dag_.leaf_bits;
                require(leaf < dag_.leaves.size(), "voxel DAG: pair ", pair, " has leaf ", leaf, " of ",
                        dag_.leaves.size());
                require(tag < cube_element_count, "voxel DAG: pair ", pair, " has tag ", tag, ", which is none");
                require(dag_.leaves[leaf] != 0, "voxel DAG: leaf ", leaf, " is empty");
                pair_voxels_[pair] = static_cast<std::uint8_t>(std::popcount(dag_.leaves[leaf]));
            },
            1 << 14);
    }

    /// Where the last shared record of a level ends.
    [[nodiscard]] std::uint64_t end_of_shared(std::uint32_t level) const {
        for (std::uint32_t above = level + 1; above < dag_.level; ++above)
            if (const auto& directory = dag_.levels[above - smallest_level].directory; !directory.empty())
                return directory.front();
        return dag_.root_bit;
    }
    /// Calls check(rank), which gives the extent of what begins there, and requires that they lie one behind the other.
    template <class Check>
    void check_directory(std::uint32_t level, const Check& check) {
        const std::vector<std::uint32_t>& directory = dag_.levels[level - smallest_level].directory;
        std::atomic<std::uint64_t> record_count = 0;
        parallel_blocks(directory.size(), 256, progress_, [&](std::size_t begin, std::size_t end) {
            std::uint64_t found = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Extent extent = check(i);
                const std::uint64_t due = i + 1 < directory.size() ? directory[i + 1] : end_of_shared(level);
                if (extent.end != due)
                    lies(level, directory[i], "does not end where the next one begins");
                found += extent.records;
            }
            record_count += found;
        });
        record_count_ += record_count;
    }
    void check_smallest_shared() {
        const std::vector<std::uint32_t>& directory = dag_.levels[0].directory;
        const std::uint64_t end = end_of_shared(smallest_level);
        constexpr std::uint32_t step = directory_step(smallest_level);
        smallest_voxels_.resize(step * directory.size());
        std::uint64_t last_count = step;
        if (dag_.level > smallest_level)
            check_directory(smallest_level, [&](std::size_t i) {
                const bool is_last = i + 1 == directory.size();
                Extent all{.in_tree = {}, .end = directory[i], .counts_end = 0, .records = 0};
                for (; all.records < step && !(is_last && all.end == end); ++all.records) {
                    const Extent one = smallest(all.end);
                    smallest_voxels_[step * i + all.records] = static_cast<std::uint16_t>(one.in_tree.voxels);
                    all.end = one.end;
                }
                if (is_last)
                    last_count = all.records;
                return all;
            });
        if (!directory.empty())
            smallest_voxels_.resize(smallest_voxels_.size() - step + last_count);
    }
    void check_shared(std::uint32_t level) {
        const std::vector<std::uint32_t>& directory = dag_.levels[level - smallest_level].directory;
        std::vector<InTree> found(directory.size());
        check_directory(level, [&](std::size_t rank) {
            const std::uint64_t counts_bit =
                order_ != nullptr && level >= counted_level ? order_->directories[level - counted_level][rank] : 0;
            const Extent extent = record(level, directory[rank], counts_bit);
            found[rank] = extent.in_tree;
            return extent;
        });
        shared_.push_back(std::move(found));
    }

    [[nodiscard]] Head head(const RecordTable& table, std::uint32_t level, std::uint64_t bit) const {
        require_there(level, bit, bit);
        const std::uint64_t bits = at(bit);
        const std::uint32_t head = table.heads[bits & 1023], mask = head & 0xff, mask_bits = head >> 8;
        const auto count = static_cast<std::uint32_t>(std::popcount(mask));
        if (count == 0)
            lies(level, bit, "has no children");
        return {.fields = bit + mask_bits + 2 * count,
                .count = count,
                .classes = static_cast<std::uint32_t>(low(bits >> mask_bits, 2 * count))};
    }
    [[nodiscard]] Extent smallest(std::uint64_t bit) const {
        const RecordTable& format = tables_[0];
        const auto [fields, count, classes] = head(format, smallest_level, bit);
        Extent extent{.in_tree = {}, .end = fields};
        for (std::uint32_t i = 0; i < count; ++i) {
            require_there(smallest_level, bit, extent.end);
            const std::uint32_t at_class = classes >> 2 * i & 3, width = format.field_bits[at_class];
            const std::uint64_t pair = format.begins[at_class] + low(at(extent.end), width);
            if (pair >= pair_voxels_.size())
                lies(smallest_level, bit, "names a pair that is not there");
            extent.in_tree.voxels += pair_voxels_[pair];
            extent.end += width;
        }
        require_there(smallest_level, bit, extent.end);
        return extent;
    }
    [[nodiscard]] InTree shared(std::uint32_t level, std::uint32_t record_level, std::uint64_t bit,
                                std::uint64_t rank) const {
        if (level == smallest_level) {
            if (rank < smallest_voxels_.size())
                return {.voxels = smallest_voxels_[rank], .nodes = 0};
        } else if (const auto& known = shared_[level - smallest_level - 1]; rank < known.size()) {
            return known[rank];
        }
        lies(record_level, bit, "names a record that is not there");
    }

    /// Of a record of 16^3 or more.
    [[nodiscard]] Extent record(std::uint32_t level, std::uint64_t bit, std::uint64_t counts_bit) const {
        const RecordTable& format = table(level);
        const auto [fields, count, classes] = head(format, level, bit);
        std::array<Extent, 8> children; // by their order in the record
        std::array<std::uint32_t, 8> inside{};
        std::uint32_t inside_count = 0;
        std::uint64_t end = fields;
        for (std::uint32_t i = 0; i < count; ++i) {
            require_there(level, bit, end);
            const std::uint32_t at_class = classes >> 2 * i & 3;
            if (at_class == 0) {
                inside[inside_count++] = i;
            } else {
                const std::uint64_t rank = format.begins[at_class] + low(at(end), format.rank_bits[at_class]);
                children[i].in_tree = shared(level - 1, level, bit, rank);
                children[i].records = 0;
            }
            end += format.field_bits[at_class];
        }
        require_there(level, bit, end);
        const bool has_counts = order_ != nullptr && level >= counted_level;
        const Counts counts = has_counts ? counts_of(level, bit, counts_bit, count) : Counts{};
        if (level == smallest_level + 1) {
            for (std::uint32_t i = 0; i < inside_count; ++i) {
                children[inside[i]] = smallest(end);
                end = children[inside[i]].end;
            }
        } else {
            end = check_inside(level, bit, end, std::span(inside).first(inside_count), counts, children);
        }
        Extent extent{.in_tree = {.voxels = 0, .nodes = 1}, .end = end, .counts_end = counts.inside};
        for (std::uint32_t i = 0; i < count; ++i) {
            extent.in_tree += children[i].in_tree;
            extent.records += children[i].records;
        }
        if (has_counts)
            extent.counts_end = compare(level, bit, std::span(children).first(count), classes, counts);
        return extent;
    }
    /// Of children that lie inside, of 16^3 or more; returns where they end.
    std::uint64_t check_inside(std::uint32_t level, std::uint64_t bit, std::uint64_t end,
                               std::span<const std::uint32_t> inside, const Counts& counts,
                               std::array<Extent, 8>& children) const {
        if (inside.empty())
            return end;
        std::array<std::uint64_t, 8> begins{end};
        if (inside.size() > 1) {
            constexpr std::uint32_t width_bits = 5;
            const auto width = static_cast<std::uint32_t>(low(at(end), width_bits));
            std::uint64_t length_bit = end + width_bits;
            begins[0] = length_bit + (inside.size() - 1) * width;
            for (std::size_t i = 1; i < inside.size(); ++i, length_bit += width) {
                require_there(level, bit, length_bit);
                begins[i] = begins[i - 1] + low(at(length_bit), width);
            }
        }
        const auto check = [&](std::size_t i) {
            children[inside[i]] = record(level - 1, begins[i], counts.begins[inside[i]]);
            if (i + 1 < inside.size() && children[inside[i]].end != begins[i + 1])
                lies(level, bit, "says wrongly how long those inside are");
        };
        if (level >= least_split_level)
            parallel_for(inside.size(), progress_, check, 1);
        else
            for (std::size_t i = 0; i < inside.size(); ++i)
                check(i);
        return children[inside.back()].end;
    }

    [[nodiscard]] Counts counts_of(std::uint32_t level, std::uint64_t bit, std::uint64_t counts_bit,
                                   std::uint32_t count) const {
        const std::size_t field_count = level == counted_level ? 1 : 3;
        constexpr std::uint32_t width_bits = 6;
        std::array<std::uint32_t, 3> widths{};
        Counts counts;
        counts.inside = counts_bit;
        const auto field = [&](std::uint32_t width) {
            if (counts.inside > past_counts_ || width > most_field_bits)
                lies(level, bit, "has counts that are not there");
            counts.inside += width;
            return read_bits(order_->counts, counts.inside - width, width);
        };
        if (count > 1)
            for (std::size_t i = 0; i < field_count; ++i)
                widths[i] = static_cast<std::uint32_t>(field(width_bits));
        std::uint64_t bits = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            counts.begins[i] = bits;
            if (i + 1 == count)
                break;
            counts.children[i].voxels = field(widths[0]);
            counts.children[i].nodes = level == counted_level ? 1 : field(widths[1]);
            bits += field(widths[2]);
        }
        for (std::uint64_t& begin : counts.begins)
            begin += counts.inside;
        return counts;
    }
    /// Returns where the counts end.
    [[nodiscard]] static std::uint64_t compare(std::uint32_t level, std::uint64_t bit, std::span<const Extent> children,
                                               std::uint32_t classes, const Counts& counts) {
        std::uint64_t end = counts.inside;
        for (std::size_t i = 0; i < children.size(); ++i) {
            if (counts.begins[i] != end)
                lies(level, bit, "says wrongly where the counts of those inside are");
            if (level > counted_level && (classes >> 2 * i & 3) == 0)
                end = children[i].counts_end;
            if (i + 1 < children.size() && (counts.children[i].voxels != children[i].in_tree.voxels ||
                                            counts.children[i].nodes != children[i].in_tree.nodes))
                lies(level, bit, "has wrong counts of voxels or nodes");
        }
        return end;
    }

    const PackedDag& dag_;
    const StoredOrder* order_;
    const Progress& progress_;
    std::uint64_t past_, past_counts_; ///< Bits up to which fields may be read.
    std::vector<RecordTable> tables_;  ///< By level from 8^3 on.
    std::vector<std::uint8_t> pair_voxels_;
    std::vector<std::uint16_t> smallest_voxels_; ///< Of shared records of 8^3.
    std::vector<std::vector<InTree>> shared_;    ///< By level from 16^3 on, and rank.
    std::uint64_t record_count_ = 0;
};
} // namespace

void require_sound(const PackedDag& dag, const StoredOrder* order, const Progress& progress) {
    if (dag.is_empty())
        require(dag.voxel_count == 0 && dag.node_count == 0, "voxel DAG: ", dag.voxel_count, " voxels without a leaf");
    else
        Checking(dag, order, progress).run();
}
} // namespace tyndall::voxel_dag
