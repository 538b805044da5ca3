// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/listed_voxels.hpp"
#include "core/errors.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::voxel_dag {
/// The last row of each voxel, in Morton order.
static std::vector<std::size_t> rows_in_order(std::span<const Voxel> voxels) {
    std::vector<std::size_t> rows(voxels.size());
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    const auto key = [&](std::size_t row) { return std::pair(morton_code(voxels[row]), ~row); };
    std::ranges::sort(rows, {}, key);
    const auto same_voxel = [&](std::size_t a, std::size_t b) { return voxels[a] == voxels[b]; };
    rows.erase(std::ranges::unique(rows, same_voxel).begin(), rows.end());
    return rows;
}

ListedVoxels voxels_of_list(std::span<const Voxel> voxels, const ListedAttributes& attributes, std::uint32_t level,
                            const Progress& progress) {
    ListedVoxels listed{.leaves = leaf_masks_of({voxels.begin(), voxels.end()}, level), .attributes = {}};
    if (attributes.colors.empty() && attributes.normals.empty() && attributes.channels.empty())
        return listed;
    const std::vector<std::size_t> rows = rows_in_order(voxels);
    const auto in_order = [&](const auto& values, const std::string& what, const auto& kept, auto& ordered) {
        progress.poll();
        require(values.empty() || values.size() == voxels.size(), "voxels: ", values.size(), " ", what, " for ",
                voxels.size(), " voxels");
        if (!values.empty())
            for (const std::size_t row : rows)
                ordered.push_back(kept(values[row]));
    };
    const auto as_it_is = [](auto value) { return value; };
    in_order(
        attributes.colors, "colors",
        [](const ByteColor& color) {
            return std::uint32_t{color[0]} | std::uint32_t{color[1]} << 8 | std::uint32_t{color[2]} << 16;
        },
        listed.attributes.colors);
    in_order(octahedral::encode_all(attributes.normals, octahedral::most_bits, progress), "normals", as_it_is,
             listed.attributes.normals);
    for (const auto& [name, values] : attributes.channels) {
        VoxelChannel& channel = listed.attributes.channels.emplace_back(name, std::vector<std::uint8_t>());
        in_order(values, "values of channel '" + name + "'", as_it_is, channel.values);
    }
    return listed;
}
} // namespace tyndall::voxel_dag
