// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/smooth_normals.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag::smooth_normals {
namespace {
/// Weighted sums over the voxels around one, from its centre.
struct Moments {
    double weight = 0.0;
    dvec3 first{0.0};
    glm::dmat3 second{0.0};

    void add(const dvec3& offset, double farthest_2) {
        const double share = 1.0 - glm::dot(offset, offset) / farthest_2;
        if (share <= 0.0)
            return;
        weight += share * share;
        first += share * share * offset;
        second += share * share * glm::outerProduct(offset, offset);
    }
    /// About their mean; without voxels 0.
    [[nodiscard]] glm::dmat3 covariance() const {
        if (weight == 0.0)
            return glm::dmat3(0.0);
        const dvec3 mean = first / weight;
        return second / weight - glm::outerProduct(mean, mean);
    }
};

Moments moments_around(const PackedDag& dag, const Voxel& voxel, std::uint32_t radius) {
    Moments moments;
    const double farthest_2 = (radius + 1.0) * (radius + 1.0);
    constexpr std::uint32_t mask = (1u << leaf_level) - 1;
    std::array<std::uint64_t, 3> first, past; // corners of bricks
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = (voxel[axis] - std::min(voxel[axis], radius)) & ~mask;
        past[axis] = std::min(std::uint64_t{voxel[axis]} + radius + 1, std::uint64_t{1} << dag.level);
    }
    for (std::uint64_t z = first[2]; z < past[2]; z += mask + 1)
        for (std::uint64_t y = first[1]; y < past[1]; y += mask + 1)
            for (std::uint64_t x = first[0]; x < past[0]; x += mask + 1) {
                const dvec3 corner = dvec3(x, y, z) - dvec3(voxel[0], voxel[1], voxel[2]);
                const Voxel lowest{static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                   static_cast<std::uint32_t>(z)};
                for (std::uint64_t left = dag.brick(lowest); left != 0; left &= left - 1) {
                    const Voxel at = voxel_at(static_cast<std::uint64_t>(std::countr_zero(left)));
                    moments.add(corner + dvec3(at[0], at[1], at[2]), farthest_2);
                }
            }
    return moments;
}

struct Axes {
    dvec3 variances;
    glm::dmat3 directions; ///< Columns.
};
/// Jacobi's rotations: to within rounding after five rounds.
Axes principal_axes(glm::dmat3 a) {
    glm::dmat3 directions(1.0);
    for (int round = 0; round < 8; ++round)
        for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
            if (a[p][q] == 0.0)
                continue;
            const double ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            const double tangent = std::copysign(1.0, ratio) / (std::abs(ratio) + std::sqrt(ratio * ratio + 1.0));
            const double cosine = 1.0 / std::sqrt(tangent * tangent + 1.0), sine = tangent * cosine;
            glm::dmat3 rotation(1.0);
            rotation[p][p] = rotation[q][q] = cosine;
            rotation[q][p] = sine;
            rotation[p][q] = -sine;
            a = glm::transpose(rotation) * a * rotation;
            a[p][q] = a[q][p] = 0.0;
            directions = directions * rotation;
        }
    return {.variances = {a[0][0], a[1][1], a[2][2]}, .directions = directions};
}

/// Of unit length, to either side; or 0.
dvec3 least_variance(const glm::dmat3& covariance) {
    const Axes axes = principal_axes(covariance);
    std::array<int, 3> order{0, 1, 2};
    std::ranges::stable_sort(order, {}, [&](int axis) { return axes.variances[axis]; });
    constexpr double rounding = 1e-9; // of variances of a few voxels
    if (axes.variances[order[1]] - axes.variances[order[0]] <= rounding)
        return dvec3(0.0);
    return glm::normalize(axes.directions[order[0]]);
}
} // namespace

std::vector<vec3> find(const PackedDag& dag, std::span<const Voxel> voxels, std::span<const dvec3> directions,
                       const Config& config, const Progress& progress) {
    require(1 <= config.radius && config.radius <= 16, "voxel DAG: radius is ", config.radius, ", not in [1, 16]");
    require(directions.empty() || directions.size() == voxels.size(), "voxel DAG: ", voxels.size(), " voxels, but ",
            directions.size(), " directions");
    std::vector<vec3> normals(voxels.size());
    parallel_for(voxels.size(), progress, [&](std::size_t i) {
        const Moments moments = moments_around(dag, voxels[i], config.radius);
        const dvec3 normal = least_variance(moments.covariance());
        const dvec3& behind = directions.empty() ? moments.first : directions[i];
        normals[i] = vec3(glm::dot(normal, behind) > 0.0 ? -normal : normal);
    });
    return normals;
}
} // namespace tyndall::voxel_dag::smooth_normals
