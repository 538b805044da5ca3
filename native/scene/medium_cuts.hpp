// SPDX-License-Identifier: GPL-3.0-or-later
// Where the plane of a view ray and its light cuts the boundary of a medium.
#pragma once
#include "scene/media.hpp"
#include "scene/plane_cut.hpp"

namespace tyndall {
struct MediumCut {
    CutSegment<double> segment;
    dvec3 point;          ///< A corner of the triangle, object space.
    dvec3 outward_normal; ///< Object space, any length; wound inwards or mirrored boundaries are turned.
};

/// Appends the cuts with the triangles of one boundary; `plane` gives coordinates of object-space points.
void append_medium_cuts(const SceneDescription& scene, const MediumBoundary& boundary,
                        const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts);
/// The same for the box of a boundary with `is_box`, a cut per face that the plane meets.
void append_box_cuts(const Bounds3& box, const PlaneCoordinates<double>& plane, std::vector<MediumCut>& cuts);
} // namespace tyndall
