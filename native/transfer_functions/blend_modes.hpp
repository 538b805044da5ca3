// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's Mix node.
#pragma once
#include "transfer_functions/transfer_function.hpp"

namespace tyndall::transfer_functions {
/// What the Mix node of this blend mode makes of `below` and `above`; factor in [0, 1], 0 gives `below`.
[[nodiscard]] Rgb mixed(BlendMode mode, float factor, const Rgb& below, const Rgb& above);
} // namespace tyndall::transfer_functions
