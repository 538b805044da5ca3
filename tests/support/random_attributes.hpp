// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes for the voxels of tests: in patches, with noise, every kind of them.
#pragma once
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <random>

namespace tyndall::support {
/// A patch of some 20 voxels has one colour and normal; of 2 channels one follows it, and one is noise.
inline voxel_dag::VoxelAttributes random_attributes(std::uint64_t voxel_count, std::uint32_t seed) {
    std::mt19937 random(seed);
    voxel_dag::VoxelAttributes attributes{.colors = {}, .normals = {}, .channels = {{"rough", {}}, {"noise", {}}}};
    std::normal_distribution<double> coordinate;
    for (std::uint64_t voxel = 0; voxel < voxel_count; ++voxel) {
        const bool is_new = voxel == 0 || random() % 20 == 0;
        attributes.colors.push_back(is_new ? random() & 0xffffffu : attributes.colors.back());
        const dvec3 normal(coordinate(random), coordinate(random), coordinate(random));
        attributes.normals.push_back(is_new ? voxel_dag::octahedral::encode(normal, 32) : attributes.normals.back());
        attributes.channels[0].values.push_back(static_cast<std::uint8_t>(attributes.colors.back() * 7));
        attributes.channels[1].values.push_back(static_cast<std::uint8_t>(random()));
    }
    return attributes;
}
} // namespace tyndall::support
