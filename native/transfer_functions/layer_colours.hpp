// SPDX-License-Identifier: GPL-3.0-or-later
// What a layer has at each texel of a function's picture, before it meets those below.
#pragma once
#include "core/progress.hpp"
#include "transfer_functions/diffusion.hpp"
#include "transfer_functions/image_colours.hpp"
#include "transfer_functions/transfer_function.hpp"
#include <optional>
#include <span>

namespace tyndall::transfer_functions {
/// False where a layer is transparent everywhere, as far as its numbers tell: no pixel of an image is looked at.
[[nodiscard]] bool has_say(const Layer& layer);

/// Of a usable layer that has a say, which outlives it.
class LayerColours {
public:
    LayerColours(const Layer& layer, std::uint32_t size, const Progress& progress);
    /// Scene-linear colours with alpha, which the layer's opacity does not scale yet; one per texel of a row.
    void row(std::uint32_t row, std::span<vec4> colours) const;

private:
    const Layer& layer_;
    std::uint32_t size_;
    std::optional<Diffusion> diffusion_;
    std::optional<ImageColours> image_;
};
} // namespace tyndall::transfer_functions
