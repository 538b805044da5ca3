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
#include "render/light_tree-inl.hpp"

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
        const V from_light = Beams(node, at).towards(along_axis, sine, cosine);
        const V shape = hn::IfThenElse(is_inside, one, hn::Max(zero, towards) * from_light);
        hn::Store(load(node.power, at) * shape / hn::Max(distance2, hn::Max(load(node.floor2, at), set(1e-30f))), d,
                  &weights[at]);
    }
    return sum_of(weights);
}

LightTree::Choice choose_of(std::span<const LightTree::Node> nodes, const vec3& point, const vec3& normal, float u) {
    return descend(nodes, u, [&](const LightTree::Node& node, LightTree::Row& weights) HWY_ATTR {
        return weigh(node, point, normal, weights);
    });
}

float share_of(const LightTree::Node& node, std::uint32_t slot, const vec3& point, const vec3& normal) {
    return share_of_slot(node, slot, [&](const LightTree::Node& one, LightTree::Row& weights) HWY_ATTR {
        return weigh(one, point, normal, weights);
    });
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
