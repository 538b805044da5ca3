// SPDX-License-Identifier: GPL-3.0-or-later
// Every crossing of a line with the boundaries of media: what Media walks along.
#pragma once
#include "scene/media.hpp"
#include <functional>

namespace tyndall {
struct MediumCrossing {
    float distance_m;
    std::uint32_t boundary;    ///< Into Media::boundaries.
    std::int32_t winding_step; ///< 1: the ray enters; -1: it leaves.
};

/// The boundaries of all instances with a material whose medium `acts`. Instance by instance, medium by medium.
[[nodiscard]] std::vector<MediumBoundary> find_medium_boundaries(const SceneDescription& description,
                                                                 const std::function<bool(std::uint16_t)>& acts,
                                                                 const Progress& progress);

/// An Embree scene of the boundaries that are not boxes, with BVHs of its own: Scene's answer only the nearest hit.
class MediumCrossings {
public:
    /// `boundaries` must outlive this.
    MediumCrossings(const Scene& scene, std::span<const MediumBoundary> boundaries, const Progress& progress);
    MediumCrossings(const MediumCrossings&) = delete;
    MediumCrossings& operator=(const MediumCrossings&) = delete;
    ~MediumCrossings();

    /// Appends all crossings at distances of 0 and more, in no order. Two neighbours that both report the edge they
    /// share count once, and at a silhouette an entry without its exit, or the reverse, does not count.
    void append(const vec3& origin, const vec3& direction, std::vector<MediumCrossing>& crossings) const;

    struct Hit {
        MediumCrossing crossing;
        std::uint32_t triangle;
        bool is_on_edge;
    };

private:
    /// Every hit once, near to far.
    void collect(const vec3& origin, const vec3& direction, std::vector<Hit>& hits) const;
    /// Removes what only one of two triangles at a silhouette edge reports: the windings of a closed mesh tell.
    void repair(const vec3& origin, std::vector<Hit>& hits) const;

    struct Instance {
        std::uint32_t scene_instance;
        bool is_inside_out;
        std::vector<std::int32_t> boundary_of_slot; ///< -1: the slot bounds no medium.
    };
    struct Query;
    const Scene& scene_;
    std::span<const MediumBoundary> boundaries_;
    std::vector<Instance> instances_; ///< By geometry id.
    RTCScene top_ = nullptr;
    std::vector<RTCScene> meshes_;
};
} // namespace tyndall
