// SPDX-License-Identifier: GPL-3.0-or-later
// Embree's trees over the instances of a scene: one over all of them, and beside it a small one over those that moved
// since it was built. Rays ask one after the other, and pass in the first what stands in the second.
// Based on: Embree's two-level scenes, whose upper tree it builds but never updates: 0.1 s for 100,000 instances.
// Differs:  a tree is never changed, so that scenes share it: who moved is told apart where a ray has met it.
// Bound:    a move costs what has moved since the first tree was built, at most `most_moved` instances, 8 bytes per
//           instance that the scene has, and a bit.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <embree3/rtcore.h>
#include <memory>
#include <span>
#include <vector>

namespace tyndall {
class InstanceTrees {
public:
    /// Over fewer instances a new tree is built as soon.
    static constexpr std::size_t fewest_instances = 4096;
    /// Of more, the rest of a swarm that follows takes a new tree once instead of a larger one every time.
    static constexpr std::size_t most_moved = 1024;

    /// Over nothing yet.
    InstanceTrees();
    /// Those of `other` without some instances, which take() then puts elsewhere: all of moved().
    InstanceTrees(const InstanceTrees& other, std::span<const std::uint32_t> instances);

    /// Whether some of `instance_count` instances may move without a new tree over all.
    [[nodiscard]] bool can_move(std::size_t instance_count, std::span<const std::uint32_t> instances) const;
    /// A committed scene as instance `index`.
    void take(RTCScene instanced, const mat4& scene_from_object, std::uint32_t index, unsigned int mask);
    /// The same instance as in other trees.
    void share(const InstanceTrees& other, std::uint32_t index);
    /// Throws Cancelled.
    void commit(const Progress& progress);

    /// In ascending order: the instances that have moved since all() was built.
    [[nodiscard]] std::span<const std::uint32_t> moved() const { return moved_; }
    /// Whether an instance that was met in all() stands elsewhere.
    [[nodiscard]] bool has_moved(std::uint32_t instance) const {
        return instance < is_moved_.size() && is_moved_[instance];
    }
    [[nodiscard]] RTCScene all() const { return all_.get(); } ///< Instance i is geometry i.
    /// Likewise, over those that have moved; nullptr where none has.
    [[nodiscard]] RTCScene of_moved() const { return of_moved_.get(); }

private:
    using Tree = std::shared_ptr<RTCSceneTy>;
    [[nodiscard]] static Tree new_tree();
    [[nodiscard]] const Tree& growing() const { return of_moved_ ? of_moved_ : all_; }

    Tree all_, of_moved_;
    std::vector<std::uint32_t> moved_;
    std::vector<bool> is_moved_; ///< Empty where none has.
};
} // namespace tyndall
