// SPDX-License-Identifier: GPL-3.0-or-later
// Rectification of depth maps to slope rows: each sample takes the texel that its light line falls into.
// Bound:    one gather per sample under a sun, one per face that a vector of samples meets under a lamp.
#include "core/parallel.hpp"
#include "light_shafts/shadow_map.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/shadow_map_rectify.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_frame-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// DepthMap::depth_at, 4 to 16 points at a time.
static HWY_INLINE V depth_at(const DepthMap& map, V x, V y) {
    const Layout& layout = map.texels->layout;
    const V column = hn::Mul(hn::Sub(x, set(layout.first_line)), set(1.0f / layout.line_step));
    const V row = hn::MulAdd(hn::Sub(y, set(layout.first_slice)), set(1.0f / layout.slice_step), set(0.5f));
    const auto is_inside = hn::And(hn::And(hn::Ge(column, hn::Zero(d)), hn::Ge(row, hn::Zero(d))),
                                   hn::And(hn::Lt(column, set(static_cast<float>(layout.line_count))),
                                           hn::Lt(row, set(static_cast<float>(layout.slice_count())))));
    const auto texel =
        hn::Add(hn::Mul(hn::ConvertTo(di, row), hn::Set(di, layout.rows.front().end)), hn::ConvertTo(di, column));
    const auto safe = hn::IfThenElseZero(hn::RebindMask(di, is_inside), texel);
    return hn::IfThenElse(is_inside, hn::GatherIndex(d, map.texels->slopes.get(), safe), set(no_occluder));
}

/// Distance from a local light to the occluder along unit directions; infinite without one.
static HWY_INLINE V occluder_distance(const ShadowMap& map, const V (&direction)[3]) {
    const auto dot = [&](const vec3& axis) {
        return hn::MulAdd(set(axis.x), direction[0],
                          hn::MulAdd(set(axis.y), direction[1], hn::Mul(set(axis.z), direction[2])));
    };
    V best_z = hn::Zero(d);
    for (const DepthMap& face : map.faces)
        best_z = hn::Max(best_z, dot(face.z_axis));
    V distance = set(std::numeric_limits<float>::infinity());
    for (const DepthMap& face : map.faces) {
        const V z = dot(face.z_axis);
        const auto is_here = hn::And(hn::Eq(z, best_z), hn::Gt(z, hn::Zero(d)));
        if (hn::AllFalse(d, is_here))
            continue;
        const V inverse_z = depth_at(face, hn::Div(dot(face.x_axis), z), hn::Div(dot(face.y_axis), z));
        const auto is_hit = hn::And(is_here, hn::Gt(inverse_z, hn::Zero(d)));
        distance = hn::IfThenElse(is_hit, hn::Div(set(1.0f), hn::Mul(inverse_z, z)), distance);
    }
    return distance;
}

void rectify_row_of(const ShadowMap& map, Rows& rows, std::size_t slice, const vec2* line_directions) {
    const Layout& layout = rows.layout;
    const Frame& frame = layout.frame;
    const RowExtent& extent = layout.rows[slice];
    const float across = frame.is_parallel ? layout.first_slice + static_cast<float>(slice) * layout.slice_step : 0.0f;
    const vec2 direction = layout.slice_directions[slice];
    const vec3 outwards = direction.x * frame.u + direction.y * frame.v;
    const RowsOnMap on_map(frame, map.faces.front());
    // x and y on a sun's map: at r = 0, and per r.
    const vec2 at_axis = on_map.at({0.0f, across}), per_r = on_map.at(direction) - vec2(on_map.offset);
    float* row = rows.slopes.get() + extent.offset;
    const auto per_line = hn::Add(hn::Iota(di, 0), hn::Iota(di, 0));
    for (std::int32_t i = extent.first; i < extent.end; i += static_cast<std::int32_t>(hn::Lanes(d))) {
        V a, r;
        Mask is_hit; // an infinite a times a zero coefficient is no number
        if (frame.is_angular) {
            const auto* components = reinterpret_cast<const float*>(line_directions + i);
            const V axial = hn::GatherIndex(d, components, per_line),
                    radial = hn::GatherIndex(d, components + 1, per_line);
            V from_light[3];
            for (int c = 0; c < 3; ++c)
                from_light[c] = hn::MulAdd(set(frame.axis[c]), axial, hn::Mul(set(outwards[c]), radial));
            const V distance = occluder_distance(map, from_light);
            is_hit = hn::Lt(distance, set(std::numeric_limits<float>::infinity()));
            a = hn::MulAdd(distance, axial, set(frame.light_axial()));
            r = hn::Mul(distance, radial);
        } else {
            const V line = hn::Add(hn::ConvertTo(d, hn::Add(hn::Iota(di, 0), hn::Set(di, i))), set(0.5f));
            r = hn::MulAdd(line, set(layout.line_step), set(layout.first_line));
            const V depth = depth_at(map.faces[0], hn::MulAdd(r, set(per_r.x), set(at_axis.x)),
                                     hn::MulAdd(r, set(per_r.y), set(at_axis.y)));
            is_hit = hn::Gt(depth, set(no_occluder));
            a = hn::Sub(depth, set(on_map.offset.z));
        }
        const V slope = hn::Div(linear_at(frame.y, a, r), linear_at(frame.w, a, r));
        hn::Store(hn::IfThenElse(is_hit, slope, set(no_occluder)), d, row + (i - extent.first));
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(rectify_row_of);

void rectify(const ShadowMap& map, slope_rows::Rows& rows, const Progress& progress) {
    const slope_rows::Layout& layout = rows.layout;
    std::vector<vec2> line_directions;
    for (std::size_t i = 0; layout.frame.is_angular && i < layout.x_at_centre.size(); ++i) {
        const auto line = static_cast<float>(std::min<std::size_t>(i, static_cast<std::size_t>(layout.line_count) - 1));
        line_directions.push_back(layout.frame.line_direction(layout.first_line + (line + 0.5f) * layout.line_step));
    }
    parallel_blocks(layout.rows.size(), 32, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slice = begin; slice < end; ++slice)
            HWY_DYNAMIC_DISPATCH(rectify_row_of)(map, rows, slice, line_directions.data());
        slope_rows::summarise_slices(rows, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
    });
}
} // namespace tyndall::light_shafts
#endif
