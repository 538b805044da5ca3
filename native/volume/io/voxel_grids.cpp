// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/io/voxel_grids.hpp"
#include "volume/io/grid_writing.hpp"
#include <openvdb/tools/TopologyToLevelSet.h>
#include <openvdb/tools/VolumeToMesh.h>

namespace tyndall::volume_io {
namespace {
/// What OpenVDB asks whether it should stop.
struct Interrupter {
    const Progress& progress;
    void start(const char* = nullptr) {}
    void end() {}
    bool wasInterrupted(int = -1) { return progress.is_cancelled(); }
};

vdb::MaskGrid::Ptr mask_of(const VoxelBits& voxels, const std::string& named, const Progress& progress) {
    using Leaf = vdb::MaskTree::LeafNodeType;
    static_assert(sizeof(Leaf::NodeMaskType) == 64);
    require_leaves(voxels.leaf_origins, named);
    require(voxels.leaf_words.size() == 8 * voxels.leaf_origins.size(), named, voxels.leaf_words.size(), " words for ",
            voxels.leaf_origins.size(), " leaves");
    const vdb::MaskGrid::Ptr mask = vdb::MaskGrid::create();
    for (std::size_t leaf = 0; leaf < voxels.leaf_origins.size(); ++leaf) {
        if (leaf % 4096 == 0)
            progress.poll();
        const auto& [x, y, z] = voxels.leaf_origins[leaf];
        auto node = std::make_unique<Leaf>(vdb::Coord(x, y, z), false, false);
        Leaf::NodeMaskType bits;
        for (vdb::Index word = 0; word < 8; ++word)
            bits.getWord<vdb::Index64>(word) = voxels.leaf_words[8 * leaf + word];
        node->setValueMask(bits);
        mask->tree().addLeaf(node.release());
    }
    return mask;
}

vdb::FloatGrid::Ptr level_set_of(const vdb::MaskGrid& mask, const Progress& progress) {
    constexpr int half_width = 3, closing_steps = 0, dilation = 0,
                  smoothing_steps = 0; // signs stay those of the voxels
    Interrupter interrupter{progress};
    const vdb::FloatGrid::Ptr grid =
        vdb::tools::topologyToLevelSet(mask, half_width, closing_steps, dilation, smoothing_steps, &interrupter);
    progress.poll();
    return grid;
}

vdb::FloatGrid::Ptr fog_of(const vdb::MaskGrid& mask) {
    const auto tree = std::make_shared<vdb::FloatTree>(mask.tree(), 0.0f, 1.0f, vdb::TopologyCopy());
    vdb::tools::prune(*tree); // what is full becomes one value
    const vdb::FloatGrid::Ptr grid = vdb::FloatGrid::create(tree);
    grid->setTransform(mask.transform().copy());
    grid->setGridClass(vdb::GRID_FOG_VOLUME);
    return grid;
}

vdb::Vec3SGrid::Ptr colored(const vdb::MaskGrid& mask, const VoxelBits& voxels, const VoxelColors& colors,
                            const std::string& named, const Progress& progress) {
    require(colors.linear.size() == mask.activeVoxelCount(), named, colors.linear.size(), " colours for ",
            mask.activeVoxelCount(), " voxels");
    const auto tree = std::make_shared<vdb::Vec3STree>(mask.tree(), vdb::Vec3s(0.0f), vdb::TopologyCopy());
    auto color = colors.linear.begin();
    for (std::size_t leaf = 0; leaf < voxels.leaf_origins.size(); ++leaf) {
        if (leaf % 4096 == 0)
            progress.poll();
        const auto& [x, y, z] = voxels.leaf_origins[leaf];
        for (auto voxel = tree->probeLeaf(vdb::Coord(x, y, z))->beginValueOn(); voxel; ++voxel, ++color)
            voxel.setValue(vdb::Vec3s(color->data()));
    }
    const vdb::Vec3SGrid::Ptr grid = vdb::Vec3SGrid::create(tree);
    grid->setTransform(mask.transform().copy());
    grid->setName(colors.name);
    return grid;
}
} // namespace

void write_voxels(const std::filesystem::path& path, const std::string& name, const VoxelBits& voxels,
                  VoxelGridKind kind, const std::optional<VoxelColors>& colors, const Metadata& metadata,
                  const Progress& progress) {
    vdb::initialize();
    const std::string named = path.string() + ": grid \"" + name + "\": ";
    require(!name.empty(), named, "it has no name");
    require(!colors || colors->name != name, named, "there are two of this name");
    with_named_errors(path, "", writing, [&] {
        const vdb::MaskGrid::Ptr mask = mask_of(voxels, named, progress);
        mask->setTransform(to_transform(voxels.local_from_index, named)); // its voxels' size scales distances
        const vdb::FloatGrid::Ptr grid = kind == VoxelGridKind::Fog ? fog_of(*mask) : level_set_of(*mask, progress);
        grid->setName(name);
        std::vector<vdb::GridBase::Ptr> grids{grid};
        if (colors)
            grids.push_back(colored(*mask, voxels, *colors, named, progress));
        write_grids(path, grids, metadata, progress);
    });
}

SmoothMesh smooth_mesh_of(const VoxelBits& voxels, const Progress& progress) {
    vdb::initialize();
    const vdb::MaskGrid::Ptr mask = mask_of(voxels, "", progress);
    std::vector<vdb::Vec3s> points;
    std::vector<vdb::Vec3I> triangles;
    std::vector<vdb::Vec4I> squares;
    vdb::tools::volumeToMesh(*level_set_of(*mask, progress), points, triangles, squares, /*isovalue=*/0.0);
    SmoothMesh mesh;
    mesh.positions.reserve(points.size());
    for (const vdb::Vec3s& point : points)
        mesh.positions.push_back({point.x(), point.y(), point.z()});
    // OpenVDB's corners go round with the clock.
    mesh.triangles.reserve(triangles.size() + 2 * squares.size());
    for (const vdb::Vec3I& triangle : triangles)
        mesh.triangles.push_back({triangle[0], triangle[2], triangle[1]});
    for (const vdb::Vec4I& square : squares) {
        mesh.triangles.push_back({square[0], square[2], square[1]});
        mesh.triangles.push_back({square[0], square[3], square[2]});
    }
    return mesh;
}
} // namespace tyndall::volume_io
