// SPDX-License-Identifier: GPL-3.0-or-later
// Light lines against triangles that let a part of the light pass, 4 to 16 lines at a time.
#include "light_shafts/slope_rows_partial.hpp"
#include <array>
#include <optional>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/slope_rows_partial_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_cutter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using VI = hn::Vec<decltype(di)>;

/// Weights of a triangle's second and third corner where lines meet it.
struct Weights {
    V second, third;
};
static HWY_INLINE Weights weights_at(const PartialSegments& segments, std::size_t s, bool has_weights, V x) {
    const V over = hn::MulSub(x, set(segments.w[s]), set(segments.x[s]));
    const V under = hn::NegMulAdd(x, set(segments.w_run[s]), set(segments.x_run[s]));
    const Mask is_point = hn::Eq(under, hn::Zero(d)); // along the light every point of the segment is met
    const V share = hn::Clamp(hn::Div(over, hn::IfThenElse(is_point, set(1.0f), under)), hn::Zero(d), set(1.0f));
    Weights weights{hn::MulAdd(share, set(segments.weight_run[0][s]), set(segments.weight[0][s])),
                    hn::MulAdd(share, set(segments.weight_run[1][s]), set(segments.weight[1][s]))};
    if (has_weights) { // in a face of a cube: they are straight only times 1 / z
        const V a = hn::MulAdd(share, set(segments.a_run[s]), set(segments.a[s]));
        weights.second = hn::Div(weights.second, a);
        weights.third = hn::Div(weights.third, a);
    }
    return weights;
}

/// The texel that holds a coordinate, or the lower one of the two it lies between; [-margin, count] also for what is no
/// number.
static HWY_INLINE VI texel_of(V at, std::uint32_t count, TextureExtension extension, TextureInterpolation filter) {
    if (extension == TextureExtension::Repeat) {
        at = hn::Sub(at, hn::Floor(at));
    } else if (extension == TextureExtension::Mirror) {
        const V half = hn::Mul(at, set(0.5f)), rest = hn::Mul(set(2.0f), hn::Sub(half, hn::Floor(half)));
        at = hn::Min(rest, hn::Sub(set(2.0f), rest));
    }
    const auto size = static_cast<float>(count);
    const V texel = hn::MulSub(at, set(size), set(filter == TextureInterpolation::Linear ? 0.5f : 0.0f));
    constexpr std::int32_t margin = TransparencyLookup::margin;
    const VI whole = hn::ConvertTo(di, hn::Floor(hn::Min(hn::Max(texel, set(static_cast<float>(-margin))), set(size))));
    return hn::Min(hn::Max(whole, hn::Set(di, -margin)), hn::Set(di, static_cast<std::int32_t>(count)));
}

/// Bits of the lanes in `asked` whose light the surface stops.
static std::uint32_t stopped(const PartialSurface& surface, const Weights& weights, std::int32_t first_line,
                             Mask asked) {
    alignas(8) std::array<std::uint8_t, 8> bytes{};
    const auto bits = [&bytes](Mask mask) {
        hn::StoreMaskBits(d, mask, bytes.data());
        return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
    };
    const TransparencyLookup& lookup = *surface.slot->lookup;
    std::uint32_t stops = 0;
    if (lookup.constant()) {
        const float transmittance = (*lookup.constant())[surface.channel];
        for (std::uint32_t left = bits(asked); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            stops |= static_cast<std::uint32_t>(surface.stops(transmittance, first_line + lane)) << lane;
        }
        return stops;
    }
    alignas(64) std::array<float, 16> second, third;
    alignas(64) std::array<std::int32_t, 16> columns{}, rows{}, classes{};
    std::uint32_t open = bits(asked);
    if (lookup.image() != nullptr) {
        const Texture& texture = lookup.texture();
        const auto at = [&](int axis) {
            return hn::MulAdd(weights.second, set(surface.uv_run[0][axis]),
                              hn::MulAdd(weights.third, set(surface.uv_run[1][axis]), set(surface.uv[axis])));
        };
        const VI column = texel_of(at(0), texture.width, texture.extension, texture.interpolation);
        const VI row = texel_of(at(1), texture.height, texture.extension, texture.interpolation);
        const VI margin = hn::Set(di, TransparencyLookup::margin);
        const VI place =
            hn::Add(hn::Mul(hn::Add(row, margin), hn::Set(di, lookup.class_columns())), hn::Add(column, margin));
        const auto* words = reinterpret_cast<const std::int32_t*>(lookup.classes(surface.is_backface));
        const VI bit = hn::ShiftLeft<3>(hn::And(place, hn::Set(di, 3)));
        const VI found = hn::And(hn::Shr(hn::GatherIndex(di, words, hn::ShiftRight<2>(place)), bit), hn::Set(di, 0xff));
        const auto is = [&](TexelClass wanted) {
            return hn::RebindMask(d, hn::Eq(found, hn::Set(di, static_cast<std::int32_t>(wanted))));
        };
        stops = bits(hn::And(asked, is(TexelClass::Stops)));
        open &= ~(stops | bits(is(TexelClass::Passes)));
        if (open == 0)
            return stops;
        hn::Store(column, di, columns.data());
        hn::Store(row, di, rows.data());
        hn::Store(found, di, classes.data());
    } else {
        classes.fill(static_cast<std::int32_t>(TexelClass::Mixed));
    }
    hn::Store(weights.second, d, second.data());
    hn::Store(weights.third, d, third.data());
    for (; open != 0; open &= open - 1) {
        const auto lane = static_cast<std::size_t>(__builtin_ctz(open));
        auto found = static_cast<TexelClass>(classes[lane]);
        if (found == TexelClass::Unknown)
            found = lookup.classify(surface.is_backface, columns[lane], rows[lane]);
        if (found == TexelClass::Stops ||
            (found == TexelClass::Mixed && surface.stops(surface.transmittance({second[lane], third[lane]}),
                                                         first_line + static_cast<std::int32_t>(lane))))
            stops |= 1u << lane;
    }
    return stops;
}

struct PartialRaster {
    using Placed = PlacedPartials;
    static constexpr bool is_partial = true;
    const Rows& rows;
    const PartialShading& shading;
    const PlacedPartials& placed;

    void operator()(const PartialSegments& segments, std::size_t s, const RowExtent& extent) const {
        const std::int32_t first = segments.first[s], last = segments.last[s];
        float* row = rows.slopes.get() + extent.offset;
        const V factor = set(segments.x_factor[s]), constant = set(segments.constant[s]);
        const V lowest = set(segments.lowest[s]), highest = set(segments.highest[s]);
        const V smallest = set(extent.smallest_slope);
        std::optional<PartialSurface> surface;
        const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
        for (std::int32_t i = first & ~(lanes - 1); i <= last; i += lanes) {
            const V x = hn::LoadU(d, rows.layout.x_at_centre.data() + i);
            const V slope = hn::Min(hn::Max(hn::MulAdd(factor, x, constant), lowest), highest);
            const VI line = hn::Add(hn::Iota(di, 0), hn::Set(di, i));
            const auto is_inside = hn::And(hn::Gt(line, hn::Set(di, first - 1)), hn::Lt(line, hn::Set(di, last + 1)));
            float* samples = row + (i - extent.first);
            const V before = hn::Load(d, samples);
            const Mask asked = hn::And(hn::RebindMask(d, is_inside), hn::Gt(slope, hn::Max(before, smallest)));
            if (hn::AllFalse(d, asked))
                continue;
            if (!surface) {
                const auto t = static_cast<std::size_t>(segments.triangle[s]);
                surface = partial_surface(shading, placed.instance[t], static_cast<std::uint32_t>(placed.triangle[t]),
                                          segments.slice[s]);
            }
            const std::uint32_t stops = stopped(*surface, weights_at(segments, s, placed.has_weights, x), i, asked);
            const std::array<std::uint8_t, 8> bytes{static_cast<std::uint8_t>(stops),
                                                    static_cast<std::uint8_t>(stops >> 8)};
            hn::Store(hn::IfThenElse(hn::LoadMaskBits(d, bytes.data()), slope, before), d, samples);
        }
    }
};

void raster_partials_of(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, const PartialShading& shading,
                        PlacedPartials& placed) {
    cut_all(rows.layout, first_slice, end_slice, placed, PartialRaster{rows, shading, placed});
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(raster_partials_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::slope_rows {
void raster_partials(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, const PartialShading& shading,
                     PlacedPartials& placed) {
    if (placed.count > 0)
        HWY_DYNAMIC_DISPATCH(raster_partials_of)(rows, first_slice, end_slice, shading, placed);
}
} // namespace tyndall::light_shafts::slope_rows
#endif
