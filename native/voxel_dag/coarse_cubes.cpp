// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/coarse_cubes.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
/// A node of the tree, or its brick's pair, where it lies.
struct Place {
    std::uint64_t code;
    PackedNode node;
};

/// Of nodes above the bricks, of 2^level voxels a side: the cubes of half that side.
static std::vector<Place> halved(const PackedDag& dag, std::uint32_t level, const std::vector<Place>& places) {
    std::vector<Place> children;
    children.reserve(4 * places.size());
    for (const auto& [code, node] : places) {
        const PackedHeader header = opened(dag, level, node);
        for (std::uint32_t there = 0; there < 8; ++there) {
            const std::uint32_t octant = cube_group.octant[cube_group.inverse[node.turn]][there];
            if ((header.child_mask >> octant & 1) != 0)
                children.push_back({.code = code << 3 | there, .node = child_of(dag, level, node, header, octant)});
        }
    }
    return children;
}

/// Of bricks: their parts of 8 voxels, or of one.
static std::vector<std::uint64_t> parts_of_bricks(const PackedDag& dag, const std::vector<Place>& bricks,
                                                  std::uint32_t voxels_each) {
    const std::uint64_t parts = 64 / voxels_each, ones = voxels_each == 8 ? 0xff : 1;
    std::vector<std::uint64_t> codes;
    for (const auto& [code, node] : bricks) {
        const TurnedLeaf leaf = leaf_of(dag, node);
        const std::uint64_t mask = turned_leaf(leaf.turn, leaf.mask);
        for (std::uint64_t part = 0; part < parts; ++part)
            if ((mask >> part * voxels_each & ones) != 0)
                codes.push_back(code * parts + part);
    }
    return codes;
}

CoarseCubes coarse_cubes(const PackedDag& dag, std::uint32_t level, std::size_t most_cubes, const Progress& progress) {
    level = std::min(level, dag.level);
    if (dag.is_empty())
        return {.level = level, .codes = {}};
    CoarseCubes cubes{.level = 0, .codes = {0}};
    std::vector<Place> places{{.code = 0, .node = root_of(dag)}};
    while (cubes.level < level) {
        progress.poll();
        const std::uint32_t side_level = dag.level - cubes.level;
        std::vector<std::uint64_t> codes;
        if (side_level > leaf_level) {
            std::vector<Place> children = halved(dag, side_level, places);
            if (children.size() <= most_cubes) // else they are not asked for again
                places = std::move(children);
            else
                return cubes;
            codes.resize(places.size());
            std::ranges::transform(places, codes.begin(), &Place::code);
        } else {
            codes = parts_of_bricks(dag, places, side_level == leaf_level ? 8 : 1);
        }
        if (codes.size() > most_cubes)
            return cubes;
        cubes = {.level = cubes.level + 1, .codes = std::move(codes)};
    }
    return cubes;
}
} // namespace tyndall::voxel_dag
