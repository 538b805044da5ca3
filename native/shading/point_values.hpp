// SPDX-License-Identifier: GPL-3.0-or-later
// What a program says at a point beside closures: how far it displaces a vertex.
#pragma once
#include "shading/program_point.hpp"
#include <span>

namespace tyndall {
/// What the register of a validated material's emission holds, of any sign; uvs as evaluate takes them.
[[nodiscard]] Rgb emission_register_at(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs);
} // namespace tyndall
