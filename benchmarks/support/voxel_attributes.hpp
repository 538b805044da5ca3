// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes for the voxels of a mesh, in Morton order: what attribute arrays are measured on.
//   normals: vertex normals (means of faces by area) at the point of the triangle that the voxel's centre is projected
//            to along the triangle's largest axis, in 6 + 6 bits: (v / 2 + 1 / 2) * 63, rounded, of the octahedral map
//   baked:   4 + 4 + 4 bits, red first, of check * marble * lambert: check 1 or 0.55, of 16 x 16 x 16 cubes; marble from (0.9,
//            0.85, 0.75) to (0.3, 0.45, 0.6) as 1/2 + 1/2 sin(120 x + 18 sin 14 y + 12 sin 17 z), x, y, z in [0, 1];
//            lambert = 1/4 + 3/4 max(0, n . (0.48, 0.36, 0.8))
// AttributeBits::Full: the same in octahedral::encode_rounded()'s 32 bits, and in 8 + 8 + 8.
// Of several triangles in a voxel the first counts. A voxel that this finds no triangle for (its arithmetic is not that of
// the voxelizer) has the values of the voxel before it: 1 in 1,200 of the dragon, 1 in 3,900 of Sponza.
#pragma once
#include "support/voxel_meshes.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::bench {
struct VoxelAttributes {
    std::vector<std::uint32_t> normals, baked;
    std::size_t orphan_count = 0; ///< Voxels that have the values of the one before.
};

inline std::uint32_t rounded(double value, std::uint32_t bits) { // of [0, 1]
    return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 1.0) * ((1u << bits) - 1)));
}
inline std::uint32_t normal_of_12_bits(const dvec3& n) {
    const double scale = 1.0 / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    dvec2 at{n.x * scale, n.y * scale};
    if (n.z < 0.0)
        at = {(1.0 - std::abs(at.y)) * (at.x < 0.0 ? -1.0 : 1.0), (1.0 - std::abs(at.x)) * (at.y < 0.0 ? -1.0 : 1.0)};
    return rounded(0.5 * at.x + 0.5, 6) << 6 | rounded(0.5 * at.y + 0.5, 6);
}
inline double check_at(const dvec3& at) {
    const dvec3 cube = glm::floor(16.0 * at);
    return std::fmod(cube.x + cube.y + cube.z, 2.0) == 0.0 ? 1.0 : 0.55;
}
inline double vein_at(const dvec3& at) {
    return 0.5 + 0.5 * std::sin(120.0 * at.x + 18.0 * std::sin(14.0 * at.y) + 12.0 * std::sin(17.0 * at.z));
}
enum class AttributeBits : std::uint8_t { Twelve, Full };
inline std::uint32_t baked_color(const dvec3& at, const dvec3& n, std::uint32_t bits) {
    const double vein = vein_at(at);
    const double shade = check_at(at) * (0.25 + 0.75 * std::max(0.0, glm::dot(n, dvec3(0.48, 0.36, 0.8))));
    const auto channel = [&](double light, double dark) { return rounded(shade * std::lerp(light, dark, vein), bits); };
    return channel(0.9, 0.3) << 2 * bits | channel(0.85, 0.45) << bits | channel(0.75, 0.6);
}

struct VoxelValues {
    std::uint64_t code;
    std::uint32_t normal, baked;
};

/// A triangle in voxels, and which columns along its largest axis meet it as the thin rule has it.
class ThinTriangle {
public:
    ThinTriangle(const std::array<dvec3, 3>& corners, const std::array<dvec3, 3>& normals, AttributeBits bits)
        : corners_(corners), normals_(normals), bits_(bits), edges_{corners[1] - corners[0], corners[2] - corners[0]},
          plane_(glm::cross(edges_[0], edges_[1])) {
        for (int axis = 1; axis < 3; ++axis)
            if (std::abs(plane_[axis]) > std::abs(plane_[along_]))
                along_ = axis;
    }
    void append(int resolution, std::vector<VoxelValues>& values) const {
        if (plane_[along_] == 0.0)
            return;
        const int x = (along_ + 1) % 3, y = (along_ + 2) % 3;
        const auto first = [&](int axis) { return std::max(0, static_cast<int>(std::floor(least(axis))) - 1); };
        const auto last = [&](int axis) {
            return std::min(resolution - 1, static_cast<int>(std::floor(-least(axis, -1.0))) + 1);
        };
        for (int j = first(y); j <= last(y); ++j)
            for (int i = first(x); i <= last(x); ++i) {
                dvec3 at;
                at[x] = i + 0.5, at[y] = j + 0.5;
                at[along_] =
                    corners_[0][along_] -
                    (plane_[x] * (at[x] - corners_[0][x]) + plane_[y] * (at[y] - corners_[0][y])) / plane_[along_];
                const dvec3 voxel = glm::floor(at);
                if (voxel[along_] < first(along_) || voxel[along_] > last(along_) || !meets(voxel + 0.5))
                    continue;
                const dvec3 n = normal_at(at);
                const voxel_dag::Voxel where{static_cast<std::uint32_t>(voxel.x), static_cast<std::uint32_t>(voxel.y),
                                             static_cast<std::uint32_t>(voxel.z)};
                const dvec3 centre = (voxel + 0.5) / static_cast<double>(resolution);
                const bool is_full = bits_ == AttributeBits::Full;
                values.push_back({voxel_dag::morton_code(where),
                                  is_full ? voxel_dag::octahedral::encode_rounded(n) : normal_of_12_bits(n),
                                  baked_color(centre, n, is_full ? 8 : 4)});
            }
    }

private:
    double least(int axis, double sign = 1.0) const {
        return std::min({sign * corners_[0][axis], sign * corners_[1][axis], sign * corners_[2][axis]});
    }
    /// Schwarz and Seidel 2010: the edges of the three projections against the cross in the middle of a voxel.
    bool meets(const dvec3& centre) const {
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const int x = (axis + 1) % 3, y = (axis + 2) % 3;
                const dvec3 &from = corners_[corner], edge = corners_[(corner + 1) % 3] - from;
                const double sign = plane_[axis] >= 0.0 ? 1.0 : -1.0, nx = -edge[y] * sign, ny = edge[x] * sign;
                if (nx * (centre[x] - from[x]) + ny * (centre[y] - from[y]) +
                        0.5 * std::max(std::abs(nx), std::abs(ny)) <
                    0.0)
                    return false;
            }
        return true;
    }
    dvec3 normal_at(const dvec3& at) const {
        const dvec3 offset = at - corners_[0];
        const double aa = glm::dot(edges_[0], edges_[0]), ab = glm::dot(edges_[0], edges_[1]);
        const double bb = glm::dot(edges_[1], edges_[1]), oa = glm::dot(offset, edges_[0]),
                     ob = glm::dot(offset, edges_[1]), scale = 1.0 / (aa * bb - ab * ab);
        const double b = std::clamp((bb * oa - ab * ob) * scale, 0.0, 1.0);
        const double c = std::clamp((aa * ob - ab * oa) * scale, 0.0, 1.0 - b);
        const dvec3 n = (1.0 - b - c) * normals_[0] + b * normals_[1] + c * normals_[2];
        return glm::normalize(glm::length(n) > 1e-9 ? n : plane_);
    }
    std::array<dvec3, 3> corners_, normals_;
    AttributeBits bits_;
    std::array<dvec3, 2> edges_;
    dvec3 plane_;
    int along_ = 0;
};

/// leaves: the mesh's voxels, of its bounding box scaled by its longest side.
inline VoxelAttributes voxel_attributes(const BareMesh& mesh, const voxel_dag::LeafMasks& leaves,
                                        AttributeBits bits = AttributeBits::Twelve) {
    Bounds3 bounds;
    for (const vec3& position : mesh.positions)
        bounds.grow(position);
    const dvec3 extent = dvec3(bounds.max) - dvec3(bounds.min);
    const double scale = static_cast<double>(leaves.resolution()) / std::max({extent.x, extent.y, extent.z});
    std::vector<dvec3> corners, normals(mesh.positions.size(), dvec3(0.0));
    for (const vec3& position : mesh.positions)
        corners.push_back((dvec3(position) - dvec3(bounds.min)) * scale);
    for (const uvec3& t : mesh.triangles)
        for (int corner = 0; corner < 3; ++corner)
            normals[t[corner]] += glm::cross(corners[t.y] - corners[t.x], corners[t.z] - corners[t.x]);
    for (dvec3& normal : normals)
        normal /= std::max(1e-30, glm::length(normal));
    std::vector<VoxelValues> found;
    for (const uvec3& t : mesh.triangles)
        ThinTriangle({corners[t.x], corners[t.y], corners[t.z]}, {normals[t.x], normals[t.y], normals[t.z]}, bits)
            .append(static_cast<int>(leaves.resolution()), found);
    std::ranges::stable_sort(found, {}, &VoxelValues::code);

    VoxelAttributes attributes;
    std::size_t next = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
        for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1) {
            const std::uint64_t code = leaves.codes[brick] << 6 | static_cast<std::uint32_t>(std::countr_zero(left));
            while (next < found.size() && found[next].code < code)
                ++next;
            if (next < found.size() && found[next].code == code) {
                attributes.normals.push_back(found[next].normal);
                attributes.baked.push_back(found[next].baked);
            } else {
                ++attributes.orphan_count;
                attributes.normals.push_back(attributes.normals.empty() ? 0 : attributes.normals.back());
                attributes.baked.push_back(attributes.baked.empty() ? 0 : attributes.baked.back());
            }
        }
    return attributes;
}
} // namespace tyndall::bench
