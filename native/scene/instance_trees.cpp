// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/instance_trees.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <iterator>

namespace tyndall {
InstanceTrees::Tree InstanceTrees::new_tree() {
    Tree tree(rtcNewScene(embree_device()), rtcReleaseScene);
    rtcSetSceneFlags(tree.get(), traced_scene_flags);
    return tree;
}

InstanceTrees::InstanceTrees() : all_(new_tree()) {}

/// Both ascending and without repetitions.
static std::vector<std::uint32_t> united(std::span<const std::uint32_t> some, std::span<const std::uint32_t> others) {
    std::vector<std::uint32_t> sorted(others.begin(), others.end()), result;
    std::ranges::sort(sorted);
    sorted.erase(std::ranges::unique(sorted).begin(), sorted.end());
    std::ranges::set_union(some, sorted, std::back_inserter(result));
    return result;
}

InstanceTrees::InstanceTrees(const InstanceTrees& other, std::span<const std::uint32_t> instances)
    : all_(other.all_), of_moved_(new_tree()), moved_(united(other.moved_, instances)), is_moved_(other.is_moved_) {
    if (!moved_.empty())
        is_moved_.resize(std::max<std::size_t>(is_moved_.size(), moved_.back() + 1u));
    for (const std::uint32_t instance : moved_)
        is_moved_[instance] = true;
}

bool InstanceTrees::can_move(std::size_t instance_count, std::span<const std::uint32_t> instances) const {
    return instance_count >= fewest_instances && instances.size() <= most_moved &&
           united(moved_, instances).size() <= most_moved;
}

void InstanceTrees::take(RTCScene instanced, const mat4& scene_from_object, std::uint32_t index, unsigned int mask) {
    attach_instance(growing().get(), instanced, scene_from_object, index, mask);
}

void InstanceTrees::share(const InstanceTrees& other, std::uint32_t index) {
    const Tree& from = other.has_moved(index) ? other.of_moved_ : other.all_;
    rtcAttachGeometryByID(growing().get(), rtcGetGeometry(from.get(), index), index);
}

void InstanceTrees::commit(const Progress& progress) { tyndall::commit(growing().get(), "the scene", progress); }
} // namespace tyndall
