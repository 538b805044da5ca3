// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/shape_faces.hpp"
#include <algorithm>
#include <array>
#include <map>

namespace tyndall::light_shafts {
using namespace slope_rows;

namespace {
/// Gathers the faces of cells. Two cells that touch have the same face, with the same floats: neither shows it.
class FaceGatherer final : public CellVisitor {
public:
    bool enters(const Bounds3&) override { return true; }
    void meet(const Bounds3& cell) override {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const bool is_upper : {false, true}) {
                Face face;
                for (std::size_t i = 0; i < 4; ++i) {
                    const std::size_t first = std::size_t{1} << (axis + 1) % 3,
                                      second = std::size_t{1} << (axis + 2) % 3;
                    const std::size_t corner =
                        (is_upper ? std::size_t{1} << axis : 0) | (i & 1) * first | (i >> 1) * second;
                    const vec3 at = cell.corner(corner);
                    face[i] = {at.x, at.y, at.z};
                }
                if (const auto [known, is_new] = faces_.try_emplace(face, 1); !is_new)
                    ++known->second;
            }
    }
    void triangulate(std::vector<vec3>& positions, std::vector<uvec3>& triangles) const {
        for (const auto& [face, count] : faces_) {
            if (count > 1)
                continue;
            const auto first = static_cast<std::uint32_t>(positions.size());
            for (const auto& [x, y, z] : face)
                positions.emplace_back(x, y, z);
            triangles.emplace_back(first, first + 1, first + 3);
            triangles.emplace_back(first, first + 3, first + 2);
        }
    }

private:
    using Face = std::array<std::array<float, 3>, 4>;
    std::map<Face, int> faces_;
};
} // namespace

std::unique_ptr<const OccluderMesh> make_face_mesh(const CellShape& shape) {
    FaceGatherer gatherer;
    shape.visit(gatherer);
    std::vector<vec3> positions;
    std::vector<uvec3> triangles;
    gatherer.triangulate(positions, triangles);
    return make_occluder_mesh(positions, triangles);
}

LightLine light_line(const Layout& layout, float highest_axial, std::int32_t slice, std::int32_t line) {
    const Frame& frame = layout.frame;
    // Beyond the last line there is padding, where an angle would exceed half a turn.
    const auto index = static_cast<float>(std::min(line, layout.line_count - 1));
    const float at = layout.first_line + (index + 0.5f) * layout.line_step;
    vec2 start, way; // axial and radial
    LightLine result;
    if (frame.is_angular) {
        start = {frame.light_axial(), 0.0f};
        way = frame.line_direction(at);
        result.ray.near_m = layout.smallest_radius_cut / std::max(way.y, 1e-6f);
    } else {
        start = {highest_axial, at};
        way = {-1.0f, 0.0f};
    }
    const vec2 turn = layout.slice_directions[static_cast<std::size_t>(slice)];
    // Metres per number along an axis: the axes of a frame that counts texels are longer than 1.
    const vec3 u = frame.u / glm::dot(frame.u, frame.u), v = frame.v / glm::dot(frame.v, frame.v);
    const vec3 radial = turn.x * u + turn.y * v;
    const float across = frame.is_parallel ? layout.first_slice + static_cast<float>(slice) * layout.slice_step : 0.0f;
    result.ray.origin = frame.origin + (start.x * frame.axis + start.y * radial + across * v);
    result.ray.direction = way.x * frame.axis + way.y * radial;
    result.y = {frame.y.at(start.x, start.y), frame.y.per_axial * way.x + frame.y.per_radial * way.y};
    result.w = {frame.w.at(start.x, start.y), frame.w.per_axial * way.x + frame.w.per_radial * way.y};
    return result;
}

float above(const Frame& frame, const Bounds3& bounds) {
    float highest = -std::numeric_limits<float>::infinity();
    for (std::size_t corner = 0; corner < 8; ++corner)
        highest = std::max(highest, glm::dot(frame.axis, bounds.corner(corner) - frame.origin));
    return highest + 1e-4f * (std::abs(highest) + bounds.diagonal_m());
}

LightLine light_line(const DepthMap& map, std::int32_t slice, std::int32_t line) {
    const Layout& layout = map.texels->layout;
    const float x = layout.first_line + (static_cast<float>(line) + 0.5f) * layout.line_step;
    const float y = layout.first_slice + static_cast<float>(slice) * layout.slice_step;
    return {.ray = {.origin = map.origin, .direction = map.z_axis + x * map.x_axis + y * map.y_axis},
            .y = {1.0f, 0.0f},
            .w = {0.0f, 1.0f}};
}
} // namespace tyndall::light_shafts
