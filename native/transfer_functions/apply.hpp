// SPDX-License-Identifier: GPL-3.0-or-later
// A composed transfer function, looked up for many rays.
// Data flow: 2 parameters and a radiance in, a change of radiance out; the function's picture stays in the second-level
//            cache. Bound: 20 bytes read, 12 read and written per ray, 91 MB at full HD: 6.5 ms at 14 GB/s, 3.3 at 28;
//            two loads of two texels each, and 2 to 3 ns of arithmetic per ray and core.
#pragma once
#include "core/progress.hpp"
#include "transfer_functions/compose.hpp"
#include <span>

namespace tyndall::transfer_functions {
/// What is done with a function's colour, see TransferFunction.
struct Application {
    Use use = Use::Replace;
    float strength = 1.0f;
    float weight = 1.0f; ///< Of the change, see WeightedFunction.
};

/// Adds to change[i] what the function makes of radiance[i], less radiance[i]: weight * alpha * (f(C, L) - L), with the
/// function read bilinearly at parameters[i], clamped to [0, 1]. Where it is neutral, or white in Multiply, the change is
/// 0 bit for bit. share[i] is the part of a pixel that the ray stands for, and scales the strength; empty: 1.
/// Throws InvalidInput where the spans differ in length, and Cancelled.
void apply(const ComposedFunction& function, const Application& application, std::span<const vec2> parameters,
           std::span<const Rgb> radiance, std::span<const float> share, std::span<Rgb> change,
           const Progress& progress);
} // namespace tyndall::transfer_functions
