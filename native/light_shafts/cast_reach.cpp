// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/cast_reach.hpp"
#include "light_shafts/depth_map_face.hpp"
#include "light_shafts/local_support.hpp"
#include "light_shafts/slope_rows_placed_instance.hpp"
#include <cmath>

namespace tyndall::light_shafts {
using namespace slope_rows;

namespace {
/// What a lamp shines on, as far as it is convex and holds the lamp: what lies beside it shades nothing in it.
class LampReach {
public:
    explicit LampReach(const LightSample& light) : shape_(light) {}

    [[nodiscard]] bool may_touch(const Bounds3& box) const {
        if (shape_.has_normal && lies_below(box, shape_.normal, shape_.below_m))
            return false;
        for (std::size_t plane = 0; shape_.has_cell && plane < shape_.cell_normals.size(); ++plane)
            // A stratum beside its cell shines into it from outside.
            if (const double height = shape_.cell_heights[plane];
                height >= 0.0 && lies_below(box, shape_.cell_normals[plane], height))
                return false;
        return !(shape_.has_cone && shape_.cos_half >= 0.0 && misses_cone(box));
    }

private:
    [[nodiscard]] dvec3 from_lamp(const Bounds3& box, std::size_t corner) const {
        return dvec3(box.corner(corner)) - shape_.position;
    }
    [[nodiscard]] bool lies_below(const Bounds3& box, const dvec3& normal, double height) const {
        bool is_below = normal != dvec3(0.0);
        for (std::size_t corner = 0; corner < 8; ++corner)
            is_below = is_below && glm::dot(normal, from_lamp(box, corner)) + height < 0.0;
        return is_below;
    }
    /// By a ball around the box, where the cone is round.
    [[nodiscard]] bool misses_cone(const Bounds3& box) const {
        // The lobe of an area light's patch lies in the cone that begins so far behind it.
        const dvec3 to_apex = shape_.is_area ? -std::sqrt(shape_.softening_m2) * shape_.normal : dvec3(0.0);
        const dvec3 centre = shape_.cone_from_world * (dvec3(box.centre()) - shape_.position - to_apex);
        double radius = 0.0;
        for (std::size_t corner = 0; corner < 8; ++corner)
            radius =
                std::max(radius, glm::distance(shape_.cone_from_world * (from_lamp(box, corner) - to_apex), centre));
        const double distance = glm::length(centre);
        return radius < distance && std::acos(std::clamp(centre.z / distance, -1.0, 1.0)) >
                                        std::acos(shape_.cos_half) + std::asin(radius / distance);
    }

    LocalShape shape_;
};

Bounds3 grown(const Bounds3& box, float by_m) { return {box.min - by_m, box.max + by_m}; }

bool may_show(const Layout& layout, const Culling& culling, const Bounds3& box) {
    static const mat4 scene_from_scene(1.0f);
    const PlacedInstance at(layout.frame, scene_from_scene, box);
    return !at.needs(culling, box, 0, layout.slice_count()).is_empty();
}
} // namespace

MayShow in_map(const Layout& layout) {
    return [&layout, culling = Culling(layout)](const Bounds3& box) { return may_show(layout, culling, box); };
}

MayShow in_rows_of_map(const Layout& layout, const LightSample& light, float texel) {
    // A line reads a texel whose middle lies up to 0.71 texels beside it.
    if (light.is_directional)
        return [&layout, culling = Culling(layout), texel](const Bounds3& box) {
            return may_show(layout, culling, grown(box, texel));
        };
    // A ray at the border of the light reads the nearest slice and line.
    const float beside = texel + layout.slice_step + layout.line_step + 1e-4f;
    return [&layout, culling = Culling(layout), texel, beside, reach = LampReach(light),
            position = light.position](const Bounds3& box) {
        const float farthest_m = glm::distance(box.centre(), position) + 0.5f * box.diagonal_m();
        return reach.may_touch(grown(box, beside * farthest_m)) &&
               may_show(layout, culling, grown(box, texel * farthest_m));
    };
}

MayShow in_rows(const Layout& layout, const LightSample& light) { return in_rows_of_map(layout, light, 0.0f); }

MayShow in_face(const DepthMap& map, const MapWindow& window) {
    const DepthMapFace face(map, window);
    return [at = face.from_object(mat4(1.0f)), all = face.seen_by_all()](const Bounds3& box) {
        return !DepthMapFace::misses(all, at, box);
    };
}
} // namespace tyndall::light_shafts
