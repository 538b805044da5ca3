// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "volume/io/grid_writing.hpp"
#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

namespace tyndall::volume_io {
using Leaf = vdb::FloatTree::LeafNodeType;

constexpr float largest_half = 65504.0f;

static std::string index_text(const VoxelIndex& index) {
    return "(" + std::to_string(index[0]) + ", " + std::to_string(index[1]) + ", " + std::to_string(index[2]) + ")";
}

void require_leaves(std::span<const VoxelIndex> origins, const std::string& named) {
    for (const VoxelIndex& origin : origins)
        require(((origin[0] | origin[1] | origin[2]) & 7) == 0, named, "a leaf begins at ", index_text(origin),
                ", which is no multiple of 8");
    std::vector<VoxelIndex> ascending(origins.begin(), origins.end());
    std::sort(ascending.begin(), ascending.end());
    const auto twice = std::adjacent_find(ascending.begin(), ascending.end());
    require(twice == ascending.end(), named, "two leaves begin at ",
            index_text(twice == ascending.end() ? VoxelIndex{} : *twice));
}

static void validate(const GridView& grid, Precision precision, const std::string& named) {
    require(!grid.name.empty(), named, "it has no name");
    require(grid.leaf_values.size() == grid.leaf_origins.size() * voxels_per_leaf, named, grid.leaf_values.size(),
            " values for ", grid.leaf_origins.size(), " leaves");
    require_leaves(grid.leaf_origins, named);
    if (precision == Precision::Half)
        for (const float value : grid.leaf_values)
            require(!std::isfinite(value) || std::abs(value) <= largest_half, named, "a half float cannot hold ", value,
                    ": save full floats");
}

vdb::math::Transform::Ptr to_transform(const Matrix& local_from_index, const std::string& named) {
    vdb::Mat4d index_to_local; // OpenVDB multiplies rows from the left
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) {
            const double entry = local_from_index[static_cast<std::size_t>(4 * row + column)];
            require(std::isfinite(entry), named, "its matrix is not finite");
            index_to_local(column, row) = entry;
        }
    require(vdb::math::isAffine(index_to_local) && index_to_local.det() != 0.0, named,
            "its matrix is not affine, or flattens space");
    return vdb::math::Transform::createLinearTransform(index_to_local);
}

static vdb::FloatGrid::Ptr to_grid(const GridView& view, Precision precision, const std::string& named,
                                   const Progress& progress) {
    validate(view, precision, named);
    const vdb::FloatGrid::Ptr grid = vdb::FloatGrid::create(view.background);
    grid->setName(view.name);
    grid->setGridClass(vdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(precision == Precision::Half);
    grid->setTransform(to_transform(view.local_from_index, named));
    std::vector<std::unique_ptr<Leaf>> leaves(view.leaf_origins.size());
    parallel_for(
        leaves.size(), progress,
        [&](std::size_t index) {
            const auto& [x, y, z] = view.leaf_origins[index];
            const float* const values = view.leaf_values.data() + index * voxels_per_leaf;
            auto leaf = std::make_unique<Leaf>(vdb::Coord(x, y, z), view.background);
            std::copy_n(values, voxels_per_leaf, leaf->buffer().data());
            // What the file leaves out is what has the background's bits: -0 is not its 0, and a NaN is itself.
            for (vdb::Index voxel = 0; voxel < voxels_per_leaf; ++voxel)
                if (std::bit_cast<std::uint32_t>(values[voxel]) != std::bit_cast<std::uint32_t>(view.background))
                    leaf->setValueOn(voxel);
            leaves[index] = std::move(leaf);
        },
        /*block_size=*/64);
    for (std::unique_ptr<Leaf>& leaf : leaves)
        grid->tree().addLeaf(leaf.release());
    return grid;
}

void write_grids(const std::filesystem::path& path, const std::vector<vdb::GridBase::Ptr>& grids,
                 const Metadata& metadata, const Progress& progress) {
    vdb::MetaMap of_file;
    for (const auto& [key, value] : metadata)
        of_file.insertMeta(key, vdb::StringMetadata(value));
    if (const auto creator = metadata.find("creator"); creator != metadata.end())
        for (const vdb::GridBase::Ptr& grid : grids)
            grid->setCreator(creator->second);
    PartialFile file(path);
    OutputArchive().write(file.name(), {grids.begin(), grids.end()}, of_file, progress);
    file.complete();
}

void write(const std::filesystem::path& path, std::span<const GridView> grids, Precision precision,
           const Metadata& metadata, Progress& progress) {
    vdb::initialize();
    with_named_errors(path, "", writing, [&] {
        std::set<std::string> names;
        std::vector<vdb::GridBase::Ptr> written;
        for (const GridView& grid : grids) {
            const std::string named = path.string() + ": grid \"" + grid.name + "\": ";
            require(names.insert(grid.name).second, named, "there are two of this name");
            written.push_back(to_grid(grid, precision, named, progress));
        }
        progress.set_message("Writing " + path.filename().string());
        write_grids(path, written, metadata, progress);
    });
}
} // namespace tyndall::volume_io
