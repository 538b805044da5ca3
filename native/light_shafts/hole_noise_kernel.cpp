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
static HWY_INLINE Along along(V coordinate, std::uint32_t factor) {
    Along a;
    const V cell = hn::Floor(coordinate), t = hn::Sub(coordinate, cell);
    a.from[0] = t;
    a.from[1] = hn::Sub(t, set(1.0f));
    // Beside 1.5 * 2^23 a float's last bits count whole numbers.
    a.key[0] = hn::Mul(hn::BitCast(du, hn::Add(cell, set(12582912.0f))), hn::Set(du, factor));
    a.key[1] = hn::Add(a.key[0], hn::Set(du, factor));
    const V slope = hn::MulAdd(hn::MulSub(t, set(6.0f), set(15.0f)), t, set(10.0f));
    a.fade = hn::Mul(hn::Mul(t, t), hn::Mul(t, slope));
    return a;
}
static HWY_INLINE V between(V a, V b, V fade) { return hn::MulAdd(fade, hn::Sub(b, a), a); }
/// Random bits of a corner. Neighbours' are uncorrelated to 5e-3, the noise of measuring 1024^2 of them.
static HWY_INLINE U mixed(U key) { return hn::Mul(key, hn::ShiftRight<15>(key)); }

template <bool turns>
static HWY_INLINE V gradient_2d(const Along& x, const Along& y, std::size_t i, std::size_t j, V cos_turn, V sin_turn) {
    const U bits = mixed(hn::Xor(x.key[i], y.key[j]));
    const V gx = signed_value_of(bits), gy = signed_value_of(hn::ShiftLeft<16>(bits));
    if constexpr (!turns)
        return hn::MulAdd(gx, x.from[i], hn::Mul(gy, y.from[j]));
    else {
        const V along_gradient = hn::MulAdd(gx, x.from[i], hn::Mul(gy, y.from[j]));
        const V across = hn::MulSub(gx, y.from[j], hn::Mul(gy, x.from[i]));
        return hn::MulAdd(along_gradient, cos_turn, hn::Mul(across, sin_turn));
    }
}

template <bool turns>
static HWY_INLINE V gradient_3d(const Along& x, const Along& y, const Along& z, std::size_t i, std::size_t j,
                                std::size_t k, V cos_turn, V sin_turn) {
    const auto dot = [&](U bits) {
        const V gx = signed_value_of(bits), gy = signed_value_of(hn::ShiftLeft<11>(bits)),
                gz = signed_value_of(hn::ShiftLeft<22>(bits));
        return hn::MulAdd(gx, x.from[i], hn::MulAdd(gy, y.from[j], hn::Mul(gz, z.from[k])));
    };
    U bits = mixed(hn::Xor(hn::Xor(x.key[i], y.key[j]), z.key[k]));
    bits = hn::Xor(bits, hn::ShiftRight<15>(bits)); // the last bits of a product are not random enough
    if constexpr (!turns)
        return dot(bits);
    else { // around an axis of the corner's own, on an ellipse: two gradients that know nothing of one another
        U more = hn::Mul(bits, hn::Set(du, 0x9E3779B1u));
        more = hn::Xor(more, hn::ShiftRight<15>(more));
        return hn::MulAdd(dot(bits), cos_turn, hn::Mul(dot(more), sin_turn));
    }
}

template <std::size_t dimensions, bool turns>
static HWY_INLINE V octave_at(const Octave& octave, const V* point, V cos_turn, V sin_turn) {
    const auto coordinate = [&](std::size_t axis) {
        V sum = set(octave.offset[axis]);
        for (std::size_t c = 0; c < dimensions; ++c)
            sum = hn::MulAdd(set(octave.cell_per_m[axis][c]), point[c], sum);
        return sum;
    };
    const Along x = along(coordinate(0), 0x9E3779B1u);
    Along y = along(coordinate(1), 0x85EBCA77u);
    for (U& key : y.key)
        key = hn::Xor(key, hn::Set(du, octave.seed));
    if constexpr (dimensions == 2) {
        const auto row = [&](std::size_t j) {
            return between(gradient_2d<turns>(x, y, 0, j, cos_turn, sin_turn),
                           gradient_2d<turns>(x, y, 1, j, cos_turn, sin_turn), x.fade);
        };
        return between(row(0), row(1), y.fade);
    } else {
        const Along z = along(coordinate(2), 0xC2B2AE3Du);
        const auto row = [&](std::size_t j, std::size_t k) {
            return between(gradient_3d<turns>(x, y, z, 0, j, k, cos_turn, sin_turn),
                           gradient_3d<turns>(x, y, z, 1, j, k, cos_turn, sin_turn), x.fade);
        };
        const auto layer = [&](std::size_t k) { return between(row(0, k), row(1, k), y.fade); };
        return between(layer(0), layer(1), z.fade);
    }
}

// To stop where no octave that is left lifts a point over the threshold would spare one octave in five, and cost as much
// in branches that the CPU does not foresee.
template <std::size_t dimensions>
static HWY_INLINE V noise_at(const Lookup& lookup, const Points& points, std::size_t first) {
    V point[dimensions];
    alignas(64) std::array<float, 16> last; // points of a vector that is not full; those which lack are at 0
    const std::size_t count = points.count - first;
    for (std::size_t c = 0; c < dimensions; ++c) {
        if (count >= hn::Lanes(d)) {
            point[c] = hn::LoadU(d, points.columns[c] + first);
        } else {
            last.fill(0.0f);
            std::copy_n(points.columns[c] + first, count, last.begin());
            point[c] = hn::Load(d, last.data());
        }
    }
    const V one = set(1.0f), none = hn::Zero(d);
    if (!lookup.mover.empty()) {
        V moved = none;
        for (const Octave& octave : lookup.mover)
            moved = hn::MulAdd(octave_at<dimensions, true>(octave, point, set(lookup.cos_turn), set(lookup.sin_turn)),
                               set(octave.amplitude), moved);
        for (std::size_t c = 0; c < dimensions; ++c)
            point[c] = hn::MulAdd(moved, set(lookup.move_m[c]), point[c]);
    }
    V sum = none;
    for (const Octave& octave : lookup.octaves)
        sum = hn::MulAdd(octave_at<dimensions, false>(octave, point, one, none), set(octave.amplitude), sum);
    return sum;
}

template <std::size_t dimensions>
static void values_of_dimensions(const Lookup& lookup, const Points& points, float* values) {
    for (std::size_t i = 0; i < points.count; i += hn::Lanes(d)) {
        alignas(64) std::array<float, 16> some;
        hn::Store(noise_at<dimensions>(lookup, points, i), d, some.data());
        std::copy_n(some.begin(), std::min(hn::Lanes(d), points.count - i), values + i);
    }
}
void values_of(const Lookup& lookup, const Points& points, float* values) {
    if (points.dimensions == 2)
        values_of_dimensions<2>(lookup, points, values);
    else
        values_of_dimensions<3>(lookup, points, values);
}

template <std::size_t dimensions>
static void holes_of_dimensions(const Lookup& lookup, const Points& points, std::uint8_t* is_hole) {
    for (std::size_t i = 0; i < points.count; i += hn::Lanes(d)) {
        const auto below = hn::Lt(noise_at<dimensions>(lookup, points, i), set(lookup.threshold));
        const auto ones = hn::IfThenElseZero(hn::RebindMask(di, below), hn::Set(di, 1));
        alignas(64) std::array<std::uint8_t, 16> some;
        hn::StoreU(hn::DemoteTo(d_byte, ones), d_byte, some.data());
        std::copy_n(some.begin(), std::min(hn::Lanes(d), points.count - i), is_hole + i);
    }
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
