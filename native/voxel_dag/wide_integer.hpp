// SPDX-License-Identifier: GPL-3.0-or-later
// Integers of 128 bits, which GCC and Clang have beyond the standard.
#pragma once
namespace tyndall::voxel_dag {
__extension__ typedef __int128 Int128; // no alias declaration: -Wpedantic takes __extension__ before a typedef alone
} // namespace tyndall::voxel_dag
