// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/palette_blocks.hpp"
#include "core/errors.hpp"
#include "voxel_dag/bit_packing.hpp"
#include "voxel_dag/value_runs.hpp"
#include <algorithm>

namespace tyndall::voxel_dag::palette_blocks {
namespace {
__extension__ using Wide = unsigned __int128; // products of lengths and bits, which 64 do not hold

constexpr std::uint32_t first_phase_widths = 4; // Algorithm 1, line 4
constexpr std::uint32_t most_index_bits = 8;    // line 18

/// Consecutive runs [begin, end).
struct Stretch {
    std::uint32_t begin, end;
};

class Partition {
public:
    Partition(const ValueRuns& runs, std::uint32_t material_count, const Config& config, const Progress& progress)
        : runs_(runs), progress_(progress), material_bits_(bits_for(material_count)),
          directory_bits_(config.directory_entry_bits) {}

    std::vector<Block> blocks() {
        std::vector<Stretch> left{{0, runs_.size()}};
        for (std::uint32_t bits = 0; bits < first_phase_widths; ++bits)
            left = cut_out_large_blocks(left, bits);
        for (const Stretch& stretch : left)
            add_remaining_blocks(stretch);
        std::ranges::sort(blocks_, {}, &Block::begin);
        return std::move(blocks_);
    }

private:
    /// MEMORY() less the indices: line 28.
    std::uint64_t fixed_bits(std::uint32_t bits) const {
        return (std::uint64_t{1} << bits) * material_bits_ + directory_bits_;
    }
    bool is_large(const Stretch& window, std::uint32_t bits) const { // line 7
        return runs_.entries(window.begin, window.end) > fixed_bits(bits);
    }
    void add(const Stretch& block, std::uint32_t bits) {
        blocks_.push_back({runs_.starts[block.begin], runs_.entries(block.begin, block.end), bits});
    }

    std::vector<Stretch> cut_out_large_blocks(const std::vector<Stretch>& stretches, std::uint32_t bits) {
        std::vector<Stretch> left;
        for (const Stretch& stretch : stretches) {
            progress_.poll();
            find_large_windows(stretch, bits);
            taken_.clear();
            if (bits == 0)
                taken_ = windows_; // runs do not overlap
            else
                take_longest_first(bits);
            std::uint32_t begin = stretch.begin;
            for (const Stretch& block : taken_) {
                add(block, bits);
                if (begin < block.begin)
                    left.push_back({begin, block.begin});
                begin = block.end;
            }
            if (begin < stretch.end)
                left.push_back({begin, stretch.end});
        }
        return left;
    }

    /// All that cannot be extended without a value too many, in their order, if they are large enough.
    void find_large_windows(const Stretch& stretch, std::uint32_t bits) {
        windows_.clear();
        const auto found = [&](const Stretch& window) {
            if (is_large(window, bits))
                windows_.push_back(window);
        };
        const std::uint32_t most = 1u << bits;
        std::uint32_t begin = stretch.begin, distinct = 0;
        for (std::uint32_t run = stretch.begin; run < stretch.end; ++run) {
            if (runs_.previous[run] > begin)
                continue; // its value is in the window
            if (distinct == most) {
                found({begin, run});
                while (runs_.next[begin] <= run)
                    ++begin;
                ++begin; // the last run of a value: one less
            } else {
                ++distinct;
            }
        }
        found({begin, stretch.end});
    }

    /// Windows begin and end in one order, and no block lies inside a window that is longer: a block cuts its neighbours'
    /// ends, and each end of a window is cut once.
    void take_longest_first(std::uint32_t bits) {
        const auto entries = [&](std::uint32_t window) {
            return runs_.entries(windows_[window].begin, windows_[window].end);
        };
        // Longest first, then the first; what is left of a cut window keeps its place in that order.
        const auto key = [&](std::uint32_t window) { return std::uint64_t{entries(window)} << 32 | ~window; };
        heap_.clear();
        for (std::uint32_t window = 0; window < windows_.size(); ++window)
            heap_.push_back(key(window));
        std::ranges::make_heap(heap_);
        while (!heap_.empty()) {
            std::ranges::pop_heap(heap_);
            const std::uint64_t top = heap_.back();
            heap_.pop_back();
            const auto window = ~static_cast<std::uint32_t>(top);
            if (entries(window) != top >> 32) {
                if (is_large(windows_[window], bits)) {
                    heap_.push_back(key(window));
                    std::ranges::push_heap(heap_);
                }
                continue;
            }
            const Stretch block = windows_[window];
            taken_.push_back(block);
            for (std::uint32_t other = window; other-- > 0 && windows_[other].end > block.begin;)
                windows_[other].end = block.begin;
            for (std::uint32_t other = window + 1; other < windows_.size() && windows_[other].begin < block.end;
                 ++other)
                windows_[other].begin = block.end;
        }
        std::ranges::sort(taken_, {}, &Stretch::begin);
    }

    void add_remaining_blocks(const Stretch& stretch) {
        for (std::uint32_t begin = stretch.begin; begin < stretch.end;) {
            progress_.poll();
            const auto [block, bits] = cheapest_block(begin, stretch.end);
            add(block, bits);
            begin = block.end;
        }
    }
    struct Sized {
        Stretch block;
        std::uint32_t bits;
    };
    /// Of the blocks from `begin` on with 2^0, 2^1, ... 2^8 values, the one with the fewest bits per entry: lines 18 to 23.
    Sized cheapest_block(std::uint32_t begin, std::uint32_t end) const {
        Sized best{};
        Wide best_memory = 0, best_entries = 0; // 0: none yet
        std::uint32_t bits = 0, distinct = 0;
        const auto close = [&](std::uint32_t block_end) {
            const Wide entries = runs_.entries(begin, block_end), memory = entries * bits + fixed_bits(bits);
            if (best_entries == 0 || memory * best_entries < best_memory * entries) {
                best = {{begin, block_end}, bits};
                best_memory = memory, best_entries = entries;
            }
            ++bits;
            // Wider indices alone cost as much as the best block with its palette.
            return bits > most_index_bits || best_memory <= bits * best_entries;
        };
        for (std::uint32_t run = begin; run < end; ++run) {
            if (runs_.previous[run] > begin)
                continue;
            if (distinct == 1u << bits && close(run))
                return best;
            ++distinct;
        }
        close(end); // all wider ones end here, too, and cost more
        return best;
    }

    const ValueRuns& runs_;
    const Progress& progress_;
    const std::uint64_t material_bits_, directory_bits_;
    std::vector<Block> blocks_;
    std::vector<Stretch> windows_, taken_; // of the stretch at work
    std::vector<std::uint64_t> heap_;
};
} // namespace

std::vector<Block> partition(std::span<const std::uint32_t> indices, std::uint32_t material_count, const Config& config,
                             const Progress& progress) {
    require(config.directory_entry_bits <= 1024, "directory_entry_bits is ", config.directory_entry_bits,
            ", outside [0, 1024]");
    if (indices.empty())
        return {};
    const ValueRuns runs = value_runs_of(indices, material_count, progress);
    return Partition(runs, material_count, config, progress).blocks();
}
} // namespace tyndall::voxel_dag::palette_blocks
