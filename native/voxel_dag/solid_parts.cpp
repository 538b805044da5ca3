// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/solid_parts.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
namespace {
std::span<const std::uint32_t> triangles_of(const SubVolumes& parts, std::size_t part) {
    return std::span(parts.triangles).subspan(parts.first[part], parts.first[part + 1] - parts.first[part]);
}
/// Of the row of sub-cubes along x that holds `at`, up to it, with those before all; each once.
std::vector<std::uint32_t> up_to(const SubVolumes& parts, std::span<const std::uint32_t> before, const Voxel& at) {
    std::vector<std::uint32_t> triangles(before.begin(), before.end());
    for (std::uint32_t x = 0; x <= at[0]; ++x) {
        const auto found = std::ranges::lower_bound(parts.codes, morton_code({x, at[1], at[2]}));
        if (found == parts.codes.end() || *found != morton_code({x, at[1], at[2]}))
            continue;
        const auto there = triangles_of(parts, static_cast<std::size_t>(found - parts.codes.begin()));
        triangles.insert(triangles.end(), there.begin(), there.end());
    }
    std::ranges::sort(triangles);
    const auto twice = std::ranges::unique(triangles);
    triangles.erase(twice.begin(), twice.end());
    return triangles;
}
} // namespace

std::vector<std::uint32_t> triangles_before(const SnappedMesh& mesh) {
    std::vector<std::uint32_t> before;
    for (std::size_t index = 0; index < mesh.triangles.size(); ++index)
        if (std::ranges::all_of(mesh.triangle(index), [](const Steps& corner) { return corner[0] < 0; }))
            before.push_back(static_cast<std::uint32_t>(index));
    return before;
}

SubVolumes with_inside(const SnappedMesh& mesh, const SubVolumes& parts, std::span<const std::uint32_t> before,
                       const Progress& progress) {
    const std::uint32_t side = 1u << (mesh.level - parts.level);
    const auto is_inside = [&](const Voxel& at) {
        const std::vector<std::uint32_t> triangles = up_to(parts, before, at);
        // Of a brick in its lowest corner: all that crosses its columns lies before.
        const SubMesh corner = moved_mesh(mesh, triangles, at, parts.level, leaf_level);
        int winding = 0;
        for (const std::uint64_t entry : cross_columns(corner.mesh, progress, true).entries)
            if (ColumnCrossings::y(entry) == 0 && ColumnCrossings::z(entry) == 0)
                winding += ColumnCrossings::turn(entry);
        return winding != 0;
    };
    SubVolumes all{.level = parts.level, .codes = parts.codes, .first = {0}, .triangles = {}};
    for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t y = 0; y < side; ++y) {
            bool is_known = before.empty(), inside = false; // the same until triangles come between
            for (std::uint32_t x = 0; x < side; ++x) {
                progress.poll();
                const std::uint64_t code = morton_code({x, y, z});
                if (std::ranges::binary_search(parts.codes, code)) {
                    is_known = false;
                    continue;
                }
                if (!is_known)
                    inside = is_inside({x, y, z});
                is_known = true;
                if (inside)
                    all.codes.push_back(code);
            }
        }
    std::ranges::sort(all.codes);
    all.triangles.reserve(parts.triangles.size());
    for (std::size_t part = 0; const std::uint64_t code : all.codes) {
        if (part < parts.codes.size() && parts.codes[part] == code) {
            const auto there = triangles_of(parts, part++);
            all.triangles.insert(all.triangles.end(), there.begin(), there.end());
        }
        all.first.push_back(all.triangles.size());
    }
    return all;
}

ColumnCrossings crossings_of_part(const SnappedMesh& mesh, const SubVolumes& parts,
                                  std::span<const std::uint32_t> before, std::size_t part, const Progress& progress) {
    const Voxel at = voxel_at(parts.codes[part]);
    const SubMesh row = moved_mesh(mesh, up_to(parts, before, at), at, parts.level, parts.level);
    return cross_columns(row.mesh, progress, true);
}

Dag full_dag(std::uint32_t level, Symmetry symmetry) {
    Dag dag{.level = level, .symmetry = symmetry, .leaves = {~std::uint64_t{0}}, .levels = {}};
    for (std::uint32_t at = leaf_level; at < level; ++at)
        dag.levels.push_back(
            {.child_masks = {0xff},
             .first_children = {0, 8},
             .children = std::vector<std::uint32_t>(8, 0),
             .tags = std::vector<std::uint8_t>(symmetry == Symmetry::None ? std::size_t{0} : std::size_t{8}, 0)});
    return dag;
}
} // namespace tyndall::voxel_dag
