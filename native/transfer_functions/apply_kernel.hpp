// SPDX-License-Identifier: GPL-3.0-or-later
// The look-up of apply.hpp, for a stretch of rays.
#pragma once
#include "transfer_functions/apply.hpp"

namespace tyndall::transfer_functions {
struct RayStretch {
    const vec2* parameters;
    const Rgb* radiance;
    const float* share; ///< Null: 1.
    Rgb* change;
    std::size_t count;
};
/// Of a function with two texels per side, or more.
void apply_to(const ComposedFunction& function, const Application& application, const RayStretch& rays);
} // namespace tyndall::transfer_functions
