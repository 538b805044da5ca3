// SPDX-License-Identifier: GPL-3.0-or-later
// How different two colours look: sRGB bytes to CIELAB, and the CIE94 difference between two.
// Based on: IEC 61966-2-1 (sRGB); CIE 15:2004 (CIELAB); CIE 116-1995 (CIE94), with k_L = 1, K_1 = 0.045, K_2 = 0.015, the
//           constants of graphic arts, and D65, as Kol 2018, section 2.5.2 has them.
// Bound:    a difference is not symmetric: its weights are those of the first colour, here always the original.
#pragma once
#include "core/math.hpp"
#include <cstdint>

namespace tyndall::voxel_dag {
/// Red in bits 16 to 23, green in 8 to 15, blue in 0 to 7.
using PackedColor = std::uint32_t;

struct Lab {
    double lightness, a, b; ///< [0, 100]; about [-100, 100].
};
[[nodiscard]] Lab lab_of(PackedColor color);
/// Nearest bytes, where a colour lies outside of sRGB those of its clipped channels.
[[nodiscard]] PackedColor color_of(const Lab& lab);

/// CIE94 differences from one colour, with its weights ready.
struct Cie94From {
    explicit Cie94From(const Lab& original);
    [[nodiscard]] double squared(const Lab& other) const;

    Lab lab;
    double chroma, chroma_weight, hue_weight; ///< Of squared differences.
};
[[nodiscard]] double cie94(const Lab& original, const Lab& other);
} // namespace tyndall::voxel_dag
