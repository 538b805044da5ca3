// SPDX-License-Identifier: GPL-3.0-or-later
// How much of shapes of cells a ray wants to know: where many cells fit into its footprint, cubes of them are enough.
#pragma once
#include <cstdint>

namespace tyndall {
struct RayDetail {
    /// A cube of cells that is no wider than one of these at the ray's distance is not looked into: in metres, and in
    /// metres per length of the ray's direction, from its origin on.
    float width_m = 0.0f, spread = 0.0f;
    /// In [0, 1), even among rays that take the same way: picks what this one meets of cubes that are partly filled.
    float number = 0.5f;
    [[nodiscard]] bool is_every_cell() const { return width_m <= 0.0f && spread <= 0.0f; }
};
} // namespace tyndall
