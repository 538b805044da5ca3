// SPDX-License-Identifier: GPL-3.0-or-later
// Operations of colours: blends, hue and saturation, gamma, and tables.
// Based on: the definitions in Blender's manual; Smith, Color Gamut Transform Pairs, SIGGRAPH 1978 (hue, saturation, value).
// Differs:  where a definition leaves a case open (a hue of grey, a division by 0), what Cycles gives.
#pragma once
#include "shading/operands.hpp"
#include "shading/surface_op.hpp"
#include <span>

namespace tyndall {
/// SurfaceOp::option of Code::Blend: a with the share c of what the kind makes of a and b. The share is not clamped.
/// python/tyndall/surface_operations.py has the same order.
enum class BlendKind : std::uint8_t {
    Screen,
    Overlay,
    Divide,
    Difference,
    Exclusion,
    Darken,
    Lighten,
    Dodge,
    Burn,
    Hue,
    Saturation,
    Value,
    Colour,
    SoftLight,
    LinearLight,
    Count,
};
/// SurfaceOp::option of Code::Combine and Code::Separate; what the channels are.
enum class ColourModel : std::uint8_t { HueSaturationValue, HueSaturationLightness, Count };

/// SurfaceOp::selector of Code::Curve, over a table whose first and last value are at value.x and value.y.
enum class CurveOf : std::uint8_t {
    Colour, ///< The table's colour at a.
    Alpha,  ///< Its alpha there.
    Each,   ///< Of each channel of a its own curve, of which b is the share.
    Count,
};
/// SurfaceOp::option of Code::Curve; flags.
struct CurveOptions {
    static constexpr std::uint8_t steps = 1, ///< Nothing between two values of the table but the first of them.
        goes_on = 2;                         ///< Straight on beyond the ends; otherwise the ends' values.
};

/// Of the codes Curve to Separate.
[[nodiscard]] Rgb colour_value(const SurfaceOp& op, const Operands& in, std::span<const ColorTable> tables);
} // namespace tyndall
