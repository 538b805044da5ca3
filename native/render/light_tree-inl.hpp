// SPDX-License-Identifier: GPL-3.0-or-later
// What the two ways to choose in a tree share: light_tree.cpp and light_tree_along.cpp include this inside their namespace,
// once per SIMD target.

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, LightTree::width>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V load(const LightTree::Row& row, std::size_t at) { return hn::Load(d, &row[at]); }
static HWY_INLINE V sine_of(V cosine) {
    return hn::Sqrt(hn::Max(hn::Zero(d), hn::NegMulAdd(cosine, cosine, set(1.0f))));
}

/// The sides that some children shine from.
struct Beams {
    V cos_spread, sin_spread, cos_reach, back;

    HWY_INLINE Beams(const LightTree::Node& node, std::size_t at)
        : cos_spread(load(node.cos_spread, at)), sin_spread(load(node.sin_spread, at)),
          cos_reach(load(node.cos_reach, at)), back(load(node.back, at)) {}
    /// The cosine of the least angle at which they may be seen; by that of the axis to the viewer, and by sine and cosine of
    /// half the angle that they are seen under.
    HWY_INLINE V towards(V along_axis, V sine, V cosine) const {
        const V zero = hn::Zero(d), one = set(1.0f);
        const V cos_widened = hn::NegMulAdd(sin_spread, sine, cos_spread * cosine),
                sin_widened = hn::MulAdd(sin_spread, cosine, cos_spread * sine);
        const V across_axis = sine_of(along_axis);
        const auto emitted = [&](V along) HWY_ATTR {
            const auto is_full = hn::Or(hn::Ge(along, cos_widened), hn::Lt(sin_widened, zero));
            const V beside = hn::MulAdd(along, cos_widened, across_axis * sin_widened);
            // What lies out of reach by no more than rounding is in it.
            return hn::IfThenElse(is_full, one, hn::IfThenElseZero(hn::Ge(beside, cos_reach - set(1e-5f)), beside));
        };
        return hn::Max(zero, hn::Max(emitted(along_axis), back * emitted(hn::Neg(along_axis))));
    }
};

static HWY_INLINE float sum_of(const LightTree::Row& weights) {
    float sum = 0.0f; // in one order on every machine
    for (const float weight : weights)
        sum += weight;
    return sum;
}

/// `weigh(node, weights)` tells what each child may send, and returns the sum.
template <typename Weigh>
static HWY_INLINE LightTree::Choice descend(std::span<const LightTree::Node> nodes, float u, const Weigh& weigh) {
    float probability = 1.0f;
    for (std::uint32_t index = 0;;) {
        alignas(32) LightTree::Row weights;
        const LightTree::Node& node = nodes[index];
        const float sum = weigh(node, weights);
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
template <typename Weigh>
static HWY_INLINE float share_of_slot(const LightTree::Node& node, std::uint32_t slot, const Weigh& weigh) {
    alignas(32) LightTree::Row weights;
    const float sum = weigh(node, weights);
    return sum > 0.0f ? weights[slot] / sum : 0.0f;
}
