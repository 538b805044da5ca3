// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strip_shapes.hpp"
#include <array>
#include <limits>

namespace tyndall::light_shafts {
namespace {
/// Points where a plane crosses the edges of a box, in the plane's (x, y); of a hexagon at most.
class BoxCut {
public:
    BoxCut(const PlaneCoordinates<double>& plane, const Bounds3& box) {
        std::array<double, 8> height;
        unsigned above = 0;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            height[corner] = plane.height(dvec3(box.corner(corner)));
            above |= static_cast<unsigned>(height[corner] >= 0.0) << corner; // 0 is above, as for triangles
        }
        if (above == 0 || above == 0xff)
            return;
        for (std::size_t from = 0; from < 8; ++from)
            for (std::size_t axis = 1; axis < 8; axis *= 2) {
                const std::size_t to = from | axis;
                if (to == from || (above >> from & 1) == (above >> to & 1))
                    continue;
                const dvec3 a(box.corner(from)), b(box.corner(to));
                const double per_rise = 1.0 / (height[from] - height[to]);
                const auto between = [&](const Covector<double>& along) {
                    return (along(b) * height[from] - along(a) * height[to]) * per_rise;
                };
                points_[count_++] = {between(plane.x), between(plane.y)};
            }
    }
    [[nodiscard]] std::span<const dvec2> points() const { return {points_.data(), count_}; }

private:
    std::array<dvec2, 6> points_;
    std::size_t count_ = 0;
};

/// What the light casts of a convex polygon that lies between the ray and the light.
class CastInterval {
public:
    CastInterval(const StripRay& ray, std::span<const dvec2> points)
        : ray_(ray), top_(ray.is_local ? double{ray.light_y} * (1.0 - 1e-6) : infinite) {
        bool is_towards_light = false;
        for (const dvec2& point : points)
            is_towards_light |= point.y > 0.0 && point.y < top_;
        if (!is_towards_light && !crosses(points))
            return;
        for (const dvec2& point : points)
            if (point.y >= 0.0 && point.y <= top_)
                grow(point);
        // Between any two corners the line stays in the polygon: its ends on the ray, and at the light's height, count.
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) {
                grow_at(points[i], points[j], 0.0);
                if (ray_.is_local)
                    grow_at(points[i], points[j], top_);
            }
    }
    [[nodiscard]] bool is_empty() const { return !(near_m_ < far_m_); }
    [[nodiscard]] float near_m() const { return static_cast<float>(near_m_); }
    [[nodiscard]] float far_m() const { return static_cast<float>(far_m_); }

private:
    static constexpr double infinite = std::numeric_limits<double>::infinity();

    /// Some points lie below the ray and others above the light, and none between.
    [[nodiscard]] bool crosses(std::span<const dvec2> points) const {
        bool is_below = false, is_above = false;
        for (const dvec2& point : points) {
            is_below |= point.y <= 0.0;
            is_above |= point.y >= top_;
        }
        return is_below && is_above;
    }
    void grow(const dvec2& point) {
        const double at = ray_.is_local
                              ? point.x + point.y * (point.x - double{ray_.light_x}) / (double{ray_.light_y} - point.y)
                              : point.x - double{ray_.cotangent} * point.y;
        near_m_ = std::min(near_m_, at);
        far_m_ = std::max(far_m_, at);
    }
    void grow_at(const dvec2& a, const dvec2& b, double y) {
        if ((a.y < y) == (b.y < y))
            return;
        grow({(b.x * (a.y - y) - a.x * (b.y - y)) / (a.y - b.y), y});
    }

    const StripRay& ray_;
    double top_;
    double near_m_ = infinite, far_m_ = -infinite;
};

class ShadowFinder final : public CellVisitor {
public:
    ShadowFinder(const PlaneCoordinates<double>& plane, const StripRay& ray, ShadowUnion& shadow)
        : plane_(plane), ray_(ray), shadow_(shadow) {}
    bool enters(const Bounds3& box) override {
        if (shadow_.is_complete())
            return false;
        const CastInterval cast(ray_, BoxCut(plane_, box).points());
        return !cast.is_empty() && !shadow_.covers(cast.near_m(), cast.far_m());
    }
    void meet(const Bounds3& cell) override {
        const CastInterval cast(ray_, BoxCut(plane_, cell).points());
        if (!cast.is_empty())
            shadow_.insert(cast.near_m(), cast.far_m());
    }

private:
    const PlaneCoordinates<double>& plane_;
    const StripRay& ray_;
    ShadowUnion& shadow_;
};
} // namespace

void add_shape_shadows(const CellShape& shape, const mat4& scene_from_object, const StripRay& ray,
                       ShadowUnion& shadow) {
    const PlaneCoordinates<double> plane = ray.coordinates.in_object(scene_from_object);
    ShadowFinder finder(plane, ray, shadow);
    shape.visit(finder);
}
} // namespace tyndall::light_shafts
