// SPDX-License-Identifier: GPL-3.0-or-later
// Means of what voxels carry, for levels of detail: colours in linear light, normals by their sum's direction.
// Differs:  sums are of whole numbers, so that no mean depends on the order in which voxels are added up.
// Bound:    linear light to 2^-16, normals to 2^-20: the colour is the nearest byte, or its neighbour at a tie.
#pragma once
#include "core/math.hpp"
#include <array>
#include <cstdint>

namespace tyndall::voxel_dag {
/// What one voxel carries, or many on average.
struct VoxelSample {
    std::uint32_t color = 0;  ///< As in VoxelAttributes.
    vec3 normal = vec3(0.0f); ///< Of length 1; 0 where there is none.
    std::array<std::uint8_t, 4> channels{};

    bool operator==(const VoxelSample&) const = default;
};

class SampleSum {
public:
    void add(const VoxelSample& sample);
    SampleSum& operator+=(const SampleSum& other);
    /// Of one voxel at least. Normals that cancel out have the mean (0, 0, 1).
    [[nodiscard]] VoxelSample mean() const;
    bool operator==(const SampleSum&) const = default;

private:
    std::uint64_t count_ = 0;
    std::array<std::uint64_t, 3> light_{};
    std::array<std::int64_t, 3> normal_{};
    std::array<std::uint64_t, 4> channels_{};
};
} // namespace tyndall::voxel_dag
