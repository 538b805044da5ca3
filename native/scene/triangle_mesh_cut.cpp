// SPDX-License-Identifier: GPL-3.0-or-later
// The part of TriangleMesh that knows its hierarchy for cuts: built when a light shaft first asks for it.
#include "scene/triangle_bvh.hpp"

namespace tyndall {
const TriangleBvh& TriangleMesh::cut_bvh(const Progress& progress) const {
    const std::scoped_lock lock(found_mutex_);
    if (!cut_bvh_)
        cut_bvh_ = std::make_shared<const TriangleBvh>(rtcGetSceneDevice(embree_scene_), arrays_, progress);
    return *cut_bvh_;
}
} // namespace tyndall
