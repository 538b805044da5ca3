// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/density_grid.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
namespace {
constexpr float largest_density = 1e9f;
constexpr std::size_t largest_table = std::size_t{1} << 28; // 1 GB

void validate(const GridLeaves& leaves, const Progress& progress) {
    constexpr std::size_t per_leaf = GridLeaves::side * GridLeaves::side * GridLeaves::side;
    const std::string what = "grid \"" + leaves.name + "\"";
    require(leaves.values.size() == leaves.origins.size() * per_leaf, what, ": ", leaves.origins.size(),
            " leaves have ", leaves.values.size(), " values");
    for (const glm::ivec3& origin : leaves.origins)
        for (int axis = 0; axis < 3; ++axis)
            require(origin[axis] % GridLeaves::side == 0, what, ": a leaf begins at voxel ", origin[axis],
                    ", which is no multiple of ", GridLeaves::side);
    for (std::size_t index = 0; index < leaves.values.size(); ++index) {
        if (index % (1 << 20) == 0)
            progress.poll();
        require(std::abs(leaves.values[index]) <= largest_density, what, ": a voxel's density is ",
                leaves.values[index], ", outside [0, ", largest_density, "]");
    }
    double determinant = glm::determinant(glm::dmat3(leaves.local_from_index));
    require(std::isfinite(determinant) && determinant != 0.0 && std::isfinite(leaves.local_from_index[3][0]) &&
                std::isfinite(leaves.local_from_index[3][1]) && std::isfinite(leaves.local_from_index[3][2]),
            what, ": its transform is not finite or has no inverse");
}
} // namespace

DensityGrid::DensityGrid(std::span<const GridLeaves> channels, const Progress& progress)
    : channel_count_(channels.size()) {
    require(!channels.empty() && channels.size() <= most_channels, channels.size(), " grids together; 1 to ",
            most_channels, " are possible");
    constexpr int side = GridLeaves::side;
    constexpr std::size_t per_leaf = side * side * side;
    const GridLeaves& leaves = channels.front();
    // Leaves with density. The voxels of a leaf are corners of the bricks at it and before it.
    struct DenseLeaf {
        std::size_t channel, leaf;
    };
    std::vector<DenseLeaf> dense;
    glm::ivec3 first(std::numeric_limits<int>::max()), last(std::numeric_limits<int>::min());
    for (std::size_t channel = 0; channel < channels.size(); ++channel) {
        const GridLeaves& own = channels[channel];
        validate(own, progress);
        require(own.local_from_index == leaves.local_from_index, "grids \"", leaves.name, "\" and \"", own.name,
                "\" have other voxels");
        for (std::size_t leaf = 0; leaf < own.origins.size(); ++leaf) {
            const float* values = own.values.data() + leaf * per_leaf;
            if (std::none_of(values, values + per_leaf, [](float value) { return value > 0.0f; }))
                continue;
            dense.push_back({channel, leaf});
            for (int axis = 0; axis < 3; ++axis) {
                first[axis] = std::min(first[axis], own.origins[leaf][axis] / side - 1);
                last[axis] = std::max(last[axis], own.origins[leaf][axis] / side);
            }
        }
    }
    local_from_grid_ = leaves.local_from_index;
    if (dense.empty())
        return;
    double table = 1.0;
    for (int axis = 0; axis < 3; ++axis)
        table *= static_cast<double>(last[axis]) - first[axis] + 1.0;
    require(table <= static_cast<double>(largest_table), "grid \"", leaves.name,
            "\": its leaves lie too far apart, over ", table, " blocks of 8^3 voxels");
    table_size_ = last - first + 1;
    local_from_grid_ = leaves.local_from_index * glm::translate(glm::dmat4(1.0), double{side} * glm::dvec3(first));
    table_.assign(static_cast<std::size_t>(table), -1);
    const std::size_t per_brick = static_cast<std::size_t>(stride()) * brick_corners * brick_corners * brick_corners;
    const auto brick_at = [&](const glm::ivec3& at) {
        std::int32_t& index = table_[table_index(at)];
        if (index < 0) {
            index = static_cast<std::int32_t>(bricks_.size());
            bricks_.push_back({.corners = nullptr});
            corners_.resize(corners_.size() + per_brick);
        }
        return static_cast<std::size_t>(index);
    };
    std::vector<std::uint8_t> is_taken(table_.size(), 0); // a bit for each channel
    for (const auto& [channel, leaf] : dense) {
        progress.poll();
        const GridLeaves& own = channels[channel];
        const glm::ivec3 at = own.origins[leaf] / side - first;
        const auto bit = static_cast<std::uint8_t>(1u << channel);
        require((is_taken[table_index(at)] & bit) == 0, "grid \"", own.name, "\": two leaves begin at the same voxel");
        is_taken[table_index(at)] |= bit;
        const float* values = own.values.data() + leaf * per_leaf;
        for (int before = 0; before < 8; ++before) {
            // The brick before, along x, y and z, reads the leaf's first layer as its last corners.
            const glm::ivec3 back(before & 1, before >> 1 & 1, before >> 2);
            const glm::ivec3 count = glm::ivec3(side) - (side - 1) * back;
            constexpr std::size_t none = ~std::size_t{0};
            std::size_t brick = none;
            for (int x = 0; x < count.x; ++x)
                for (int y = 0; y < count.y; ++y)
                    for (int z = 0; z < count.z; ++z) {
                        const float value = values[(x * side + y) * side + z];
                        if (!(value > 0.0f))
                            continue;
                        if (brick == none)
                            brick = brick_at(at - back);
                        const glm::ivec3 corner = glm::ivec3(x, y, z) + side * back;
                        const auto place =
                            static_cast<std::size_t>((corner.x * brick_corners + corner.y) * brick_corners + corner.z);
                        corners_[brick * per_brick + place * static_cast<std::size_t>(stride()) + channel] = value;
                        float& greatest = bricks_[brick].greatest[static_cast<int>(channel)];
                        greatest = std::max(greatest, value);
                        const vec3 voxel = vec3(side * at) + vec3(x, y, z);
                        bounds_.grow(voxel - 1.0f);
                        bounds_.grow(voxel + 1.0f);
                    }
        }
    }
    for (std::size_t brick = 0; brick < bricks_.size(); ++brick)
        bricks_[brick].corners = corners_.data() + brick * per_brick;
}

vec4 DensityGrid::at(const vec3& point) const {
    for (int axis = 0; axis < 3; ++axis)
        if (!(point[axis] >= bounds_.min[axis] && point[axis] <= bounds_.max[axis]))
            return vec4(0.0f);
    const glm::ivec3 cell = glm::min(glm::ivec3(point), brick_cells * table_size_ - 1);
    const Brick* here = brick(cell / brick_cells);
    if (here == nullptr)
        return vec4(0.0f);
    const float* corner = cell_corner(*here, cell % brick_cells, stride());
    const vec3 place = point - vec3(cell);
    if (channel_count_ == 1)
        return vec4(trilinear<float>(corner, place), 0.0f, 0.0f, 0.0f);
    const Densities found = trilinear<Densities>(corner, place);
    return {found[0], found[1], found[2], found[3]};
}
} // namespace tyndall
