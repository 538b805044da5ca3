// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/box_transmittance.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/box_transmittance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;

static HWY_INLINE V set(float value) { return hn::Set(d, value); }

/// Lengths of the rays' parts in the box; `count` is at most the vector's.
static HWY_INLINE V length_in_box(const FogBox& box, const Ray* rays, std::size_t count) {
    constexpr std::int32_t stride = sizeof(Ray) / sizeof(float);
    static_assert(sizeof(Ray) == stride * sizeof(float) && offsetof(Ray, far_m) == 7 * sizeof(float));
    const auto* floats = reinterpret_cast<const float*>(rays);
    const auto last = hn::Set(di, stride * static_cast<std::int32_t>(count - 1));
    const auto at = hn::Min(hn::Mul(hn::Iota(di, 0), hn::Set(di, stride)), last);
    const auto field = [&](int index) { return hn::GatherIndex(d, floats + index, at); };
    const V ox = field(0), oy = field(1), oz = field(2), dx = field(3), dy = field(4), dz = field(5);
    const V nothing = set(std::numeric_limits<float>::infinity());
    V near_m = field(6), far_m = field(7);
    for (int axis = 0; axis < 3; ++axis) {
        const mat4& m = box.object_from_scene;
        const V direction = hn::MulAdd(set(m[0][axis]), dx, hn::MulAdd(set(m[1][axis]), dy, set(m[2][axis]) * dz));
        const V origin = hn::MulAdd(set(m[0][axis]), ox,
                                    hn::MulAdd(set(m[1][axis]), oy, hn::MulAdd(set(m[2][axis]), oz, set(m[3][axis]))));
        const V to_min = set(box.object_bounds.min[axis]) - origin, to_max = set(box.object_bounds.max[axis]) - origin;
        // Along the slab the quotients would be NaN on its face: all of the ray, or nothing.
        const auto is_along = hn::Eq(direction, hn::Zero(d));
        const auto is_beside = hn::Or(hn::Gt(to_min, hn::Zero(d)), hn::Lt(to_max, hn::Zero(d)));
        const V divisor = hn::IfThenElse(is_along, set(1.0f), direction);
        const V a = to_min / divisor, b = to_max / divisor;
        const V enters = hn::IfThenElse(is_along, hn::IfThenElse(is_beside, nothing, hn::Neg(nothing)), hn::Min(a, b));
        const V leaves = hn::IfThenElse(is_along, hn::IfThenElse(is_beside, hn::Neg(nothing), nothing), hn::Max(a, b));
        near_m = hn::Max(near_m, enters);
        far_m = hn::Min(far_m, leaves);
    }
    return hn::IfThenElseZero(hn::Lt(near_m, far_m), far_m - near_m);
}

void attenuate_in(const FogBox& box, const Ray* rays, std::size_t ray_count, Rgb* passing) {
    const Rgb& sigma = box.sigma_t_per_m;
    const bool is_grey = sigma.x == sigma.y && sigma.y == sigma.z;
    for (std::size_t first = 0; first < ray_count; first += hn::Lanes(d)) {
        const std::size_t count = std::min(hn::Lanes(d), ray_count - first);
        const V length_m = length_in_box(box, rays + first, count);
        alignas(64) std::array<std::array<float, 16>, 3> shares;
        for (int channel = 0; channel < (is_grey ? 1 : 3); ++channel)
            hn::Store(hn::Exp(d, set(-sigma[channel]) * length_m), d, shares[static_cast<std::size_t>(channel)].data());
        for (std::size_t i = 0; i < count; ++i)
            passing[first + i] *= is_grey ? Rgb(shares[0][i]) : Rgb(shares[0][i], shares[1][i], shares[2][i]);
    }
}
} // namespace tyndall::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall {
HWY_EXPORT(attenuate_in);

void attenuate(const FogBox& box, std::span<const Ray> rays, std::span<Rgb> passing) {
    if (!rays.empty())
        HWY_DYNAMIC_DISPATCH(attenuate_in)(box, rays.data(), rays.size(), passing.data());
}
} // namespace tyndall
#endif
