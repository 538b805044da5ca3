// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/hole_noise_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/hole_noise_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::hole_noise::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
static constexpr hn::RebindToUnsigned<Tag> du;
static constexpr hn::Rebind<std::uint8_t, Tag> d_byte;
using U = hn::Vec<decltype(du)>;

static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V signed_value_of(U bits) { return hn::ConvertTo(d, hn::BitCast(di, bits)); }

/// Where a point lies between two corners of the lattice, along one axis.
struct Along {
    V from[2]; ///< Distance from the lower, and from the upper corner.
    U key[2];  ///< Numbers of the two.
    V fade;
};
/// `coordinate` is counted from the middle of the lattice's first cell.
static HWY_INLINE Along along(V coordinate, std::uint32_t factor) {
    // Beside 1.5 * 2^23 a float's last bits count whole numbers: the nearest middle of a cell. Half way to the next one it
    // may be either, and the noise is the same.
    const V magic = set(12582912.0f), counted = hn::Add(coordinate, magic);
    const V t = hn::Sub(coordinate, hn::Sub(counted, magic)), square = hn::Mul(t, t);
    Along a;
    a.from[0] = hn::Add(t, set(0.5f));
    a.from[1] = hn::Sub(t, set(0.5f));
    a.key[0] = hn::Mul(hn::BitCast(du, counted), hn::Set(du, factor));
    a.key[1] = hn::Add(a.key[0], hn::Set(du, factor));
    // Perlin's 6 x^5 - 15 x^4 + 10 x^3 with x = t + 1/2.
    a.fade = hn::MulAdd(hn::MulAdd(hn::MulSub(square, set(6.0f), set(5.0f)), square, set(1.875f)), t, set(0.5f));
    return a;
}
static HWY_INLINE V between(V a, V b, V fade) { return hn::MulAdd(fade, hn::Sub(b, a), a); }
/// Random bits of a corner. Neighbours' are uncorrelated to 5e-3, the noise of measuring 1024^2 of them.
static HWY_INLINE U mixed(U key) { return hn::Mul(key, hn::ShiftRight<15>(key)); }

/// What all octaves and corners share.
struct Turn {
    V cos, sin;
};

/// The 4 corners' gradients times the way from there. A gradient that turns is a way that turns back.
template <bool turns>
static HWY_INLINE V faded_2d(const Along& x, const Along& y, U seed, const Turn& turn) {
    V dx[2][2], dy[2][2];
    if constexpr (turns) {
        dx[0][0] = hn::MulAdd(x.from[0], turn.cos, hn::Mul(y.from[0], turn.sin));
        dy[0][0] = hn::MulSub(y.from[0], turn.cos, hn::Mul(x.from[0], turn.sin));
        for (std::size_t j = 0; j < 2; ++j) {
            if (j == 1)
                dx[0][1] = hn::Sub(dx[0][0], turn.sin), dy[0][1] = hn::Sub(dy[0][0], turn.cos);
            dx[1][j] = hn::Sub(dx[0][j], turn.cos), dy[1][j] = hn::Add(dy[0][j], turn.sin);
        }
    } else {
        for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t j = 0; j < 2; ++j)
                dx[i][j] = x.from[i], dy[i][j] = y.from[j];
    }
    const auto corner = [&](std::size_t i, std::size_t j) {
        const U bits = mixed(hn::Xor3(x.key[i], y.key[j], seed));
        const V gx = signed_value_of(bits), gy = signed_value_of(hn::ShiftLeft<16>(bits));
        return hn::MulAdd(gx, dx[i][j], hn::Mul(gy, dy[i][j]));
    };
    return between(between(corner(0, 0), corner(1, 0), x.fade), between(corner(0, 1), corner(1, 1), x.fade), y.fade);
}

template <bool turns>
static HWY_INLINE V faded_3d(const Along& x, const Along& y, const Along& z, U seed, const Turn& turn) {
    const auto corner = [&](std::size_t i, std::size_t j, std::size_t k) {
        const auto dot = [&](U bits) {
            const V gx = signed_value_of(bits), gy = signed_value_of(hn::ShiftLeft<11>(bits)),
                    gz = signed_value_of(hn::ShiftLeft<22>(bits));
            return hn::MulAdd(gx, x.from[i], hn::MulAdd(gy, y.from[j], hn::Mul(gz, z.from[k])));
        };
        U bits = mixed(hn::Xor3(x.key[i], y.key[j], hn::Xor(z.key[k], seed)));
        bits = hn::Xor(bits, hn::ShiftRight<15>(bits)); // the last bits of a product are not random enough
        if constexpr (!turns)
            return dot(bits);
        else { // around an axis of the corner's own, on an ellipse: two gradients that know nothing of one another
            U more = hn::Mul(bits, hn::Set(du, 0x9E3779B1u));
            more = hn::Xor(more, hn::ShiftRight<15>(more));
            return hn::MulAdd(dot(bits), turn.cos, hn::Mul(dot(more), turn.sin));
        }
    };
    const auto layer = [&](std::size_t k) {
        return between(between(corner(0, 0, k), corner(1, 0, k), x.fade),
                       between(corner(0, 1, k), corner(1, 1, k), x.fade), y.fade);
    };
    return between(layer(0), layer(1), z.fade);
}

template <std::size_t dimensions, bool turns>
static HWY_INLINE V octave_at(const Octave& octave, const V* point, const Turn& turn) {
    const auto coordinate = [&](std::size_t axis) {
        V sum = set(octave.offset[axis] - 0.5f);
        for (std::size_t c = 0; c < dimensions; ++c)
            sum = hn::MulAdd(set(octave.cell_per_m[axis][c]), point[c], sum);
        return sum;
    };
    const U seed = hn::Set(du, octave.seed);
    const Along x = along(coordinate(0), 0x9E3779B1u), y = along(coordinate(1), 0x85EBCA77u);
    if constexpr (dimensions == 2)
        return faded_2d<turns>(x, y, seed, turn);
    else
        return faded_3d<turns>(x, y, along(coordinate(2), 0xC2B2AE3Du), seed, turn);
}

/// Points that go through one octave after the other: the work on one is a long chain, on its neighbours another.
struct Chunk {
    static constexpr std::size_t capacity = 512; ///< All of it stays in the first cache.
    alignas(64) float columns[3][capacity + 16];
    alignas(64) float sum[capacity + 16];
    std::array<std::uint32_t, capacity> open; ///< Where vectors of points begin that the next octave is asked for.
    std::size_t count = 0, open_count = 0;    ///< Of points: what fills up the last vector is anywhere. Of vectors.
};
template <std::size_t dimensions>
static void load(const Points& points, std::size_t first, Chunk& chunk) {
    chunk.count = std::min(points.count - first, Chunk::capacity);
    for (std::size_t c = 0; c < dimensions; ++c)
        std::fill_n(std::copy_n(points.columns[c] + first, chunk.count, chunk.columns[c]), 16, 0.0f);
}
static void open_all(Chunk& chunk) {
    chunk.open_count = 0;
    for (std::size_t i = 0; i < chunk.count; i += hn::Lanes(d)) {
        hn::Store(hn::Zero(d), d, chunk.sum + i);
        chunk.open[chunk.open_count++] = static_cast<std::uint32_t>(i);
    }
}

/// `closes`: vectors whose points are all farther from the threshold than finer octaves reach are asked for no more.
template <std::size_t dimensions, bool turns, bool closes>
static void add_octave(const Lookup& lookup, const Octave& octave, Chunk& chunk) {
    const Turn turn{set(lookup.cos_turn), set(lookup.sin_turn)};
    const V amplitude = set(octave.amplitude), threshold = set(lookup.threshold), reach = set(octave.finer_reach);
    std::size_t still_open = 0;
    for (std::size_t n = 0; n < chunk.open_count; ++n) {
        const std::uint32_t i = chunk.open[n];
        V point[dimensions];
        for (std::size_t c = 0; c < dimensions; ++c)
            point[c] = hn::Load(d, chunk.columns[c] + i);
        const V sum =
            hn::MulAdd(octave_at<dimensions, turns>(octave, point, turn), amplitude, hn::Load(d, chunk.sum + i));
        hn::Store(sum, d, chunk.sum + i);
        if constexpr (closes) { // without a branch, which the CPU would not foresee
            chunk.open[still_open] = i;
            still_open += !hn::AllTrue(d, hn::Gt(hn::Abs(hn::Sub(sum, threshold)), reach));
        }
    }
    if constexpr (closes)
        chunk.open_count = still_open;
}

template <std::size_t dimensions>
static void move_points(const Lookup& lookup, Chunk& chunk) {
    if (lookup.mover.empty())
        return;
    open_all(chunk);
    for (const Octave& octave : lookup.mover)
        add_octave<dimensions, true, false>(lookup, octave, chunk);
    for (std::size_t c = 0; c < dimensions; ++c)
        for (std::size_t i = 0; i < chunk.count; i += hn::Lanes(d)) {
            float* at = chunk.columns[c] + i;
            hn::Store(hn::MulAdd(hn::Load(d, chunk.sum + i), set(lookup.move_m[c]), hn::Load(d, at)), d, at);
        }
}

/// use(first, chunk) for chunks of points, whose sums are the noise; with `closes` only which side of the threshold.
template <std::size_t dimensions, bool closes, typename Use>
static void for_each_chunk(const Lookup& lookup, const Points& points, const Use& use) {
    // Sooner few points are decided, and later there is little left to spare.
    const float reach_of_all = lookup.octaves.front().finer_reach + lookup.octaves.front().reach;
    Chunk chunk;
    for (std::size_t first = 0; first < points.count; first += chunk.count) {
        load<dimensions>(points, first, chunk);
        move_points<dimensions>(lookup, chunk);
        open_all(chunk);
        for (const Octave& octave : lookup.octaves) {
            const bool is_worth_it = closes && octave.finer_reach < 0.125f * reach_of_all && octave.finer_reach > 0.0f;
            if (is_worth_it)
                add_octave<dimensions, false, true>(lookup, octave, chunk);
            else
                add_octave<dimensions, false, false>(lookup, octave, chunk);
        }
        use(first, chunk);
    }
}

template <std::size_t dimensions>
static void values_of_dimensions(const Lookup& lookup, const Points& points, float* values) {
    for_each_chunk<dimensions, false>(lookup, points, [&](std::size_t first, const Chunk& chunk) {
        std::copy_n(chunk.sum, chunk.count, values + first);
    });
}
void values_of(const Lookup& lookup, const Points& points, float* values) {
    if (points.dimensions == 2)
        values_of_dimensions<2>(lookup, points, values);
    else
        values_of_dimensions<3>(lookup, points, values);
}

template <std::size_t dimensions>
static void holes_of_dimensions(const Lookup& lookup, const Points& points, std::uint8_t* is_hole) {
    for_each_chunk<dimensions, true>(lookup, points, [&](std::size_t first, const Chunk& chunk) {
        for (std::size_t i = 0; i < chunk.count; i += hn::Lanes(d)) {
            const auto below = hn::Lt(hn::Load(d, chunk.sum + i), set(lookup.threshold));
            const auto ones = hn::IfThenElseZero(hn::RebindMask(di, below), hn::Set(di, 1));
            alignas(64) std::array<std::uint8_t, 16> some;
            hn::StoreU(hn::DemoteTo(d_byte, ones), d_byte, some.data());
            std::copy_n(some.begin(), std::min(hn::Lanes(d), chunk.count - i), is_hole + first + i);
        }
    });
}
void holes_of(const Lookup& lookup, const Points& points, std::uint8_t* is_hole) {
    if (points.dimensions == 2)
        holes_of_dimensions<2>(lookup, points, is_hole);
    else
        holes_of_dimensions<3>(lookup, points, is_hole);
}
} // namespace tyndall::light_shafts::hole_noise::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts::hole_noise {
HWY_EXPORT(values_of);
HWY_EXPORT(holes_of);

void values_at(const Lookup& lookup, const Points& points, float* values) {
    HWY_DYNAMIC_DISPATCH(values_of)(lookup, points, values);
}
void holes_at(const Lookup& lookup, const Points& points, std::uint8_t* is_hole) {
    HWY_DYNAMIC_DISPATCH(holes_of)(lookup, points, is_hole);
}
} // namespace tyndall::light_shafts::hole_noise
#endif
