// SPDX-License-Identifier: GPL-3.0-or-later
// The sRGB transfer curve (IEC 61966-2-1) and its inverse.
#pragma once

namespace tyndall {
/// Of an encoded value; exact to 5e-7 in [0, 1], where it is a table, and to float beyond.
[[nodiscard]] float linear_from_srgb(float encoded);
[[nodiscard]] float srgb_from_linear(float linear);
} // namespace tyndall
