// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/triangle_mesh.hpp"
#include "core/errors.hpp"
#include "scene/attribute_pairs.hpp"
#include "scene/closed_mesh.hpp"
#include "scene/embree.hpp"
#include <algorithm>

namespace tyndall {
SharedMeshArrays::SharedMeshArrays(MeshArrays arrays)
    : name(std::move(arrays.name)), triangles(std::move(arrays.triangles)),
      material_slots(std::move(arrays.material_slots)), corner_normals(std::move(arrays.corner_normals)) {
    arrays.positions.reserve(arrays.positions.size() + 1); // the slack
    positions = std::move(arrays.positions);
    for (MeshArrays::UvMap& map : arrays.uv_maps)
        uv_maps.push_back({std::move(map.name), std::move(map.corner_uvs)});
}

const SharedMeshArrays::UvMap* SharedMeshArrays::uv_map(const std::string& map_name) const {
    const auto found =
        std::ranges::find_if(uv_maps, [&](const UvMap& map) { return attribute_pairs::answers(map.name, map_name); });
    return found == uv_maps.end() ? nullptr : &*found;
}

static void validate(const SharedMeshArrays& arrays) {
    const std::size_t triangle_count = arrays.triangles.size();
    const auto has_length = [&](std::size_t length, std::size_t expected, const auto&... what) {
        require(length == 0 || length == expected, "mesh '", arrays.name, "': ", what..., " has ", length,
                " entries, expected ", expected);
    };
    has_length(arrays.material_slots.size(), triangle_count, "material_slots");
    has_length(arrays.corner_normals.size(), 3 * triangle_count, "corner_normals");
    for (const SharedMeshArrays::UvMap& map : arrays.uv_maps)
        has_length(map.corner_uvs.size(), 3 * triangle_count, "UV map '", map.name, "'");
    for (std::size_t triangle = 0; triangle < triangle_count; ++triangle) {
        const uvec3& corners = arrays.triangles[triangle];
        const std::uint32_t largest = std::max({corners.x, corners.y, corners.z});
        require(largest < arrays.positions.size(), "mesh '", arrays.name, "': triangle ", triangle, " asks for vertex ",
                largest, " of ", arrays.positions.size());
    }
}

static bool is_traceable(const vec3& position) {
    return std::abs(position.x) < largest_coordinate_m && std::abs(position.y) < largest_coordinate_m &&
           std::abs(position.z) < largest_coordinate_m; // false for a NaN, too
}

/// In double: the float cross product of a leaf's 0.1 mm triangle 60 km out is noise.
static bool has_area(const vec3& a, const vec3& b, const vec3& c) {
    const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
    return cross.x != 0.0 || cross.y != 0.0 || cross.z != 0.0;
}

/// Of `items` a copy of the groups of `per_triangle` whose triangle is in `kept`.
template <typename Item>
static void keep_only(SharedArray<Item>& items, const std::vector<std::uint32_t>& kept, std::size_t per_triangle) {
    if (items.empty())
        return;
    std::vector<Item> some;
    some.reserve(kept.size() * per_triangle);
    for (const std::uint32_t triangle : kept)
        some.insert(some.end(), items.begin() + triangle * per_triangle, items.begin() + (triangle + 1) * per_triangle);
    items = std::move(some);
}

TriangleMesh::TriangleMesh(SharedMeshArrays arrays, const Progress& progress, TreeQuality quality)
    : arrays_(std::move(arrays)), quality_(arrays_.triangles.size() < fewest_for_haste ? TreeQuality::Best : quality) {
    validate(arrays_);
    progress.poll();
    drop_unusable_triangles();
    for (const uvec3& corners : arrays_.triangles)
        for (const std::uint32_t corner : {corners.x, corners.y, corners.z})
            bounds_.grow(arrays_.positions[corner]);
    build(progress);
}

void TriangleMesh::drop_unusable_triangles() {
    std::vector<std::uint32_t> kept;
    kept.reserve(arrays_.triangles.size());
    for (std::uint32_t triangle = 0; triangle < arrays_.triangles.size(); ++triangle) {
        const uvec3& corners = arrays_.triangles[triangle];
        const vec3 &a = arrays_.positions[corners.x], &b = arrays_.positions[corners.y],
                   &c = arrays_.positions[corners.z];
        if (!is_traceable(a) || !is_traceable(b) || !is_traceable(c))
            ++non_finite_triangle_count_;
        else if (!has_area(a, b, c))
            ++degenerate_triangle_count_;
        else
            kept.push_back(triangle);
    }
    if (kept.size() == arrays_.triangles.size())
        return;
    keep_only(arrays_.triangles, kept, 1);
    keep_only(arrays_.material_slots, kept, 1);
    keep_only(arrays_.corner_normals, kept, 3);
    for (SharedMeshArrays::UvMap& map : arrays_.uv_maps)
        keep_only(map.corner_uvs, kept, 3);
}

void TriangleMesh::build(const Progress& progress) {
    const RTCDevice device = embree_device();
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, arrays_.positions.data(), 0,
                               sizeof(vec3), arrays_.positions.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, arrays_.triangles.data(), 0,
                               sizeof(uvec3), arrays_.triangles.size());
    rtcCommitGeometry(geometry);
    embree_scene_ = rtcNewScene(device);
    rtcAttachGeometryByID(embree_scene_, geometry, 0);
    rtcReleaseGeometry(geometry);
    try {
        rtcSetSceneFlags(embree_scene_, traced_scene_flags);
        commit_tree(quality_, progress);
    } catch (...) {
        rtcReleaseScene(embree_scene_);
        throw;
    }
}

void TriangleMesh::commit_tree(TreeQuality quality, const Progress& progress) const {
    const RTCBuildQuality build = quality == TreeQuality::Best ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_LOW;
    const RTCGeometry geometry = rtcGetGeometry(embree_scene_, 0);
    rtcSetGeometryBuildQuality(geometry, build);
    rtcCommitGeometry(geometry);
    rtcSetSceneBuildQuality(embree_scene_, build);
    commit(embree_scene_, "mesh '" + arrays_.name + "'", progress);
}

void TriangleMesh::finish_tree(const Progress& progress) const {
    if (quality_ == TreeQuality::Best)
        return;
    try {
        commit_tree(TreeQuality::Best, progress);
    } catch (const Cancelled&) { // which leaves no tree at all
        commit_tree(TreeQuality::Hasty, Progress());
        throw;
    }
    quality_ = TreeQuality::Best;
}

bool TriangleMesh::is_closed() const {
    const std::scoped_lock lock(found_mutex_);
    if (!is_closed_)
        is_closed_ = tyndall::is_closed(arrays_);
    return *is_closed_;
}

TriangleMesh::~TriangleMesh() { rtcReleaseScene(embree_scene_); }
} // namespace tyndall
