// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/cell_geometry.hpp"
#include "core/random.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <array>

namespace tyndall {
static void bound(const RTCBoundsFunctionArguments* arguments) {
    const Bounds3& bounds = static_cast<const CellShape*>(arguments->geometryUserPtr)->bounds();
    *arguments->bounds_o = {bounds.min.x, bounds.min.y, bounds.min.z, 0.0f,
                            bounds.max.x, bounds.max.y, bounds.max.z, 0.0f};
}

/// Embree has brought it into the shape's space; its direction is no longer of unit length.
static Ray ray_of(RTCRayN* rays, unsigned int count, unsigned int lane) {
    return {.origin = vec3(RTCRayN_org_x(rays, count, lane), RTCRayN_org_y(rays, count, lane),
                           RTCRayN_org_z(rays, count, lane)),
            .direction = vec3(RTCRayN_dir_x(rays, count, lane), RTCRayN_dir_y(rays, count, lane),
                              RTCRayN_dir_z(rays, count, lane)),
            .near_m = RTCRayN_tnear(rays, count, lane),
            .far_m = RTCRayN_tfar(rays, count, lane)};
}

static RTCHit embree_hit(const CellHit& hit, const RTCIntersectContext& context) {
    RTCHit result{};
    result.Ng_x = hit.normal.x;
    result.Ng_y = hit.normal.y;
    result.Ng_z = hit.normal.z;
    result.u = hit.on_face.x;
    result.v = hit.on_face.y;
    result.primID = static_cast<unsigned int>(hit.cell);
    result.geomID = static_cast<unsigned int>(hit.cell >> 32);
    result.instID[0] = context.instID[0];
    return result;
}

constexpr unsigned int most_lanes = 16; // of Embree's widest packets

/// In the shape's space. Instances turn the numbers each by its own hash: what they cover is independent.
static RayDetail detail_of(const CellQuery& query, unsigned int ray) {
    const unsigned int instance = query.embree.instID[0];
    const RayDetail& detail = query.details[ray];
    const float lengths = query.shape_lengths[instance - query.first_shape],
                number = detail.number + unit_float(hash(instance));
    return {.width_m = lengths * detail.width_m,
            .spread = lengths * detail.spread,
            .number = number < 1.0f ? number : number - 1.0f};
}

/// Filters of nearest hits are about triangles without a surface; a shape has one everywhere, so none is called.
static void intersect(const RTCIntersectFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const CellShape*>(arguments->geometryUserPtr);
    const auto& query = *reinterpret_cast<const CellQuery*>(arguments->context);
    const unsigned int count = arguments->N;
    RTCRayN* lanes = RTCRayHitN_RayN(arguments->rayhit, count);
    RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, count);
    std::array<Ray, most_lanes> rays;
    std::array<RayDetail, most_lanes> details;
    std::array<unsigned int, most_lanes> lane_of;
    std::size_t asked = 0;
    for (unsigned int lane = 0; lane < count; ++lane) {
        if (arguments->valid[lane] == 0)
            continue;
        rays[asked] = ray_of(lanes, count, lane);
        if (!query.details.empty())
            details[asked] = detail_of(query, RTCRayN_id(lanes, count, lane));
        lane_of[asked++] = lane;
    }
    std::array<CellHit, most_lanes> found;
    shape.closest_hits(std::span(rays).first(asked), std::span(details).first(query.details.empty() ? 0 : asked),
                       std::span(found).first(asked));
    for (std::size_t i = 0; i < asked; ++i) {
        if (!found[i].is_hit())
            continue;
        const RTCHit hit = embree_hit(found[i], *arguments->context);
        rtcCopyHitToHitN(hits, &hit, count, lane_of[i]);
        RTCRayN_tfar(lanes, count, lane_of[i]) = found[i].distance_m;
    }
}

/// Whether the query's filter takes the first cell for an occluder: it knows instances, not cells.
static bool is_accepted(const RTCOccludedFunctionNArguments& arguments, const CellShape& shape, const Ray& ray,
                        unsigned int lane) {
    const CellHit found = shape.closest_hit(ray);
    if (!found.is_hit())
        return false;
    RTCRay as_hit = rtcGetRayFromRayN(arguments.ray, arguments.N, lane);
    as_hit.tfar = found.distance_m;
    RTCHit hit = embree_hit(found, *arguments.context);
    int valid = -1;
    const RTCFilterFunctionNArguments filtered{.valid = &valid,
                                               .geometryUserPtr = arguments.geometryUserPtr,
                                               .context = arguments.context,
                                               .ray = reinterpret_cast<RTCRayN*>(&as_hit),
                                               .hit = reinterpret_cast<RTCHitN*>(&hit),
                                               .N = 1};
    arguments.context->filter(&filtered);
    return valid != 0;
}

static void occlude(const RTCOccludedFunctionNArguments* arguments) {
    const auto& shape = *static_cast<const CellShape*>(arguments->geometryUserPtr);
    const unsigned int count = arguments->N;
    for (unsigned int lane = 0; lane < count; ++lane) {
        if (arguments->valid[lane] == 0)
            continue;
        const Ray ray = ray_of(arguments->ray, count, lane);
        if (arguments->context->filter == nullptr ? shape.is_occluded(ray) : is_accepted(*arguments, shape, ray, lane))
            RTCRayN_tfar(arguments->ray, count, lane) = -std::numeric_limits<float>::infinity();
    }
}

CellGeometry::CellGeometry(std::shared_ptr<const CellShape> shape) : shape_(std::move(shape)) {
    const RTCDevice device = embree_device();
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, shape_->bounds().is_empty() ? 0 : 1);
    rtcSetGeometryUserData(geometry, const_cast<CellShape*>(shape_.get())); // the callbacks only read it
    rtcSetGeometryBoundsFunction(geometry, bound, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occlude);
    rtcCommitGeometry(geometry);
    embree_scene_ = rtcNewScene(device);
    rtcSetSceneFlags(embree_scene_, traced_scene_flags);
    rtcAttachGeometryByID(embree_scene_, geometry, 0);
    rtcReleaseGeometry(geometry);
    try {
        commit(embree_scene_, "voxel object '" + shape_->name() + "'", Progress());
    } catch (...) {
        rtcReleaseScene(embree_scene_);
        throw;
    }
}

CellGeometry::~CellGeometry() { rtcReleaseScene(embree_scene_); }
} // namespace tyndall
