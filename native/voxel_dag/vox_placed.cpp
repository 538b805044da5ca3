// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "voxel_dag/vox_scene.hpp"
#include <cmath>

namespace tyndall::voxel_dag::vox {
template <typename Work>
static auto with_path(const std::filesystem::path& path, const Work& work) {
    try {
        return work();
    } catch (const InvalidInput& error) {
        refuse(path.string(), ": ", error.what());
    }
}

PlacedVoxels read_placed(const std::filesystem::path& path, double voxel_size_m, const Config& config,
                         const Progress& progress) {
    require(0.0 < voxel_size_m && std::isfinite(voxel_size_m), "voxel_size_m is ", voxel_size_m, ", no length above 0");
    const File file = read(path, progress);
    SceneVoxels scene = with_path(path, [&] { return voxels_of(file, config, progress); });
    const auto at = [&](std::size_t axis) { return static_cast<double>(scene.lower[axis]) * voxel_size_m; };
    const Cube bounds_m{.lower_m = dvec3(at(0), at(1), at(2)),
                        .side_m = static_cast<double>(scene.leaves.resolution()) * voxel_size_m};
    return {.leaves = std::move(scene.leaves), .attributes = std::move(scene.attributes), .bounds_m = bounds_m};
}

void write_placed(const LeafMasks& leaves, std::span<const std::uint32_t> colors, const Cube& bounds_m,
                  TooManyColors too_many, const std::filesystem::path& path, const Progress& progress) {
    const double voxel_m = bounds_m.side_m / static_cast<double>(leaves.resolution());
    std::array<std::int64_t, 3> lower{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        lower[axis] = std::llround(bounds_m.lower_m[static_cast<int>(axis)] / voxel_m);
    const File file = with_path(path, [&] { return file_of(leaves, colors, lower, too_many, progress); });
    write(file, path, progress);
}
} // namespace tyndall::voxel_dag::vox
