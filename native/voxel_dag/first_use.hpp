// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers in the order of first use, which no thread has a say in.
// Based on: the smallest position per name, kept by an atomic minimum; a bit at each, whose rank is the number.
// Bound:    2 passes over the references, 2 over the names; 8 bytes per name, 1.5 bits per reference.
#pragma once
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
/// References, names below name_count, become 0, 1, 2 and so on as they first appear. Returns the name of each number.
/// Fewer than 2^32 - 1 references.
[[nodiscard]] std::vector<std::uint32_t> number_by_first_use(std::span<std::uint32_t> references,
                                                             std::size_t name_count, const Progress& progress);
} // namespace tyndall::voxel_dag
