// SPDX-License-Identifier: GPL-3.0-or-later
// How a local light shines towards points of rays, a ray in each lane, compiled once per SIMD target: its surface's cosine,
// its softening, its spread and its cone.
#if defined(TYNDALL_LOCAL_LIGHT_SHAPE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#undef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#else
#define TYNDALL_LOCAL_LIGHT_SHAPE_INL
#endif
#include "light_shafts/exp-inl.hpp"
#include "light_shafts/local_scatter_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
static constexpr std::size_t lanes = hn::MaxLanes(d);

static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V set(double value) { return hn::Set(d, static_cast<float>(value)); }

/// What a vector of rays needs of a light at all its points.
struct LightLanes {
    V light_y2, softened_y2, lobe0, lobe1;
    V cone[3], cone_d[3], offset0, offset_x;
};

struct LightShape {
    const LocalShape& shape;

    /// Of a patch of an area light.
    HWY_INLINE V area_lobe(const LightLanes& s, V x) const {
        const V p0 = hn::MulAdd(x, s.cone_d[0], s.cone[0]), p1 = hn::MulAdd(x, s.cone_d[1], s.cone[1]);
        const V p2 = hn::MulAdd(x, s.cone_d[2], s.cone[2]), across2 = hn::MulAdd(p0, p0, hn::Mul(p1, p1));
        const V before2 = hn::MulAdd(p2, p2, set(shape.softening_m2));
        const V lobe = hn::NegMulAdd(set(shape.spread_cotangent), hn::Sqrt(across2), hn::Sqrt(before2));
        return hn::Mul(hn::Max(lobe, hn::Zero(d)), reciprocal_root_of(d, hn::Add(before2, across2)));
    }
    /// The way that a patch's light has come, along the ray and across it: from as far behind the patch as its softening
    /// is (shaping_direction). From its middle all of it would graze the patch next to it, where it comes from all sides.
    HWY_INLINE void soften_way(const LightLanes& s, V x, V distance2, V& along, V& across2, V& inverse_way) const {
        const V softening = set(shape.softening_m2);
        const V before = hn::Max(hn::MulAdd(x, s.cone_d[2], s.cone[2]), hn::Zero(d));
        const V softened = hn::Sqrt(hn::MulAdd(before, before, softening));
        const V behind = hn::Mul(softening, reciprocal_of(d, hn::Max(hn::Add(softened, before), set(1e-20f))));
        along = hn::MulAdd(behind, s.cone_d[2], x);
        const V way2 = hn::Add(distance2, softening);
        across2 = hn::Max(hn::NegMulAdd(along, along, way2), hn::Zero(d));
        inverse_way = reciprocal_root_of(d, way2);
    }
    /// Cosine lobe, softening and cone at a point.
    HWY_INLINE V shape_at(const LightLanes& s, V x, V x2, V inverse_distance, V before, V after) const {
        if (shape.is_area)
            return area_lobe(s, x);
        V share = set(1.0f);
        if (shape.has_normal)
            share =
                hn::Mul(hn::Max(hn::MulAdd(before, s.lobe0, hn::Mul(after, s.lobe1)), hn::Zero(d)), inverse_distance);
        if (shape.is_soft) {
            const double offset2 = glm::dot(shape.falloff_offset, shape.falloff_offset) + shape.softening_m2;
            const V way2 =
                hn::Sub(hn::Add(hn::Add(x2, s.light_y2), set(offset2)), hn::MulAdd(x, s.offset_x, s.offset0));
            const V inverse_way2 = reciprocal_of(d, way2);
            share = hn::Mul(share, hn::Mul(hn::Add(x2, s.softened_y2), inverse_way2));
            const V cosine2 = hn::NegMulAdd(set(shape.softening_m2), inverse_way2, set(1.0f)); // at the patch of a disc
            share = shape.faces_receivers ? hn::Mul(share, hn::Sqrt(hn::Max(cosine2, hn::Zero(d)))) : share;
        }
        if (!shape.has_cone)
            return share;
        V p[3];
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = hn::MulAdd(x, s.cone_d[axis], s.cone[axis]);
        const V across2 = hn::MulAdd(p[0], p[0], hn::Mul(p[1], p[1]));
        const V inverse = reciprocal_root_of(d, hn::MulAdd(p[2], p[2], across2));
        const V cosine = hn::Mul(p[2], inverse), one = set(1.0f);
        // sin^2 / (1 + cos): near the axis of a narrow cone 1 - cos would be noise.
        V one_minus_cosine =
            hn::Mul(hn::Mul(across2, hn::Mul(inverse, inverse)), reciprocal_of(d, hn::Add(one, hn::Abs(cosine))));
        one_minus_cosine =
            hn::IfThenElse(hn::Lt(cosine, hn::Zero(d)), hn::Sub(set(2.0f), one_minus_cosine), one_minus_cosine);
        const V above = hn::Sub(set(shape.one_minus_cos_half), one_minus_cosine);
        if (shape.has_soft_edge) {
            const V rise = hn::Min(hn::Max(hn::Mul(above, set(shape.per_smooth)), hn::Zero(d)), one);
            share = hn::Mul(share, hn::Mul(hn::Mul(rise, rise), hn::NegMulAdd(set(2.0f), rise, set(3.0f))));
        } else
            share = hn::IfThenElseZero(hn::Gt(above, hn::Zero(d)), share);
        return shape.keeps_cosine ? hn::Mul(share, hn::Max(cosine, hn::Zero(d))) : share;
    }
};
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
