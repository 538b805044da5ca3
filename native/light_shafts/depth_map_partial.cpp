// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that let a part of the light pass, in a light's depth map: at each texel a yes or a no, as in slope rows.
#include "light_shafts/depth_map_face.hpp"

namespace tyndall::light_shafts {
using namespace slope_rows;

namespace {
/// A corner of a part of a triangle: in the face's (x, y, z), with the weights of the triangle's own corners.
struct Corner {
    vec3 at;
    vec2 weights;
};
const vec3& position_of(const Corner& corner) { return corner.at; }
Corner between(const Corner& from, const Corner& to, float share) {
    return {light_shafts::between(from.at, to.at, share), from.weights + share * (to.weights - from.weights)};
}
} // namespace

static std::size_t place_in_face(const DepthMapFace& face, const PartialOccluderInstance& instance,
                                 const OccluderBlock& block, std::size_t start, std::int32_t first, std::int32_t end,
                                 PlacedPartials& placed) {
    const DepthMapFace::FromObject at = face.from_object(*instance.scene_from_object);
    const Pyramid rows = face.seen_by(first, end);
    if (start == 0 && DepthMapFace::misses(rows, at, block.bounds))
        return block.count;
    for (; start < block.count && placed.count + DepthMapFace::most_triangles <= PlacedTriangles::capacity; ++start) {
        const std::array<vec3, 3> p{at(block.corner(start, 0)), at(block.corner(start, 1)), at(block.corner(start, 2))};
        if (rows.misses(p))
            continue;
        const std::array<Corner, 3> triangle{Corner{p[0], {0, 0}}, Corner{p[1], {1, 0}}, Corner{p[2], {0, 1}}};
        face.place(triangle, first, end, placed, [&](std::size_t t, std::size_t c, const Corner& corner) {
            const float per_z = 1.0f / corner.at.z;
            placed.triangle[t] = static_cast<std::int32_t>(start);
            placed.axy[3 * c][t] = per_z;
            placed.axy[3 * c + 1][t] = corner.at.x * per_z;
            placed.weight[c][t] = corner.weights.x * per_z;
            placed.weight[3 + c][t] = corner.weights.y * per_z;
            return placed.axy[3 * c + 2][t] = corner.at.y * per_z;
        });
    }
    return start;
}

void raster_partial_depth(DepthMap& map, const MapWindow& window, const PartialShading& shading,
                          const Progress& progress) {
    if (!map.is_perspective) {
        raster_partial(*map.texels, shading, progress);
        return;
    }
    const DepthMapFace face(map, window);
    raster_partial(*map.texels, shading, progress,
                   [&](const PartialOccluderInstance& instance, const OccluderBlock& block, std::size_t start,
                       std::int32_t first, std::int32_t end, PlacedPartials& placed) {
                       return place_in_face(face, instance, block, start, first, end, placed);
                   });
}
} // namespace tyndall::light_shafts
