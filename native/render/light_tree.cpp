// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: section 4.1 of the paper, fig. 5: with the angles as sines and cosines, which no inverse has to be taken of.
// Differs:  a cluster that a point is inside of counts as if it were seen from its sphere, from the best side.
#include "render/light_tree.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/light_tree.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, LightTree::width>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V load(const LightTree::Row& row, std::size_t at) { return hn::Load(d, &row[at]); }
static HWY_INLINE V sine_of(V cosine) {
    return hn::Sqrt(hn::Max(hn::Zero(d), hn::NegMulAdd(cosine, cosine, set(1.0f))));
}

/// What each child may send to a point; returns the sum.
static HWY_INLINE float weigh(const LightTree::Node& node, const vec3& point, const vec3& normal,
                              LightTree::Row& weights) {
    const V zero = hn::Zero(d), one = set(1.0f);
    for (std::size_t at = 0; at < LightTree::width; at += hn::Lanes(d)) {
        const V x = load(node.x, at) - set(point.x), y = load(node.y, at) - set(point.y),
                z = load(node.z, at) - set(point.z);
        const V distance2 = hn::MulAdd(x, x, hn::MulAdd(y, y, z * z)), radius2 = load(node.radius2, at);
        const auto is_inside = hn::Le(distance2, radius2);
        const V inverse = one / hn::Sqrt(hn::Max(distance2, set(1e-30f)));
        // The angle under which the sphere is seen from its middle on.
        const V sine2 = hn::Min(one, radius2 * inverse * inverse);
        const V sine = hn::Sqrt(sine2), cosine = hn::Sqrt(one - sine2);
        const V at_point = hn::MulAdd(x, set(normal.x), hn::MulAdd(y, set(normal.y), z * set(normal.z))) * inverse;
        const V towards =
            hn::IfThenElse(hn::Ge(at_point, cosine), one, hn::MulAdd(at_point, cosine, sine_of(at_point) * sine));
        const V along_axis = hn::Neg(hn::MulAdd(x, load(node.axis_x, at),
                                                hn::MulAdd(y, load(node.axis_y, at), z * load(node.axis_z, at)))) *
                             inverse;
        const V cos_spread = load(node.cos_spread, at), sin_spread = load(node.sin_spread, at);
        const V cos_widened = hn::NegMulAdd(sin_spread, sine, cos_spread * cosine),
                sin_widened = hn::MulAdd(sin_spread, cosine, cos_spread * sine);
        const V across_axis = sine_of(along_axis), cos_reach = load(node.cos_reach, at);
        const auto emitted = [&](V along) {
            const auto is_full = hn::Or(hn::Ge(along, cos_widened), hn::Lt(sin_widened, zero));
            const V beside = hn::MulAdd(along, cos_widened, across_axis * sin_widened);
            // What lies out of reach by no more than rounding is in it.
            return hn::IfThenElse(is_full, one, hn::IfThenElseZero(hn::Ge(beside, cos_reach - set(1e-5f)), beside));
        };
        const V from_light = hn::Max(emitted(along_axis), load(node.back, at) * emitted(hn::Neg(along_axis)));
        const V shape = hn::IfThenElse(is_inside, one, hn::Max(zero, towards) * hn::Max(zero, from_light));
        hn::Store(load(node.power, at) * shape / hn::Max(distance2, hn::Max(load(node.floor2, at), set(1e-30f))), d,
                  &weights[at]);
    }
    float sum = 0.0f; // in one order on every machine
    for (const float weight : weights)
        sum += weight;
    return sum;
}

LightTree::Choice choose_of(std::span<const LightTree::Node> nodes, const vec3& point, const vec3& normal, float u) {
    float probability = 1.0f;
    for (std::uint32_t index = 0;;) {
        alignas(32) LightTree::Row weights;
        const LightTree::Node& node = nodes[index];
        const float sum = weigh(node, point, normal, weights);
        if (!(sum > 0.0f))
            return {};
        const LightTree::Slot chosen = LightTree::slot_at(weights, sum, u);
        u = chosen.rest;
        probability *= weights[chosen.slot] / sum;
        if ((node.child[chosen.slot] & LightTree::is_light) != 0)
            return {node.child[chosen.slot] & ~LightTree::is_light, probability};
        index = node.child[chosen.slot];
    }
}

float share_of(const LightTree::Node& node, std::uint32_t slot, const vec3& point, const vec3& normal) {
    alignas(32) LightTree::Row weights;
    const float sum = weigh(node, point, normal, weights);
    return sum > 0.0f ? weights[slot] / sum : 0.0f;
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(choose_of);
HWY_EXPORT(share_of);

LightTree::Choice LightTree::choose(const vec3& point, const vec3& normal, float u) const {
    if (nodes_.empty())
        return {};
    return HWY_DYNAMIC_DISPATCH(choose_of)(nodes_, point, normal, u);
}

float LightTree::probability(std::uint32_t light, const vec3& point, const vec3& normal) const {
    float probability = 1.0f;
    for (Place place = place_of_light_[light]; place.node != none && probability > 0.0f;
         place = place_of_node_[place.node])
        probability *= HWY_DYNAMIC_DISPATCH(share_of)(nodes_[place.node], place.slot, point, normal);
    return place_of_light_[light].node == none ? 0.0f : probability;
}
} // namespace tyndall::render
#endif
