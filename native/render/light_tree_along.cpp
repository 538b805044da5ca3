// SPDX-License-Identifier: GPL-3.0-or-later
// One of many lights for a stretch of a view ray in media, drawn about as often as the media there scatter its light.
// Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012: along a
//           line 1 / r^2 adds up to the angle under which a light sees it, over the light's distance from the line.
// Differs:  a cluster is seen from no nearer than its radius, and shines as the mean of three points of the stretch says:
//           where it begins, where it ends, and the nearest. What lies deeper in the media than two thirds of the light
//           get counts with what passes to the nearest point, so that lamps which nobody sees are drawn seldom.
// Bound:    three times that of choose().
#include "render/light_tree.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/light_tree_along.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
#include "render/light_tree-inl.hpp"

#include "render/arctangent-inl.hpp"

/// Optical depth of the stretch that is looked at first.
static constexpr float first_depth = 1.1f;
/// Every light counts as if it shone so much towards the stretch: the three points may miss its beam.
static constexpr float least_shine = 0.02f;

/// Between the directions (1, from) and (1, to), from <= to; to 0.005 rad.
static HWY_INLINE V angle(V from, V to) { return arctangent(d, to - from, hn::MulAdd(from, to, set(1.0f))); }

/// Lights as seen from the line's origin, and how they shine on a point of the line.
struct Seen {
    Beams beams;
    V x, y, z, axis_x, axis_y, axis_z, radius2;

    HWY_INLINE V shine(const LightTree::Line& line, V at) const {
        const V one = set(1.0f);
        const V to_x = hn::NegMulAdd(at, set(line.direction.x), x), to_y = hn::NegMulAdd(at, set(line.direction.y), y),
                to_z = hn::NegMulAdd(at, set(line.direction.z), z);
        const V distance2 = hn::MulAdd(to_x, to_x, hn::MulAdd(to_y, to_y, to_z * to_z));
        const V inverse = one / hn::Sqrt(hn::Max(distance2, set(1e-30f)));
        const V sine2 = hn::Min(one, radius2 * inverse * inverse), sine = hn::Sqrt(sine2),
                cosine = hn::Sqrt(one - sine2);
        const V along = hn::Neg(hn::MulAdd(to_x, axis_x, hn::MulAdd(to_y, axis_y, to_z * axis_z))) * inverse;
        return hn::IfThenElse(hn::Le(distance2, radius2), one, beams.towards(along, sine, cosine));
    }
};

/// What each child may send to the line; returns the sum.
static HWY_INLINE float weigh(const LightTree::Node& node, const LightTree::Line& line, float middle_m,
                              LightTree::Row& weights) {
    alignas(32) LightTree::Row deep{}, foot_m{};
    for (std::size_t at = 0; at < LightTree::width; at += hn::Lanes(d)) {
        const Seen seen{.beams = Beams(node, at),
                        .x = load(node.x, at) - set(line.origin.x),
                        .y = load(node.y, at) - set(line.origin.y),
                        .z = load(node.z, at) - set(line.origin.z),
                        .axis_x = load(node.axis_x, at),
                        .axis_y = load(node.axis_y, at),
                        .axis_z = load(node.axis_z, at),
                        .radius2 = load(node.radius2, at)};
        const V foot = hn::MulAdd(seen.x, set(line.direction.x),
                                  hn::MulAdd(seen.y, set(line.direction.y), seen.z * set(line.direction.z)));
        // Off the line: the difference of two squares would have no digits left for what is far along it.
        const V off_x = hn::NegMulAdd(foot, set(line.direction.x), seen.x),
                off_y = hn::NegMulAdd(foot, set(line.direction.y), seen.y),
                off_z = hn::NegMulAdd(foot, set(line.direction.z), seen.z);
        const V off2 = hn::MulAdd(off_x, off_x, hn::MulAdd(off_y, off_y, off_z * off_z));
        const V inverse = set(1.0f) / hn::Sqrt(off2 + hn::Max(load(node.floor2, at), set(1e-30f)));
        const V near = (set(line.near_m) - foot) * inverse, middle = (set(middle_m) - foot) * inverse,
                far = (set(line.far_m) - foot) * inverse;
        const V nearest = hn::Min(hn::Max(foot, set(line.near_m)), set(middle_m));
        const V shine = hn::MulAdd(set(0.5f), seen.shine(line, nearest),
                                   set(0.25f) * (seen.shine(line, set(line.near_m)) + seen.shine(line, set(middle_m))));
        const V strength = load(node.power, at) * hn::Max(shine, set(least_shine)) * inverse;
        hn::Store(strength * angle(near, middle), d, &weights[at]);
        hn::Store(strength * angle(middle, far), d, &deep[at]);
        hn::Store(foot, d, &foot_m[at]);
    }
    if (middle_m < line.far_m)
        for (std::size_t slot = 0; slot < LightTree::width; ++slot)
            weights[slot] += deep[slot] * std::exp(-line.sigma_t_per_m *
                                                   (std::clamp(foot_m[slot], middle_m, line.far_m) - line.near_m));
    return sum_of(weights);
}

/// Where what is looked at first ends.
static HWY_INLINE float middle_of(const LightTree::Line& line) {
    return line.sigma_t_per_m > 0.0f ? std::min(line.far_m, line.near_m + first_depth / line.sigma_t_per_m)
                                     : line.far_m;
}

LightTree::Choice choose_along_of(std::span<const LightTree::Node> nodes, const LightTree::Line& line, float u) {
    const float middle_m = middle_of(line);
    return descend(nodes, u, [&](const LightTree::Node& node, LightTree::Row& weights) HWY_ATTR {
        return weigh(node, line, middle_m, weights);
    });
}

float share_along_of(const LightTree::Node& node, std::uint32_t slot, const LightTree::Line& line) {
    return share_of_slot(node, slot, [&](const LightTree::Node& one, LightTree::Row& weights) HWY_ATTR {
        return weigh(one, line, middle_of(line), weights);
    });
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(choose_along_of);
HWY_EXPORT(share_along_of);

LightTree::Choice LightTree::choose_along(const Line& line, float u) const {
    if (nodes_.empty())
        return {};
    return HWY_DYNAMIC_DISPATCH(choose_along_of)(nodes_, line, u);
}

float LightTree::probability_along(std::uint32_t light, const Line& line) const {
    float probability = place_of_light_[light].node == none ? 0.0f : 1.0f;
    for (Place place = place_of_light_[light]; place.node != none && probability > 0.0f;
         place = place_of_node_[place.node])
        probability *= HWY_DYNAMIC_DISPATCH(share_along_of)(nodes_[place.node], place.slot, line);
    return probability;
}
} // namespace tyndall::render
#endif
