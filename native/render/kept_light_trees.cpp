// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/kept_light_trees.hpp"
#include <algorithm>

namespace tyndall::render {
std::shared_ptr<const MeshEmitters> KeptLightTrees::emitters_of(const Scene& scene, const Progress& progress) {
    if (emitters_ == nullptr || geometry_.lock() != scene.geometry()) {
        emitters_ = std::make_shared<const MeshEmitters>(scene, progress);
        geometry_ = scene.geometry();
    }
    return emitters_;
}

std::shared_ptr<const LightTree> KeptLightTrees::tree_of(std::vector<LightBounds>&& lights) {
    if (const auto found = std::ranges::find(entries_, lights, &Entry::lights); found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return found->tree;
    }
    auto tree = std::make_shared<const LightTree>(lights);
    entries_.push_front({std::move(lights), tree});
    bytes_ += entries_.front().bytes();
    while (bytes_ > capacity_bytes_) {
        bytes_ -= entries_.back().bytes();
        entries_.pop_back();
    }
    return tree;
}

std::shared_ptr<const MeshEmitters> emitters_of(const Scene& scene, KeptLightTrees* kept, const Progress& progress) {
    return kept != nullptr ? kept->emitters_of(scene, progress) : std::make_shared<const MeshEmitters>(scene, progress);
}

std::shared_ptr<const LightTree> tree_of(std::vector<LightBounds>&& lights, KeptLightTrees* kept) {
    return kept != nullptr ? kept->tree_of(std::move(lights)) : std::make_shared<const LightTree>(lights);
}
} // namespace tyndall::render
