// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_bricks.hpp"
#include <bit>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "voxel_dag/tile_bricks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TYNDALL_TILE_BRICKS_ORDER
#define TYNDALL_TILE_BRICKS_ORDER
namespace tyndall::voxel_dag {
/// How bits move. A bit's index in a brick is z1 y1 x1 z0 y0 x0; in a tile's word, the six bits of the run's index,
/// and bits 8 to 11 of the word's place are the lowest two bits of either other axis.
struct BrickOrder {
    std::uint32_t lower, upper;                 ///< The axes that are not the run's.
    std::array<std::pair<int, int>, 2> swaps{}; ///< Of index bits in a word: the run's lowest two go home.
    std::array<int, 4> home;                    ///< Where bits 8, 9, 10, 11 of a word's place go.
    std::array<std::uint16_t, 16>
        code_of_vector{}; ///< Parts of a brick's code: by bits 8 to 11 of the place, in the end,
    std::array<std::uint16_t, 256> code_of_block{}; ///< and by bits 0 to 7.

    constexpr explicit BrickOrder(std::uint32_t run)
        : lower(run == 0 ? 1 : 0), upper(run == 2 ? 1 : 2), home{static_cast<int>(lower), static_cast<int>(lower) + 3,
                                                                 static_cast<int>(upper), static_cast<int>(upper) + 3} {
        const int axis = static_cast<int>(run);
        swaps = axis == 0   ? std::array<std::pair<int, int>, 2>{{{0, 0}, {1, 3}}}
                : axis == 1 ? std::array<std::pair<int, int>, 2>{{{0, 1}, {0, 4}}}
                            : std::array<std::pair<int, int>, 2>{{{0, 2}, {1, 5}}};
        std::array<int, 6> run_bit{0, 1, 2, 3, 4, 5};
        for (const auto& [a, b] : swaps)
            std::swap(run_bit[static_cast<std::size_t>(a)], run_bit[static_cast<std::size_t>(b)]);
        for (std::uint32_t vector = 0; vector < 16; ++vector) {
            std::uint32_t at = 0;
            for (std::size_t bit = 0; bit < 4; ++bit)
                at |= (vector >> bit & 1) << (run_bit[static_cast<std::size_t>(home[bit])] - 2);
            code_of_vector[vector] = static_cast<std::uint16_t>(spread_bits(at) << run);
        }
        for (std::uint32_t block = 0; block < 256; ++block)
            code_of_block[block] =
                static_cast<std::uint16_t>(spread_bits(block & 15) << lower | spread_bits(block >> 4) << upper);
    }
};
inline constexpr std::array<BrickOrder, 3> brick_orders{BrickOrder(0), BrickOrder(1), BrickOrder(2)};
/// The bits of a word whose index has a 0 at `position`.
[[nodiscard]] constexpr std::uint64_t low_half(int position) {
    std::uint64_t bits = 0;
    for (int bit = 0; bit < 64; ++bit)
        bits |= std::uint64_t{(bit >> position & 1) == 0} << bit;
    return bits;
}
} // namespace tyndall::voxel_dag
#endif

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Words = hn::CappedTag<std::uint64_t, 8>;
static constexpr Words d;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<Words>;

/// Bits a and b > a of each bit's index change places, in all words of a vector.
template <int a, int b>
static HWY_INLINE V with_swapped(V word) {
    if constexpr (a == b)
        return word;
    else {
        constexpr int distance = (1 << b) - (1 << a);
        constexpr std::uint64_t moved = ~low_half(a) & low_half(b);
        const V change = hn::And(hn::Xor(word, hn::ShiftRight<distance>(word)), hn::Set(d, moved));
        return hn::Xor(word, hn::Xor(change, hn::ShiftLeft<distance>(change)));
    }
}
/// Which of two words a bit is in, and bit `position` of its index, change places.
template <int position>
static HWY_INLINE void swap_between(V& low, V& high) {
    const V change = hn::And(hn::Xor(hn::ShiftRight<(1 << position)>(low), high), hn::Set(d, low_half(position)));
    high = hn::Xor(high, change);
    low = hn::Xor(low, hn::ShiftLeft<(1 << position)>(change));
}
template <std::size_t bit, int position>
static HWY_INLINE void swap_vectors(V (&vectors)[16]) {
    for (std::size_t vector = 0; vector < 16; ++vector)
        if ((vector >> bit & 1) == 0)
            swap_between<position>(vectors[vector], vectors[vector | std::size_t{1} << bit]);
}

template <std::size_t run>
static void take(TileBits& bits, Bricks& bricks) {
    static constexpr const BrickOrder& order = brick_orders[run];
    static constexpr std::pair<int, int> first_swap = order.swaps[0], second_swap = order.swaps[1];
    bricks.is_full = {};
    for (std::size_t block = 0; block < 256; block += lanes) {
        V vectors[16];
        V any = hn::Zero(d);
        for (std::size_t vector = 0; vector < 16; ++vector) {
            vectors[vector] = hn::Load(d, bits.words.data() + vector * 256 + block);
            any = hn::Or(any, vectors[vector]);
        }
        if (hn::AllTrue(d, hn::Eq(any, hn::Zero(d))))
            continue;
        for (V& vector : vectors)
            vector = with_swapped<second_swap.first, second_swap.second>(
                with_swapped<first_swap.first, first_swap.second>(vector));
        swap_vectors<0, order.home[0]>(vectors);
        swap_vectors<1, order.home[1]>(vectors);
        swap_vectors<2, order.home[2]>(vectors);
        swap_vectors<3, order.home[3]>(vectors);
        for (std::size_t vector = 0; vector < 16; ++vector) {
            std::uint8_t full_lanes[8] = {};
            hn::StoreMaskBits(d, hn::Ne(vectors[vector], hn::Zero(d)), full_lanes);
            if (full_lanes[0] == 0)
                continue;
            alignas(64) std::uint64_t masks[lanes];
            hn::Store(vectors[vector], d, masks);
            for (std::uint32_t full = full_lanes[0]; full != 0; full &= full - 1) {
                const auto lane = static_cast<std::size_t>(std::countr_zero(full));
                const std::size_t code = order.code_of_vector[vector] | order.code_of_block[block + lane];
                bricks.masks[code] = masks[lane];
                bricks.is_full[code / 64] |= std::uint64_t{1} << code % 64;
            }
        }
    }
    bits.words.fill(0);
}

static void take_by_axis(TileBits& bits, std::uint32_t run, Bricks& bricks) {
    if (run == 0)
        take<0>(bits, bricks);
    else if (run == 1)
        take<1>(bits, bricks);
    else
        take<2>(bits, bricks);
}
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::voxel_dag {
HWY_EXPORT(take_by_axis);
void take_bricks(TileBits& bits, const ScanAxes& axes, Bricks& bricks) {
    HWY_DYNAMIC_DISPATCH(take_by_axis)(bits, axes.run, bricks);
}
} // namespace tyndall::voxel_dag
#endif
