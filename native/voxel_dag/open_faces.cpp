// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/open_faces.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
namespace {
/// Bits whose voxels have a coordinate, 0 to 3, along an axis: of a Morton code's bits `axis` and `axis + 3`.
constexpr std::uint64_t bits_at(std::uint32_t axis, std::uint32_t at) {
    std::uint64_t bits = 0;
    for (std::uint32_t code = 0; code < 64; ++code)
        if (voxel_at(code)[axis] == at)
            bits |= std::uint64_t{1} << code;
    return bits;
}
struct AxisBits {
    std::array<std::uint64_t, 4> at{};
};
constexpr AxisBits axis_bits(std::uint32_t axis) {
    return {{bits_at(axis, 0), bits_at(axis, 1), bits_at(axis, 2), bits_at(axis, 3)}};
}
constexpr std::array<AxisBits, 3> axes{axis_bits(0), axis_bits(1), axis_bits(2)};

/// The mask of a brick that is `up` or down a step along an axis; 0 where there is none.
std::uint64_t neighbour(const LeafMasks& leaves, std::size_t brick, std::uint32_t axis, bool up) {
    Voxel place = voxel_at(leaves.codes[brick]);
    const std::uint32_t last = static_cast<std::uint32_t>(leaves.resolution() >> leaf_level) - 1;
    if (place[axis] == (up ? last : 0))
        return 0;
    place[axis] += up ? 1u : ~0u;
    const std::uint64_t wanted = morton_code(place);
    // Ever longer steps away from the brick, then halves.
    const auto begin = leaves.codes.begin();
    auto first = begin + static_cast<std::ptrdiff_t>(brick), last_one = first;
    for (std::ptrdiff_t step = 1;; step *= 2)
        if (up) {
            first = last_one;
            last_one = leaves.codes.end() - last_one > step ? last_one + step : leaves.codes.end();
            if (last_one == leaves.codes.end() || *last_one >= wanted)
                break;
        } else {
            last_one = first;
            first = first - begin > step ? first - step : begin;
            if (first == begin || *first <= wanted)
                break;
        }
    if (last_one != leaves.codes.end())
        ++last_one;
    const auto found = std::lower_bound(first, last_one, wanted);
    return found != leaves.codes.end() && *found == wanted ? leaves.masks[static_cast<std::size_t>(found - begin)] : 0;
}
} // namespace

OpenFaces open_faces(const LeafMasks& leaves, std::size_t brick) {
    const std::uint64_t mask = leaves.masks[brick];
    OpenFaces faces;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        // A step from 0 to 1 or from 2 to 3 adds this to a Morton code; from 1 to 2, 7 times as much; to the next
        // brick, it takes 9 times as much away.
        const std::uint32_t step = 1u << axis;
        const std::array<std::uint64_t, 4>& at = axes[axis].at;
        const std::uint64_t has_below = (mask << step & (at[1] | at[3])) | (mask << 7 * step & at[2]);
        const std::uint64_t has_above = (mask >> step & (at[0] | at[2])) | (mask >> 7 * step & at[1]);
        std::uint64_t below = mask & ~has_below, above = mask & ~has_above;
        if ((below & at[0]) != 0)
            below &= ~(neighbour(leaves, brick, axis, false) >> 9 * step & at[0]);
        if ((above & at[3]) != 0)
            above &= ~(neighbour(leaves, brick, axis, true) << 9 * step & at[3]);
        faces[2 * axis] = below;
        faces[2 * axis + 1] = above;
    }
    return faces;
}

LeafMasks shell_of(const LeafMasks& leaves, const Progress& progress) {
    std::vector<std::uint64_t> masks(leaves.masks.size());
    parallel_for(masks.size(), progress, [&](std::size_t brick) {
        for (const std::uint64_t open : open_faces(leaves, brick))
            masks[brick] |= open;
    });
    LeafMasks shell{.level = leaves.level, .codes = {}, .masks = {}};
    for (std::size_t brick = 0; brick < masks.size(); ++brick)
        if (masks[brick] != 0)
            shell.codes.push_back(leaves.codes[brick]), shell.masks.push_back(masks[brick]);
    return shell;
}
} // namespace tyndall::voxel_dag
