// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strand_bands_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/strand_bands_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace bands {
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static constexpr std::size_t count = StrandBands::pieces_per_block;

/// From the middle of each ring to a corner of the band, a vector of rings more than a block has.
struct Sides {
    using Column = std::array<float, count + 16>;
    alignas(64) std::array<Column, 3> axes;
};

/// a b - c e, each product rounded: a target that fuses them would have other bits.
static HWY_INLINE V difference(V a, V b, V c, V e) { return hn::Sub(hn::Mul(a, b), hn::Mul(c, e)); }

static HWY_INLINE void find_sides(const RingColumns& rings, const LightPlace& light, Sides& sides) {
    const V zero = hn::Zero(d), of_place = hn::Set(d, light.is_directional ? 0.0f : 1.0f);
    for (std::size_t i = 0; i <= count; i += hn::Lanes(d)) {
        const V radius = hn::LoadU(d, rings.radius + i);
        const auto begins = hn::Lt(radius, zero), ends = hn::Lt(hn::LoadU(d, rings.radius + i + 1), zero);
        const auto along = [&](const float* centre) { // the strand, at its ends to its one neighbour
            const V here = hn::LoadU(d, centre + i);
            return hn::Sub(hn::IfThenElse(ends, here, hn::LoadU(d, centre + i + 1)),
                           hn::IfThenElse(begins, here, hn::LoadU(d, centre + i - 1)));
        };
        const auto to_light = [&](float at, const float* centre) {
            return hn::Sub(hn::Set(d, at), hn::Mul(of_place, hn::LoadU(d, centre + i)));
        };
        const V tx = along(rings.x), ty = along(rings.y), tz = along(rings.z);
        const V lx = to_light(light.at.x, rings.x), ly = to_light(light.at.y, rings.y),
                lz = to_light(light.at.z, rings.z);
        const V cx = difference(ty, lz, tz, ly), cy = difference(tz, lx, tx, lz), cz = difference(tx, ly, ty, lx);
        const V square = hn::Add(hn::Add(hn::Mul(cx, cx), hn::Mul(cy, cy)), hn::Mul(cz, cz));
        const V scale = hn::Div(hn::Abs(radius), hn::Sqrt(hn::Max(square, hn::Set(d, 1e-36f))));
        hn::Store(hn::Mul(scale, cx), d, &sides.axes[0][i]);
        hn::Store(hn::Mul(scale, cy), d, &sides.axes[1][i]);
        hn::Store(hn::Mul(scale, cz), d, &sides.axes[2][i]);
    }
}

void write_bands_of(const RingColumns& rings, const LightPlace& light, float* columns) {
    Sides sides;
    find_sides(rings, light, sides);
    constexpr std::size_t stride = OccluderBlock::capacity;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto is_last = hn::Lt(hn::LoadU(d, rings.radius + i + 1), hn::Zero(d));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float* centre = std::array{rings.x, rings.y, rings.z}[axis] + i;
            const float* side = &sides.axes[axis][i];
            const V here = hn::LoadU(d, centre), next = hn::IfThenElse(is_last, here, hn::LoadU(d, centre + 1));
            const V from = hn::IfThenZeroElse(is_last, hn::Load(d, side)),
                    to = hn::IfThenZeroElse(is_last, hn::LoadU(d, side + 1));
            const V low = hn::Sub(here, from), high = hn::Add(next, to);
            float *first = columns + axis * stride + i, *second = first + count;
            hn::StoreU(hn::Add(here, from), d, first);
            hn::StoreU(low, d, first + 3 * stride);
            hn::StoreU(high, d, first + 6 * stride);
            hn::StoreU(low, d, second);
            hn::StoreU(high, d, second + 3 * stride);
            hn::StoreU(hn::Sub(next, to), d, second + 6 * stride);
        }
    }
}
} // namespace bands
using bands::write_bands_of;
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(write_bands_of);
void write_bands(const RingColumns& rings, const LightPlace& light, float* columns) {
    HWY_DYNAMIC_DISPATCH(write_bands_of)(rings, light, columns);
}
} // namespace tyndall::light_shafts
#endif
