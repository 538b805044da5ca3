// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "core/math.hpp"

namespace tyndall {
/// What an operation reads of the registers. Those beyond its operand count say nothing.
struct Operands {
    Rgb a{0.0f}, b{0.0f}, c{0.0f}, d{0.0f}, e{0.0f}, f{0.0f};
};
} // namespace tyndall
