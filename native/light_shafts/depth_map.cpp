// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/depth_map.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
using namespace slope_rows;

static Layout layout_of(const DepthMap& map, const MapWindow& window, std::uint32_t resolution) {
    Layout layout;
    Frame& frame = layout.frame;
    frame.origin = map.origin;
    frame.u = map.x_axis;
    frame.v = map.y_axis;
    frame.axis = map.z_axis;
    frame.is_parallel = true;
    frame.x = {0, 0, 1};
    frame.y = {0, 1, 0};
    frame.w = {1, 0, 0};
    const auto texels = static_cast<float>(resolution);
    const vec2 step = glm::max(window.max - window.min, vec2(1e-30f)) / texels;
    layout.line_step = step.x;
    layout.first_line = window.min.x;
    layout.slice_step = step.y;
    layout.first_slice = window.min.y + 0.5f * step.y;
    layout.line_count = static_cast<std::int32_t>(resolution);
    const std::int32_t padded = (layout.line_count + block_lines - 1) / block_lines * block_lines;
    layout.rows.resize(resolution);
    layout.slice_directions.assign(resolution, vec2(1, 0));
    for (std::size_t y = 0; y < layout.rows.size(); ++y)
        layout.rows[y] = {
            .first = 0, .end = padded, .offset = y * static_cast<std::size_t>(padded), .smallest_slope = no_occluder};
    for (std::int32_t x = 0; x < padded; ++x)
        layout.x_at_centre.push_back(layout.first_line + (static_cast<float>(x) + 0.5f) * layout.line_step);
    layout.sample_count = layout.rows.size() * static_cast<std::size_t>(padded);
    return layout;
}

namespace {
/// A convex polygon in a face's (x, y, z), clipped plane by plane.
class FacePolygon {
public:
    FacePolygon(const vec3& a, const vec3& b, const vec3& c) : count_(3) {
        corners_[0] = a;
        corners_[1] = b;
        corners_[2] = c;
    }
    /// Keeps dot(normal, p) >= least. Based on: Sutherland and Hodgman 1974.
    void clip(const vec3& normal, float least) {
        std::array<vec3, 10> kept;
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const vec3 &from = corners_[i], &to = corners_[(i + 1) % count_];
            const float from_side = glm::dot(normal, from) - least, to_side = glm::dot(normal, to) - least;
            if (from_side >= 0.0f)
                kept[kept_count++] = from;
            if ((from_side >= 0.0f) != (to_side >= 0.0f))
                kept[kept_count++] = from + from_side / (from_side - to_side) * (to - from);
        }
        corners_ = kept;
        count_ = kept_count;
    }
    [[nodiscard]] std::size_t triangle_count() const { return count_ < 3 ? 0 : count_ - 2; }
    [[nodiscard]] const vec3& corner(std::size_t triangle, std::size_t i) const {
        return corners_[i == 0 ? 0 : triangle + i];
    }

private:
    std::array<vec3, 10> corners_;
    std::size_t count_;
};
} // namespace

namespace {
/// The sides of a face's pyramid: inside where dot(normal, p) >= 0.
struct Pyramid {
    std::array<vec3, 4> normals;
    Pyramid(const vec2& low, const vec2& high)
        : normals{vec3(1, 0, -low.x), vec3(-1, 0, high.x), vec3(0, 1, -low.y), vec3(0, -1, high.y)} {}
    /// A bit per side that the point lies outside of, and one for behind the light.
    [[nodiscard]] unsigned sides_outside(const vec3& p, float least_z) const {
        unsigned bits = p.z >= least_z ? 0 : 1;
        for (std::size_t side = 0; side < normals.size(); ++side)
            bits |= glm::dot(normals[side], p) >= 0.0f ? 0 : 2u << side;
        return bits;
    }
};
} // namespace

/// Clips triangles to the face's pyramid and puts them into (1/z, x/z, y/z).
static std::size_t place_in_face(const DepthMap& map, const MapWindow& window, const OccluderInstance& instance,
                                 const OccluderBlock& block, std::size_t start, std::int32_t first, std::int32_t end,
                                 PlacedTriangles& placed) {
    constexpr std::size_t most_triangles = 6; // of a triangle clipped by five planes
    const Layout& layout = map.texels->layout;
    const mat4& scene_from_object = *instance.scene_from_object;
    const mat3 face_from_scene = glm::transpose(mat3(map.x_axis, map.y_axis, map.z_axis));
    const mat3 face_from_object = face_from_scene * mat3(scene_from_object);
    const vec3 offset = face_from_scene * (vec3(scene_from_object[3]) - map.origin);
    // A little more than the window, so that triangles end outside; nearer than 1e-6 of a triangle's own distance from
    // the light, 1/z has no digits left.
    const vec2 margin = 0.01f * (window.max - window.min), low = window.min - margin, high = window.max + margin;
    const Pyramid pyramid(low, high);
    // What lies outside of one side with all its corners is nowhere inside; a block ends here at once.
    const auto row_y = [&](std::int32_t row) {
        return layout.first_slice + static_cast<float>(row) * layout.slice_step;
    };
    const Pyramid rows({low.x, std::max(low.y, row_y(first - 1))}, {high.x, std::min(high.y, row_y(end))});
    unsigned all_outside = ~0u;
    for (std::size_t corner = 0; start == 0 && corner < 8; ++corner) {
        const vec3 at((corner & 1) != 0 ? block.bounds.max.x : block.bounds.min.x,
                      (corner & 2) != 0 ? block.bounds.max.y : block.bounds.min.y,
                      (corner & 4) != 0 ? block.bounds.max.z : block.bounds.min.z);
        all_outside &= rows.sides_outside(face_from_object * at + offset, 0.0f);
    }
    if (start == 0 && all_outside != 0)
        return block.count;
    for (; start < block.count && placed.count + most_triangles <= PlacedTriangles::capacity; ++start) {
        std::array<vec3, 3> p;
        for (std::size_t c = 0; c < 3; ++c)
            p[c] = face_from_object * block.corner(start, c) + offset;
        const float farthest = std::max(p[0].z, std::max(p[1].z, p[2].z));
        if (!(farthest > 0.0f) ||
            (rows.sides_outside(p[0], 0.0f) & rows.sides_outside(p[1], 0.0f) & rows.sides_outside(p[2], 0.0f)) != 0)
            continue;
        FacePolygon polygon(p[0], p[1], p[2]);
        const float least_z = 1e-6f * farthest;
        if ((pyramid.sides_outside(p[0], least_z) | pyramid.sides_outside(p[1], least_z) |
             pyramid.sides_outside(p[2], least_z)) != 0) {
            polygon.clip({0, 0, 1}, least_z);
            for (const vec3& normal : pyramid.normals)
                polygon.clip(normal, 0.0f);
        }
        for (std::size_t t = 0; t < polygon.triangle_count(); ++t) {
            const std::size_t count = placed.count;
            float lowest = high.y, highest = low.y;
            for (std::size_t c = 0; c < 3; ++c) {
                const vec3& corner = polygon.corner(t, c);
                const float y = corner.y / corner.z;
                placed.axy[3 * c][count] = 1.0f / corner.z;
                placed.axy[3 * c + 1][count] = corner.x / corner.z;
                placed.axy[3 * c + 2][count] = y;
                lowest = std::min(lowest, y);
                highest = std::max(highest, y);
            }
            placed.first_slice[count] = std::ceil((lowest - layout.first_slice) / layout.slice_step - 0.01f);
            placed.last_slice[count] = std::floor((highest - layout.first_slice) / layout.slice_step + 0.01f);
            placed.count += placed.first_slice[count] < static_cast<float>(end) &&
                            placed.last_slice[count] >= static_cast<float>(first);
        }
    }
    return start;
}

void raster_depth(DepthMap& map, const MapWindow& window, std::uint32_t resolution, const Occluders& occluders,
                  const Progress& progress) {
    map.texels = std::make_unique<Rows>(layout_of(map, window, resolution));
    Placer placer;
    if (map.is_perspective)
        placer = [&](const OccluderInstance& instance, const OccluderBlock& block, std::size_t start,
                     std::int32_t first, std::int32_t end, PlacedTriangles& placed) {
            return place_in_face(map, window, instance, block, start, first, end, placed);
        };
    raster(*map.texels, occluders, progress, placer);
}
} // namespace tyndall::light_shafts
