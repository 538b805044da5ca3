// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/tube_mesh.hpp"
#include "scene/embree.hpp"
#include "scene/strand_bends.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
static constexpr std::size_t side_count = 6;

using Ring = std::array<vec3, side_count>;

static Ring ring_at(const StrandPoint& at) {
    // A ring's corners lie as far out as makes its circumference that of the tube.
    const float radius_m = at.radius_m * pi / (static_cast<float>(side_count) * std::sin(pi / side_count));
    const auto [first, second] = orthonormal_basis(unit_or(at.tangent, vec3(0, 0, 1)));
    Ring ring;
    for (std::size_t side = 0; side < side_count; ++side) {
        const float angle = 2.0f * pi * static_cast<float>(side) / static_cast<float>(side_count);
        ring[side] = at.centre + radius_m * (std::cos(angle) * first + std::sin(angle) * second);
    }
    return ring;
}

static void join(const Ring& from, const Ring& to, std::span<TriangleBvh::Triangle> triangles) {
    for (std::size_t side = 0; side < side_count; ++side) {
        const std::size_t next = (side + 1) % side_count;
        triangles[2 * side] = {from[side], from[next], to[next]};
        triangles[2 * side + 1] = {from[side], to[next], to[side]};
    }
}

/// Its surface is 4 pi.
static std::vector<TriangleBvh::Triangle> unit_sphere() {
    const float golden = std::numbers::phi_v<float>;
    std::vector<vec3> corners; // of an icosahedron
    for (const float one : {-1.0f, 1.0f})
        for (const float other : {-golden, golden})
            for (int axis = 0; axis < 3; ++axis) {
                vec3 corner(0.0f);
                corner[axis] = one, corner[(axis + 1) % 3] = other;
                corners.push_back(glm::normalize(corner));
            }
    // Its faces are all the triples of neighbours.
    const auto is_near = [](const vec3& a, const vec3& b) { return glm::dot(a, b) > 0.4f; };
    const auto middle = [](const vec3& a, const vec3& b) { return glm::normalize(a + b); }; // the same for b and a
    std::vector<TriangleBvh::Triangle> fine;
    float surface = 0.0f;
    const auto cut = [&](const vec3& a, const vec3& b, const vec3& c) {
        const vec3 ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
        for (const TriangleBvh::Triangle& part :
             {TriangleBvh::Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
            fine.push_back(part);
            surface += 0.5f * glm::length(glm::cross(part[1] - part[0], part[2] - part[0]));
        }
    };
    for (std::size_t a = 0; a < corners.size(); ++a)
        for (std::size_t b = a + 1; b < corners.size(); ++b)
            for (std::size_t c = b + 1; c < corners.size(); ++c)
                if (is_near(corners[a], corners[b]) && is_near(corners[b], corners[c]) &&
                    is_near(corners[a], corners[c]))
                    cut(corners[a], corners[b], corners[c]);
    for (TriangleBvh::Triangle& triangle : fine)
        for (vec3& corner : triangle)
            corner *= std::sqrt(4.0f * std::numbers::pi_v<float> / surface);
    return fine;
}

TubeMesh::TubeMesh(const Strands& strands) : strands_(strands), triangles_per_piece_(2 * side_count) {
    if (strands.form() == StrandForm::Spheres) {
        unit_sphere_ = unit_sphere();
        triangles_per_piece_ = unit_sphere_.size();
    }
    if (!strands.are_splines())
        return;
    StrandBends bends(strands);
    for (std::uint32_t strand = 0; strand < strands.strand_count(); ++strand) {
        const std::span<const StrandPoint> points = bends.of(strand);
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
            pieces_.push_back({points[i], points[i + 1]});
    }
}

void TubeMesh::write(std::size_t piece, std::span<TriangleBvh::Triangle> triangles) const {
    const auto segment = static_cast<std::uint32_t>(piece);
    if (strands_.form() == StrandForm::Spheres) {
        const StrandPoint at = strands_.on_spline(segment, 0.0f);
        std::ranges::transform(unit_sphere_, triangles.begin(), [&](TriangleBvh::Triangle triangle) {
            for (vec3& corner : triangle)
                corner = at.centre + at.radius_m * corner;
            return triangle;
        });
    } else if (strands_.are_splines()) {
        // Both rings have the same frame, but for how far the strand turns.
        join(ring_at(pieces_[piece][0]), ring_at(pieces_[piece][1]), triangles);
    } else {
        join(ring_at(strands_.on_spline(segment, 0.0f)), ring_at(strands_.on_spline(segment, 1.0f)), triangles);
    }
}

TriangleBvh TubeMesh::bvh(const Progress& progress) const {
    const auto write_group = [&](std::size_t group, std::span<TriangleBvh::Triangle> triangles) {
        write(group, triangles);
    };
    return {embree_device(), piece_count(), triangles_per_piece_, write_group, progress};
}
} // namespace tyndall
