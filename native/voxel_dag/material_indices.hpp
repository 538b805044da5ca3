// SPDX-License-Identifier: GPL-3.0-or-later
// The different values of an attribute array, each once, and the array as indices of them.
// Based on: Kol, dissertation, TU Delft 2018, section 2.4.2: the material array M and the indexed attribute array.
// Differs:  materials ascend, so that the index of a value does not depend on the order of entries.
// Bound:    values below 2^24: one bit each and one rank per 64; larger ones: a hash table of the different ones.
#pragma once
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
struct MaterialIndices {
    std::vector<std::uint32_t> materials; ///< The different values, ascending.
    std::vector<std::uint32_t> indices;   ///< Per entry, below materials.size().
};
[[nodiscard]] MaterialIndices material_indices_of(std::span<const std::uint32_t> values, const Progress& progress);
} // namespace tyndall::voxel_dag
