// SPDX-License-Identifier: GPL-3.0-or-later
// What glows in a scene, and trees of lights, kept from picture to picture: a camera that moves, a moment of motion blur
// and fog beside surfaces ask for the same again.
// Differs:  nothing is told by what was changed: what glows is the geometry's, and a tree is that of its lights, each of
//           whose numbers is compared. So pictures have the same bits with and without it.
// Bound:    120 bytes a light of each tree; as many as it is given.
#pragma once
#include "render/light_tree.hpp"
#include "render/mesh_emitters.hpp"
#include <list>
#include <memory>

namespace tyndall::render {
/// For one thread at a time.
class KeptLightTrees {
public:
    explicit KeptLightTrees(std::size_t capacity_bytes) : capacity_bytes_(capacity_bytes) {}

    [[nodiscard]] std::shared_ptr<const MeshEmitters> emitters_of(const Scene& scene, const Progress& progress);
    [[nodiscard]] std::shared_ptr<const LightTree> tree_of(std::vector<LightBounds>&& lights);
    [[nodiscard]] std::size_t bytes() const { return bytes_; } ///< Of trees and what they are told by.

private:
    struct Entry {
        std::vector<LightBounds> lights;
        std::shared_ptr<const LightTree> tree;
        [[nodiscard]] std::size_t bytes() const { return lights.size() * sizeof(LightBounds) + tree->bytes(); }
    };

    std::size_t capacity_bytes_, bytes_ = 0;
    std::list<Entry> entries_; ///< Those last asked for come first.
    std::weak_ptr<const void> geometry_;
    std::shared_ptr<const MeshEmitters> emitters_; ///< Of that geometry.
};
/// Nothing is kept where there is no `kept`.
[[nodiscard]] std::shared_ptr<const MeshEmitters> emitters_of(const Scene& scene, KeptLightTrees* kept,
                                                              const Progress& progress);
[[nodiscard]] std::shared_ptr<const LightTree> tree_of(std::vector<LightBounds>&& lights, KeptLightTrees* kept);
} // namespace tyndall::render
