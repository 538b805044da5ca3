// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that let a part of the light pass, in a light's depth map: at each texel a yes or a no, as in slope rows.
#include "light_shafts/depth_map.hpp"
#include <algorithm>
#include <array>
#include <span>

namespace tyndall::light_shafts {
using namespace slope_rows;

namespace {
/// A corner of a part of a triangle: in the face's (x, y, z), with the weights of the triangle's own corners.
struct Corner {
    vec3 at;
    vec2 weights;
};
/// A convex part of a triangle, clipped plane by plane.
class Part {
public:
    explicit Part(const std::array<Corner, 3>& triangle) : count_(3) { std::ranges::copy(triangle, corners_.begin()); }
    /// Keeps dot(normal, p) >= least. Based on: Sutherland and Hodgman 1974.
    void clip(const vec3& normal, float least) {
        std::array<Corner, 10> kept;
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Corner &from = corners_[i], &to = corners_[(i + 1) % count_];
            const float from_side = glm::dot(normal, from.at) - least, to_side = glm::dot(normal, to.at) - least;
            if (from_side >= 0.0f)
                kept[kept_count++] = from;
            if ((from_side >= 0.0f) != (to_side >= 0.0f)) {
                const float share = from_side / (from_side - to_side);
                kept[kept_count++] = {from.at + share * (to.at - from.at),
                                      from.weights + share * (to.weights - from.weights)};
            }
        }
        corners_ = kept;
        count_ = kept_count;
    }
    [[nodiscard]] std::size_t triangle_count() const { return count_ < 3 ? 0 : count_ - 2; }
    [[nodiscard]] const Corner& corner(std::size_t triangle, std::size_t i) const {
        return corners_[i == 0 ? 0 : triangle + i];
    }

private:
    std::array<Corner, 10> corners_;
    std::size_t count_;
};

/// A face of a cube, or of a narrow spot, as a place for triangles.
struct Face {
    const Layout& layout;
    mat3 from_scene;
    vec3 origin;
    vec2 low, high; ///< A little more than the window, so that triangles end outside.

    Face(const DepthMap& map, const MapWindow& window)
        : layout(map.texels->layout), from_scene(glm::transpose(mat3(map.x_axis, map.y_axis, map.z_axis))),
          origin(map.origin) {
        const vec2 margin = 0.01f * (window.max - window.min);
        low = window.min - margin;
        high = window.max + margin;
    }

    /// All the points lie outside of one side of what the rows [first, end) see, or behind the light.
    [[nodiscard]] bool misses(std::span<const vec3> points, std::int32_t first, std::int32_t end) const {
        const auto row_y = [&](std::int32_t row) {
            return layout.first_slice + static_cast<float>(row) * layout.slice_step;
        };
        const float low_y = std::max(low.y, row_y(first - 1)), high_y = std::min(high.y, row_y(end));
        unsigned outside = ~0u;
        for (const vec3& p : points)
            outside &= (p.z <= 0.0f ? 1u : 0u) | (p.x < low.x * p.z ? 2u : 0u) | (p.x > high.x * p.z ? 4u : 0u) |
                       (p.y < low_y * p.z ? 8u : 0u) | (p.y > high_y * p.z ? 16u : 0u);
        return outside != 0;
    }
    /// Nearer than 1e-6 of a triangle's own distance from the light, 1 / z has no digits left.
    void place(Part part, float farthest, std::int32_t index, std::int32_t first, std::int32_t end,
               PlacedPartials& placed) const {
        part.clip({0, 0, 1}, 1e-6f * farthest);
        part.clip({1, 0, -low.x}, 0.0f);
        part.clip({-1, 0, high.x}, 0.0f);
        part.clip({0, 1, -low.y}, 0.0f);
        part.clip({0, -1, high.y}, 0.0f);
        for (std::size_t t = 0; t < part.triangle_count(); ++t) {
            const std::size_t count = placed.count;
            float lowest = high.y, highest = low.y;
            for (std::size_t c = 0; c < 3; ++c) {
                const auto& [at, weights] = part.corner(t, c);
                const float per_z = 1.0f / at.z, y = at.y * per_z;
                placed.axy[3 * c][count] = per_z;
                placed.axy[3 * c + 1][count] = at.x * per_z;
                placed.axy[3 * c + 2][count] = y;
                placed.weight[c][count] = weights.x * per_z;
                placed.weight[3 + c][count] = weights.y * per_z;
                lowest = std::min(lowest, y);
                highest = std::max(highest, y);
            }
            placed.triangle[count] = index;
            placed.first_slice[count] = std::ceil((lowest - layout.first_slice) / layout.slice_step - 0.01f);
            placed.last_slice[count] = std::floor((highest - layout.first_slice) / layout.slice_step + 0.01f);
            placed.count += placed.first_slice[count] < static_cast<float>(end) &&
                            placed.last_slice[count] >= static_cast<float>(first);
        }
    }
};
} // namespace

void raster_partial_depth(DepthMap& map, const MapWindow& window, const PartialShading& shading,
                          const Progress& progress) {
    if (!map.is_perspective) {
        raster_partial(*map.texels, shading, progress);
        return;
    }
    const Face face(map, window);
    raster_partial(*map.texels, shading, progress,
                   [&](const PartialOccluderInstance& instance, const OccluderBlock& block, std::size_t start,
                       std::int32_t first, std::int32_t end, PlacedPartials& placed) {
                       constexpr std::size_t most_parts = 6; // of a triangle clipped by five planes
                       const mat4& scene_from_object = *instance.scene_from_object;
                       const mat3 face_from_object = face.from_scene * mat3(scene_from_object);
                       const vec3 offset = face.from_scene * (vec3(scene_from_object[3]) - face.origin);
                       const auto at = [&](const vec3& p) { return face_from_object * p + offset; };
                       if (start == 0) {
                           std::array<vec3, 8> box;
                           const auto& [min, max] = block.bounds;
                           for (std::size_t corner = 0; corner < 8; ++corner)
                               box[corner] = at({(corner & 1) != 0 ? max.x : min.x, (corner & 2) != 0 ? max.y : min.y,
                                                 (corner & 4) != 0 ? max.z : min.z});
                           if (face.misses(box, first, end))
                               return std::size_t{block.count};
                       }
                       for (; start < block.count && placed.count + most_parts <= PlacedTriangles::capacity; ++start) {
                           const std::array<vec3, 3> p{at(block.corner(start, 0)), at(block.corner(start, 1)),
                                                       at(block.corner(start, 2))};
                           if (face.misses(p, first, end))
                               continue;
                           const Part triangle({Corner{p[0], {0, 0}}, Corner{p[1], {1, 0}}, Corner{p[2], {0, 1}}});
                           face.place(triangle, std::max({p[0].z, p[1].z, p[2].z}), static_cast<std::int32_t>(start),
                                      first, end, placed);
                       }
                       return start;
                   });
}
} // namespace tyndall::light_shafts
