// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "volume/io/archive.hpp"
#include "volume/io/vdb_file.hpp"
#include <algorithm>
#include <sstream>

namespace tyndall::volume_io {
namespace vdb = openvdb;

// A type that is missing here is one that nobody can use as a density, a temperature or a colour.
using ReadableGrids = vdb::TypeList<vdb::FloatGrid, vdb::DoubleGrid, vdb::Int32Grid, vdb::Int64Grid, vdb::BoolGrid,
                                    vdb::MaskGrid, vdb::Vec3SGrid, vdb::Vec3DGrid, vdb::Vec3IGrid>;

constexpr Advice reading{.stream_failure = "it ends early, or the disk failed",
                         .remedy = "write it again with the program that made it"};

static std::string quoted(const std::string& name) { return "grid \"" + name + "\": "; }

static VoxelIndex to_index(const vdb::Coord& coord) { return {coord.x(), coord.y(), coord.z()}; }

/// OpenVDB multiplies rows from the left.
static Matrix affine_matrix(const vdb::math::Transform& transform) {
    const vdb::Mat4d transposed = transform.baseMap()->getAffineMap()->getMat4();
    Matrix matrix;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[static_cast<std::size_t>(4 * row + column)] = transposed(column, row);
    return matrix;
}

static std::string reason_to_refuse(const InputArchive::Entry& entry) {
    if (!entry.grid)
        return "its type " + as_utf8(entry.descriptor.gridType()) + " is unknown to OpenVDB " + library_version();
    if (!entry.grid->apply<ReadableGrids>([](const auto&) {}))
        return "it holds " + entry.grid->valueType() + ", neither numbers nor vectors of three";
    if (!entry.grid->transform().isLinear())
        return "it lies in a frustum, not in a box: resample it in the program that made it";
    return "";
}

static GridInfo info_of(const InputArchive::Entry& entry) {
    GridInfo info;
    info.name = entry.name();
    info.value_type = as_utf8(entry.descriptor.gridType());
    info.refusal = reason_to_refuse(entry);
    if (!entry.grid)
        return info;
    const vdb::GridBase& grid = *entry.grid;
    info.value_type = grid.valueType();
    info.grid_class = vdb::GridBase::gridClassToString(grid.getGridClass());
    info.is_half = entry.descriptor.saveFloatAsHalf();
    if (grid.transform().isLinear())
        info.local_from_index = affine_matrix(grid.transform());
    const auto count = grid.getMetadata<vdb::TypedMetadata<std::int64_t>>(vdb::GridBase::META_FILE_VOXEL_COUNT);
    const auto first = grid.getMetadata<vdb::Vec3IMetadata>(vdb::GridBase::META_FILE_BBOX_MIN);
    const auto last = grid.getMetadata<vdb::Vec3IMetadata>(vdb::GridBase::META_FILE_BBOX_MAX);
    if (count && first && last) {
        info.active_voxel_count = static_cast<std::uint64_t>(count->value());
        info.first_index = to_index(vdb::Coord(first->value()));
        info.last_index = to_index(vdb::Coord(last->value()));
    } else {
        info.active_voxel_count = grid.activeVoxelCount();
        const vdb::CoordBBox bounds = grid.evalActiveVoxelBoundingBox();
        info.first_index = to_index(bounds.min());
        info.last_index = to_index(bounds.max());
    }
    return info;
}

/// Eight voxels per side: those of a leaf, or a piece of a constant tile.
template <typename Tree>
struct Source {
    VoxelIndex origin;
    const typename Tree::LeafNodeType* leaf; ///< nullptr: all voxels have the tile's value.
    typename Tree::ValueType tile;
};

/// What is left of the caller's limit, over all grids of a call.
struct Budget {
    std::size_t limit_bytes, used_bytes = 0;
    void use(std::uint64_t leaf_count, std::size_t component_count, const std::string& named) {
        const double bytes = static_cast<double>(leaf_count) * static_cast<double>(component_count) *
                             static_cast<double>(voxels_per_leaf * sizeof(float));
        require(static_cast<double>(used_bytes) + bytes <= static_cast<double>(limit_bytes), named, "it would take ",
                bytes / 1e9, " GB in memory, beyond the limit of ", static_cast<double>(limit_bytes) / 1e9,
                " GB: resample it to larger voxels, or raise the limit");
        used_bytes += static_cast<std::size_t>(bytes);
    }
};

/// Leaves and tiles that differ from the background, ascending by origin.
template <typename Tree>
std::vector<Source<Tree>> sources_of(const Tree& tree, Budget& budget, std::size_t component_count,
                                     const std::string& named, const Progress& progress) {
    using Value = typename Tree::ValueType;
    constexpr std::int32_t leaf_side = 8;
    // Tiles that are not active count as well: the inside of a level set is one.
    const auto visit_tiles = [&](const auto& visit) {
        auto tile = tree.cbeginValueAll();
        for (tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1); tile; ++tile) {
            progress.poll();
            // Bits, not numbers: -0 is not the background's 0, and a NaN is itself.
            const Value value = *tile;
            if (std::memcmp(&value, &tree.background(), sizeof value) == 0)
                continue;
            vdb::CoordBBox bounds;
            tile.getBoundingBox(bounds);
            visit(bounds, value);
        }
    };
    std::uint64_t leaf_count = tree.leafCount();
    visit_tiles([&](const vdb::CoordBBox& bounds, const Value&) { leaf_count += bounds.volume() / voxels_per_leaf; });
    budget.use(leaf_count, component_count, named);

    std::vector<Source<Tree>> sources;
    sources.reserve(leaf_count);
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
        sources.push_back({.origin = to_index(leaf->origin()), .leaf = &*leaf, .tile = {}});
    visit_tiles([&](const vdb::CoordBBox& bounds, const Value& value) {
        const vdb::Coord &first = bounds.min(), &last = bounds.max();
        for (std::int32_t x = first.x(); x <= last.x(); x += leaf_side)
            for (std::int32_t y = first.y(); y <= last.y(); y += leaf_side)
                for (std::int32_t z = first.z(); z <= last.z(); z += leaf_side)
                    sources.push_back({.origin = {x, y, z}, .leaf = nullptr, .tile = value});
    });
    std::sort(sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.origin < b.origin; });
    return sources;
}

template <typename Value>
float component_of(const Value& value, [[maybe_unused]] int component) {
    if constexpr (vdb::VecTraits<Value>::IsVec)
        return static_cast<float>(value[component]);
    else
        return static_cast<float>(value);
}

template <typename GridType>
void append_components(std::vector<Grid>& grids, const GridType& grid, const std::string& name,
                       const std::string& named, Budget& budget, const Progress& progress) {
    using Tree = typename GridType::TreeType;
    using Value = typename Tree::ValueType;
    constexpr bool is_vector = vdb::VecTraits<Value>::IsVec;
    const std::vector<Source<Tree>> sources = sources_of(grid.tree(), budget, is_vector ? 3 : 1, named, progress);
    for (int component = 0; component < (is_vector ? 3 : 1); ++component) {
        Grid& target = grids.emplace_back();
        target.name = is_vector ? name + "." + "xyz"[component] : name;
        target.local_from_index = affine_matrix(grid.transform());
        target.background = component_of<Value>(grid.background(), component);
        target.leaf_origins.resize(sources.size());
        target.leaf_values.resize(sources.size() * voxels_per_leaf);
        parallel_for(
            sources.size(), progress,
            [&](std::size_t index) {
                const Source<Tree>& source = sources[index];
                target.leaf_origins[index] = source.origin;
                float* const values = target.leaf_values.data() + index * voxels_per_leaf;
                if (source.leaf == nullptr)
                    std::fill_n(values, voxels_per_leaf, component_of<Value>(source.tile, component));
                else
                    for (vdb::Index voxel = 0; voxel < voxels_per_leaf; ++voxel)
                        values[voxel] = component_of<Value>(source.leaf->getValue(voxel), component);
            },
            /*block_size=*/64);
    }
}

static std::string names_of(std::vector<InputArchive::Entry>& entries) {
    std::string names;
    for (const InputArchive::Entry& entry : entries)
        names += (names.empty() ? "\"" : ", \"") + entry.name() + "\"";
    return names.empty() ? "none" : names;
}

FileInfo list(const std::filesystem::path& path, const Progress& progress) {
    vdb::initialize();
    return with_named_errors(path, "", reading, [&] {
        InputArchive archive(path, progress);
        FileInfo info;
        for (auto entry = archive.metadata().beginMeta(); entry != archive.metadata().endMeta(); ++entry)
            info.metadata.emplace(as_utf8(entry->first), as_utf8(entry->second->str()));
        for (InputArchive::Entry& entry : archive.entries())
            with_named_errors(path, quoted(entry.name()), reading, [&] {
                if (entry.grid)
                    archive.read_header(entry);
                info.grids.push_back(info_of(entry));
            });
        return info;
    });
}

std::vector<Grid> read(const std::filesystem::path& path, const std::optional<std::vector<std::string>>& names,
                       std::size_t memory_limit_bytes, Progress& progress) {
    vdb::initialize();
    return with_named_errors(path, "", reading, [&] {
        InputArchive archive(path, progress);
        std::vector<InputArchive::Entry>& entries = archive.entries();
        for (const std::string& name : names.value_or(std::vector<std::string>{}))
            require(
                std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.name() == name; }),
                path.string(), ": it has no grid \"", name, "\"; it has: ", names_of(entries));
        Budget budget{.limit_bytes = memory_limit_bytes};
        std::vector<Grid> grids;
        for (InputArchive::Entry& entry : entries) {
            const std::string name = entry.name();
            if (names && std::find(names->begin(), names->end(), name) == names->end())
                continue;
            with_named_errors(path, quoted(name), reading, [&] {
                progress.set_message(path.filename().string() + ": " + name);
                if (entry.grid)
                    archive.read_header(entry);
                const std::string refusal = reason_to_refuse(entry);
                const std::string named = path.string() + ": " + quoted(name);
                require(refusal.empty() || !names, named, refusal);
                if (!refusal.empty())
                    return;
                archive.read_grid(entry);
                entry.grid->apply<ReadableGrids>(
                    [&](const auto& grid) { append_components(grids, grid, name, named, budget, progress); });
                archive.release(entry);
            });
        }
        return grids;
    });
}

std::string library_version() { return vdb::getLibraryVersionString(); }
} // namespace tyndall::volume_io
