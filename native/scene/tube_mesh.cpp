// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/tube_mesh.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace tyndall {
static constexpr std::size_t side_count = 6;
static constexpr std::size_t pieces_of_spline = 4;

static void add_ring(MeshArrays& mesh, const StrandPoint& at) {
    // A ring's corners lie as far out as makes its circumference that of the tube.
    const float radius_m = at.radius_m * pi / (static_cast<float>(side_count) * std::sin(pi / side_count));
    const auto [first, second] = orthonormal_basis(unit_or(at.tangent, vec3(0, 0, 1)));
    for (std::size_t side = 0; side < side_count; ++side) {
        const float angle = 2.0f * pi * static_cast<float>(side) / static_cast<float>(side_count);
        mesh.positions.push_back(at.centre + radius_m * (std::cos(angle) * first + std::sin(angle) * second));
    }
}

/// Between the last two rings.
static void join_rings(MeshArrays& mesh) {
    const auto from = static_cast<std::uint32_t>(mesh.positions.size() - 2 * side_count);
    for (std::uint32_t side = 0; side < side_count; ++side) {
        const auto next = static_cast<std::uint32_t>((side + 1) % side_count);
        mesh.triangles.emplace_back(from + side, from + next, from + side_count + next);
        mesh.triangles.emplace_back(from + side, from + side_count + next, from + side_count + side);
    }
}

namespace {
struct UnitSphere {
    std::vector<vec3> corners;
    std::vector<uvec3> triangles;
};
} // namespace

/// Its surface is 4 pi.
static UnitSphere unit_sphere() {
    const float golden = std::numbers::phi_v<float>;
    UnitSphere coarse;
    for (const float one : {-1.0f, 1.0f})
        for (const float other : {-golden, golden})
            for (int axis = 0; axis < 3; ++axis) {
                vec3 corner(0.0f);
                corner[axis] = one, corner[(axis + 1) % 3] = other;
                coarse.corners.push_back(glm::normalize(corner));
            }
    // An icosahedron's faces are all the triples of neighbours.
    const auto is_near = [&](std::size_t a, std::size_t b) {
        return glm::dot(coarse.corners[a], coarse.corners[b]) > 0.4f;
    };
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c)
                if (is_near(a, b) && is_near(b, c) && is_near(a, c))
                    coarse.triangles.emplace_back(a, b, c);
    UnitSphere fine{.corners = coarse.corners, .triangles = {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [found, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(fine.corners.size()));
        if (is_new)
            fine.corners.push_back(glm::normalize(coarse.corners[a] + coarse.corners[b]));
        return found->second;
    };
    float surface = 0.0f;
    for (const uvec3& face : coarse.triangles) {
        const std::uint32_t ab = middle(face.x, face.y), bc = middle(face.y, face.z), ca = middle(face.z, face.x);
        for (const uvec3& part :
             {uvec3(face.x, ab, ca), uvec3(ab, face.y, bc), uvec3(ca, bc, face.z), uvec3(ab, bc, ca)}) {
            fine.triangles.push_back(part);
            surface += 0.5f * glm::length(glm::cross(fine.corners[part.y] - fine.corners[part.x],
                                                     fine.corners[part.z] - fine.corners[part.x]));
        }
    }
    for (vec3& corner : fine.corners)
        corner *= std::sqrt(4.0f * std::numbers::pi_v<float> / surface);
    return fine;
}

StrandTubes::StrandTubes(const SharedMeshArrays& arrays, const Progress& progress)
    : bvh(embree_device(), arrays, progress) {
    for (const vec3& position : arrays.positions)
        bounds.grow(position);
}

MeshArrays tube_mesh(const Strands& strands) {
    MeshArrays mesh{.name = strands.name()};
    const auto segment_count = static_cast<std::uint32_t>(strands.segment_count());
    if (strands.form() == StrandForm::Spheres) {
        const UnitSphere sphere = unit_sphere();
        for (std::uint32_t index = 0; index < segment_count; ++index) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            const StrandPoint at = strands.on_spline(index, 0.0f);
            for (const vec3& corner : sphere.corners)
                mesh.positions.push_back(at.centre + at.radius_m * corner);
            for (const uvec3& triangle : sphere.triangles)
                mesh.triangles.push_back(triangle + first);
        }
        return mesh;
    }
    const std::size_t pieces = strands.form() == StrandForm::RoundLinear ? 1 : pieces_of_spline;
    for (std::uint32_t segment = 0; segment < segment_count; ++segment)
        for (std::size_t piece = 0; piece <= pieces; ++piece) {
            // Every ring of a segment has the frame of the one before, but for how far the strand turns.
            add_ring(mesh, strands.on_spline(segment, static_cast<float>(piece) / static_cast<float>(pieces)));
            if (piece > 0)
                join_rings(mesh);
        }
    return mesh;
}
} // namespace tyndall
