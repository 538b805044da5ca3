// SPDX-License-Identifier: GPL-3.0-or-later
// The layers of a transfer function put together into one picture.
#pragma once
#include "core/progress.hpp"
#include "transfer_functions/transfer_function.hpp"

namespace tyndall::transfer_functions {
/// A picture over [0, 1]^2; texel (i, j) holds the function at ((i + 1/2) / size, (j + 1/2) / size).
struct ComposedFunction {
    std::uint32_t size = 0;   ///< Texels per side; 0: changes nothing.
    std::vector<vec4> texels; ///< Rows bottom to top; scene-linear, multiplied with alpha.
    [[nodiscard]] bool is_neutral() const { return size == 0; }
};

inline constexpr std::uint32_t default_size = 256;

/// Layers from bottom to top over what is transparent everywhere. A function without a layer that has a say is neutral.
/// Throws InvalidInput and Cancelled.
[[nodiscard]] ComposedFunction compose(const TransferFunction& function, std::uint32_t size, const Progress& progress);
} // namespace tyndall::transfer_functions
