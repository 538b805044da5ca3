// SPDX-License-Identifier: GPL-3.0-or-later
// The 19 formulas of Blender's Mix node.
// Based on: blender/cycles v4.5.0, src/kernel/svm/color_util.h and src/kernel/util/color.h.
// Differs:  where that clamps to [0, 1] (Burn, Dodge) or to 0 (Exclusion), a colour that already lies beyond stays as it
//           is: a factor that goes to 0 leads back to it without a jump.
#include "transfer_functions/blend_modes.hpp"
#include <algorithm>

namespace tyndall::transfer_functions {
namespace {
struct Hsv {
    float hue = 0.0f, saturation = 0.0f, value = 0.0f;
};

Hsv hsv_from_rgb(const Rgb& rgb) {
    const float highest = std::max({rgb.x, rgb.y, rgb.z}), spread = highest - std::min({rgb.x, rgb.y, rgb.z});
    Hsv hsv{.value = highest};
    if (highest != 0.0f)
        hsv.saturation = spread / highest;
    if (hsv.saturation == 0.0f)
        return hsv;
    const Rgb below_highest = (highest - rgb) / spread;
    if (rgb.x == highest)
        hsv.hue = below_highest.z - below_highest.y;
    else if (rgb.y == highest)
        hsv.hue = 2.0f + below_highest.x - below_highest.z;
    else
        hsv.hue = 4.0f + below_highest.y - below_highest.x;
    hsv.hue /= 6.0f;
    if (hsv.hue < 0.0f)
        hsv.hue += 1.0f;
    return hsv;
}

Rgb rgb_from_hsv(const Hsv& hsv) {
    const Rgb purest = glm::clamp(Rgb(std::abs(hsv.hue * 6.0f - 3.0f) - 1.0f, 2.0f - std::abs(hsv.hue * 6.0f - 2.0f),
                                      2.0f - std::abs(hsv.hue * 6.0f - 4.0f)),
                                  0.0f, 1.0f);
    return ((purest - 1.0f) * hsv.saturation + 1.0f) * hsv.value;
}

/// `above` tells hue, saturation or value; a grey one has no hue, and a grey `below` no saturation to change.
Rgb mixed_hsv(BlendMode mode, float factor, const Rgb& below, const Rgb& above) {
    Hsv hsv = hsv_from_rgb(below);
    const Hsv told = hsv_from_rgb(above);
    const bool has_no_say = mode == BlendMode::Hue || mode == BlendMode::Colour ? told.saturation == 0.0f
                            : mode == BlendMode::Saturation                     ? hsv.saturation == 0.0f
                                                                                : false;
    if (has_no_say)
        return below;
    if (mode == BlendMode::Hue || mode == BlendMode::Colour)
        hsv.hue = told.hue;
    if (mode == BlendMode::Saturation || mode == BlendMode::Colour)
        hsv.saturation = told.saturation;
    if (mode == BlendMode::Value)
        hsv.value = told.value;
    return glm::mix(below, rgb_from_hsv(hsv), factor);
}

float burnt(float factor, float below, float above) {
    if (below > 1.0f)
        return below;
    const float share = 1.0f - factor + factor * above, lowest = std::min(below, 0.0f);
    return share <= 0.0f ? lowest : std::clamp(1.0f - (1.0f - below) / share, lowest, 1.0f);
}

float dodged(float factor, float below, float above) {
    if (below == 0.0f)
        return below;
    const float share = 1.0f - factor * above, highest = std::max(below, 1.0f);
    return share <= 0.0f ? highest : std::min(below / share, highest);
}

/// At factor 1, of the modes that are linear in it and know one channel at a time.
float blended(BlendMode mode, float below, float above) {
    switch (mode) {
    case BlendMode::Darken:
        return std::min(below, above);
    case BlendMode::Multiply:
        return below * above;
    case BlendMode::Lighten:
        return std::max(below, above);
    case BlendMode::Screen:
        return 1.0f - (1.0f - above) * (1.0f - below);
    case BlendMode::Add:
        return below + above;
    case BlendMode::Overlay:
        return below < 0.5f ? 2.0f * below * above : 1.0f - 2.0f * (1.0f - above) * (1.0f - below);
    case BlendMode::SoftLight:
        return below * ((1.0f - below) * above + (1.0f - (1.0f - above) * (1.0f - below)));
    case BlendMode::LinearLight:
        return below + 2.0f * above - 1.0f;
    case BlendMode::Difference:
        return std::abs(below - above);
    case BlendMode::Exclusion:
        return below + above - 2.0f * below * above;
    case BlendMode::Subtract:
        return below - above;
    case BlendMode::Divide:
        return above != 0.0f ? below / above : below;
    default:
        return above; // Mix
    }
}
} // namespace

Rgb mixed(BlendMode mode, float factor, const Rgb& below, const Rgb& above) {
    if (mode >= BlendMode::Hue)
        return mixed_hsv(mode, factor, below, above);
    Rgb result;
    for (int channel = 0; channel < 3; ++channel) {
        const float b = below[channel], a = above[channel];
        result[channel] = mode == BlendMode::ColourBurn    ? burnt(factor, b, a)
                          : mode == BlendMode::ColourDodge ? dodged(factor, b, a)
                                                           : (1.0f - factor) * b + factor * blended(mode, b, a);
        if (mode == BlendMode::Exclusion)
            result[channel] = std::max(result[channel], std::min(b, 0.0f));
    }
    return result;
}
} // namespace tyndall::transfer_functions
