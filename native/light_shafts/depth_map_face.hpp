// SPDX-License-Identifier: GPL-3.0-or-later
// A perspective face of a depth map as a place for triangles: which of them it sees, and what of them lies in it.
// Based on: Sutherland and Hodgman, Reentrant Polygon Clipping, CACM 17(1), 1974.
// Bound:    a triangle that lies inside of the face with all its corners is not clipped; one that no row sees ends here.
#pragma once
#include "light_shafts/depth_map.hpp"
#include <algorithm>
#include <array>
#include <span>

namespace tyndall::light_shafts {
inline const vec3& position_of(const vec3& corner) { return corner; }
inline vec3 between(const vec3& from, const vec3& to, float share) { return from + share * (to - from); }

/// A convex polygon, clipped plane by plane. A Corner has a position_of it, and one between two of them at a share of the
/// way.
template <class Corner>
class ClippedPolygon {
public:
    explicit ClippedPolygon(const std::array<Corner, 3>& triangle) : count_(3) {
        std::ranges::copy(triangle, corners_.begin());
    }
    /// Keeps dot(normal, p) >= least.
    void clip(const vec3& normal, float least) {
        std::array<Corner, 10> kept;
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Corner &from = corners_[i], &to = corners_[(i + 1) % count_];
            const float from_side = glm::dot(normal, position_of(from)) - least,
                        to_side = glm::dot(normal, position_of(to)) - least;
            if (from_side >= 0.0f)
                kept[kept_count++] = from;
            if ((from_side >= 0.0f) != (to_side >= 0.0f))
                kept[kept_count++] = between(from, to, from_side / (from_side - to_side));
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

/// The sides of a face's pyramid, or of a part of it: inside where dot(normal, p) >= 0.
struct Pyramid {
    std::array<vec3, 4> normals;
    Pyramid(const vec2& low, const vec2& high)
        : normals{vec3(1, 0, -low.x), vec3(-1, 0, high.x), vec3(0, 1, -low.y), vec3(0, -1, high.y)} {}
    /// A bit per side that the point lies outside of.
    [[nodiscard]] unsigned sides_outside(const vec3& p) const {
        unsigned bits = 0;
        for (std::size_t side = 0; side < normals.size(); ++side)
            bits |= glm::dot(normals[side], p) >= 0.0f ? 0 : 1u << side;
        return bits;
    }
    /// All the points lie outside of one side, or behind the light.
    [[nodiscard]] bool misses(std::span<const vec3> points) const {
        constexpr unsigned behind = 1u << 4;
        unsigned outside = ~0u;
        for (const vec3& p : points)
            outside &= sides_outside(p) | (p.z > 0.0f ? 0 : behind);
        return outside != 0;
    }
};

class DepthMapFace {
public:
    static constexpr std::size_t most_triangles = 6; ///< Of a triangle clipped by five planes.

    DepthMapFace(const DepthMap& map, const MapWindow& window)
        : layout_(map.texels->layout), from_scene_(glm::transpose(mat3(map.x_axis, map.y_axis, map.z_axis))),
          origin_(map.origin), low_(window.min - 0.01f * (window.max - window.min)),
          high_(window.max + 0.01f * (window.max - window.min)), pyramid_(low_, high_) {}

    /// From an object's space to the face's (x, y, z).
    struct FromObject {
        mat3 turn;
        vec3 offset;
        [[nodiscard]] vec3 operator()(const vec3& p) const { return turn * p + offset; }
    };
    [[nodiscard]] FromObject from_object(const mat4& scene_from_object) const {
        return {from_scene_ * mat3(scene_from_object), from_scene_ * (vec3(scene_from_object[3]) - origin_)};
    }

    /// What the rows [first, end) see.
    [[nodiscard]] Pyramid seen_by(std::int32_t first, std::int32_t end) const {
        const auto row_y = [&](std::int32_t row) {
            return layout_.first_slice + static_cast<float>(row) * layout_.slice_step;
        };
        return {{low_.x, std::max(low_.y, row_y(first - 1))}, {high_.x, std::min(high_.y, row_y(end))}};
    }
    /// What any row sees, and a little more.
    [[nodiscard]] const Pyramid& seen_by_all() const { return pyramid_; }
    [[nodiscard]] static bool misses(const Pyramid& pyramid, const FromObject& at, const Bounds3& box) {
        std::array<vec3, 8> corners;
        for (std::size_t corner = 0; corner < corners.size(); ++corner)
            corners[corner] = at(box.corner(corner));
        return pyramid.misses(corners);
    }

    /// Appends what of a triangle lies in the face and may touch the rows [first, end), as triangles: `keep` puts a corner
    /// into the columns of `placed`, at a number of a triangle and of its corner, and returns its y / z.
    template <class Corner, class Keep>
    void place(const std::array<Corner, 3>& triangle, std::int32_t first, std::int32_t end,
               slope_rows::PlacedTriangles& placed, const Keep& keep) const {
        const vec3 &a = position_of(triangle[0]), &b = position_of(triangle[1]), &c = position_of(triangle[2]);
        // Nearer than 1e-6 of a triangle's own distance from the light, 1 / z has no digits left.
        const float least_z = 1e-6f * std::max({a.z, b.z, c.z});
        ClippedPolygon polygon(triangle);
        if (std::min({a.z, b.z, c.z}) < least_z ||
            (pyramid_.sides_outside(a) | pyramid_.sides_outside(b) | pyramid_.sides_outside(c)) != 0) {
            polygon.clip({0, 0, 1}, least_z);
            for (const vec3& normal : pyramid_.normals)
                polygon.clip(normal, 0.0f);
        }
        for (std::size_t t = 0; t < polygon.triangle_count(); ++t) {
            const std::size_t at = placed.count;
            float lowest = high_.y, highest = low_.y;
            for (std::size_t i = 0; i < 3; ++i) {
                const float y = keep(at, i, polygon.corner(t, i));
                lowest = std::min(lowest, y);
                highest = std::max(highest, y);
            }
            placed.first_slice[at] = std::ceil((lowest - layout_.first_slice) / layout_.slice_step - 0.01f);
            placed.last_slice[at] = std::floor((highest - layout_.first_slice) / layout_.slice_step + 0.01f);
            placed.count +=
                placed.first_slice[at] < static_cast<float>(end) && placed.last_slice[at] >= static_cast<float>(first);
        }
    }

private:
    const slope_rows::Layout& layout_;
    mat3 from_scene_;
    vec3 origin_;
    vec2 low_, high_; ///< A little more than the window, so that triangles end outside.
    Pyramid pyramid_;
};
} // namespace tyndall::light_shafts
