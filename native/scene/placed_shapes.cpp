// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/placed_shapes.hpp"
#include "scene/embree.hpp"
#include "scene/instance_places.hpp"
#include "scene/scene.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <limits>

namespace tyndall {
Bounds3 bounds_of(const SceneDescription& scene, const PlacedShape& placed) {
    return transformed(scene.shapes[placed.shape_index]->bounds(), placed.world_from_object);
}

bool stops_light(const SceneDescription& scene, const PlacedShape& placed) {
    const Material& material = scene.materials[placed.material_index];
    return material.has_surface && !is_transparent_everywhere(material);
}

std::optional<std::uint32_t> shade_of(const SceneDescription& scene, const PlacedShape& placed) {
    const auto index = placed.shade_index < 0 ? placed.shape_index : static_cast<std::uint32_t>(placed.shade_index);
    if (!placed.casts_shadow || !stops_light(scene, placed) || scene.shapes[index]->bounds().is_empty())
        return std::nullopt;
    return index;
}

ShapeTracer::ShapeTracer(const SceneDescription& scene, std::vector<std::uint32_t> placed, const Progress& progress)
    : placed_(std::move(placed)), reach_m_(largest_coordinate_m), embree_scene_(rtcNewScene(embree_device())) {
    rtcSetSceneFlags(embree_scene_, traced_scene_flags);
    for (std::uint32_t i = 0; i < placed_.size(); ++i) {
        const PlacedShape& shape = scene.placed_shapes[placed_[i]];
        bounds_.grow(bounds_of(scene, shape));
        reach_m_ = std::min(reach_m_, reach_m(inverse_of(shape.world_from_object)));
        if (const std::optional<std::uint32_t> shade = shade_of(scene, shape))
            attach_instance(embree_scene_, scene.shapes[*shade]->embree_scene(), shape.world_from_object, i, ~0u);
    }
    try {
        commit(embree_scene_, "voxels and strands that cast shadows", progress);
    } catch (...) {
        rtcReleaseScene(embree_scene_);
        throw;
    }
}

ShapeTracer::~ShapeTracer() { rtcReleaseScene(embree_scene_); }

float ShapeTracer::distance_to_nearest(const Ray& ray) const {
    constexpr float nothing = std::numeric_limits<float>::infinity();
    if (!is_within(ray.origin, reach_m_))
        return nothing;
    CellQuery context;
    RTCRayHit query;
    query.ray = embree_ray(ray, ~0u);
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_scene_, &context.embree, &query);
    return query.hit.geomID == RTC_INVALID_GEOMETRY_ID ? nothing : query.ray.tfar;
}
} // namespace tyndall
