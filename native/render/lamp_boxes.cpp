// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/lamp_boxes.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/lamp_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, WideBvh::width>;
using V = hn::Vec<Tag>;
static constexpr Tag d;

/// Of the node's children, those whose boxes the ray may meet.
static HWY_INLINE std::uint32_t met_children(const WideBvh::Node& node, const Ray& ray, const vec3& inverse) {
    std::uint32_t met = 0;
    for (std::size_t at = 0; at < WideBvh::width; at += hn::Lanes(d)) {
        V near = hn::Set(d, ray.near_m), far = hn::Set(d, ray.far_m);
        for (int axis = 0; axis < 3; ++axis) {
            const V middle =
                (hn::Load(d, &node.centre[axis][at]) - hn::Set(d, ray.origin[axis])) * hn::Set(d, inverse[axis]);
            // The roundings of the difference, the product and the sums are of the distance, not of the box.
            const V half = hn::MulAdd(hn::Load(d, &node.half_extent[axis][at]), hn::Set(d, std::abs(inverse[axis])),
                                      hn::Set(d, 4e-7f) * hn::Abs(middle));
            near = hn::Max(near, middle - half);
            far = hn::Min(far, middle + half);
        }
        std::array<std::uint8_t, 8> bytes{};
        hn::StoreMaskBits(d, hn::Le(near, far), bytes.data());
        met |= static_cast<std::uint32_t>(bytes[0] | bytes[1] << 8) << at;
    }
    return met;
}

void find_leaves(const WideBvh& tree, const Ray& ray, std::vector<std::uint32_t>& leaves) {
    vec3 inverse;
    for (int axis = 0; axis < 3; ++axis) // of what runs across an axis a number all the same
        inverse[axis] = 1.0f / std::copysign(std::max(std::abs(ray.direction[axis]), 1e-18f), ray.direction[axis]);
    thread_local std::vector<std::uint32_t> waiting;
    waiting.assign(1, 0);
    while (!waiting.empty()) {
        const WideBvh::Node& node = tree.nodes()[waiting.back()];
        waiting.pop_back();
        for (std::uint32_t met = met_children(node, ray, inverse); met != 0; met &= met - 1) {
            const std::uint32_t child = node.child[std::countr_zero(met)];
            if ((child & WideBvh::leaf_bit) != 0)
                leaves.push_back(child & ~WideBvh::leaf_bit);
            else
                waiting.push_back(child);
        }
    }
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(find_leaves);

LampBoxes::LampBoxes(std::span<const Bounds3> boxes) {
    std::vector<Bounds3> grown;
    for (const Bounds3& box : boxes) {
        const vec3 margin = 1e-6f * (glm::abs(box.min) + glm::abs(box.max)) + 1e-5f * (box.max - box.min) + 1e-6f;
        grown.push_back({.min = box.min - margin, .max = box.max + margin});
    }
    tree_ = WideBvh(embree_device(), grown, 1, Progress());
    for (const WideBvh::Leaf& leaf : tree_.leaves())
        box_of_leaf_.push_back(leaf.primitives[0]);
    tree_.forget_leaves();
}

void LampBoxes::find(const Ray& ray, std::vector<std::uint32_t>& found) const {
    found.clear();
    if (is_empty())
        return;
    HWY_DYNAMIC_DISPATCH(find_leaves)(tree_, ray, found);
    for (std::uint32_t& leaf : found)
        leaf = box_of_leaf_[leaf];
    std::ranges::sort(found); // what is added up of them keeps its bits wherever the hierarchy was built
}
} // namespace tyndall::render
#endif
