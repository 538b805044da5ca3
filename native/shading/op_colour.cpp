// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_colour.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
namespace {
template <typename Each>
Rgb each_channel(const Each& value) {
    return {value(0), value(1), value(2)};
}
float highest(const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}); }
float lowest(const Rgb& colour) { return std::min({colour.x, colour.y, colour.z}); }

/// [0, 1): where the colour lies on the way from red over green and blue to red; `range` is not 0.
float hue_of(const Rgb& colour, float high, float range) {
    float sixths;
    if (colour.x == high)
        sixths = (colour.y - colour.z) / range;
    else if (colour.y == high)
        sixths = 2.0f + (colour.z - colour.x) / range;
    else
        sixths = 4.0f + (colour.x - colour.y) / range;
    const float hue = sixths / 6.0f;
    return hue < 0.0f ? hue + 1.0f : hue;
}
Rgb hsv_of(const Rgb& colour) {
    const float high = highest(colour), range = high - lowest(colour);
    const float saturation = high != 0.0f ? range / high : 0.0f;
    return {saturation != 0.0f ? hue_of(colour, high, range) : 0.0f, saturation, high};
}
Rgb of_hsv(const Rgb& hsv) {
    const float saturation = hsv.y, value = hsv.z;
    if (saturation == 0.0f)
        return Rgb(value);
    const float sixths = (hsv.x == 1.0f ? 0.0f : hsv.x) * 6.0f, sector = std::floor(sixths), into = sixths - sector;
    const float least = value * (1.0f - saturation), falling = value * (1.0f - saturation * into),
                rising = value * (1.0f - saturation * (1.0f - into));
    if (sector == 0.0f)
        return {value, rising, least};
    if (sector == 1.0f)
        return {falling, value, least};
    if (sector == 2.0f)
        return {least, value, rising};
    if (sector == 3.0f)
        return {least, falling, value};
    if (sector == 4.0f)
        return {rising, least, value};
    return {value, least, falling};
}
Rgb hsl_of(const Rgb& colour) {
    const float high = highest(colour), low = lowest(colour), range = high - low;
    const float lightness = std::min(1.0f, (high + low) / 2.0f);
    if (range == 0.0f)
        return {0.0f, 0.0f, lightness};
    const float saturation = lightness > 0.5f ? range / (2.0f - high - low) : range / (high + low);
    return {hue_of(colour, high, range), saturation, lightness};
}
Rgb of_hsl(const Rgb& hsl) {
    const float sixths = hsl.x * 6.0f;
    const Rgb pure(std::abs(sixths - 3.0f) - 1.0f, 2.0f - std::abs(sixths - 2.0f), 2.0f - std::abs(sixths - 4.0f));
    const float chroma = (1.0f - std::abs(2.0f * hsl.z - 1.0f)) * hsl.y;
    return (glm::clamp(pure, 0.0f, 1.0f) - 0.5f) * chroma + hsl.z;
}

Rgb mixed(const Rgb& a, const Rgb& b, float share) { return a + share * (b - a); }

float overlaid(float a, float b, float share) {
    const float rest = 1.0f - share;
    return a < 0.5f ? a * (rest + 2.0f * share * b) : 1.0f - (rest + 2.0f * share * (1.0f - b)) * (1.0f - a);
}
float dodged(float a, float b, float share) {
    if (a == 0.0f)
        return a;
    const float left = 1.0f - share * b;
    return left <= 0.0f ? 1.0f : std::min(a / left, 1.0f);
}
float burnt(float a, float b, float share) {
    const float left = 1.0f - share + share * b;
    return left <= 0.0f ? 0.0f : std::clamp(1.0f - (1.0f - a) / left, 0.0f, 1.0f);
}

Rgb blended(BlendKind kind, const Rgb& a, const Rgb& b, float share) {
    using enum BlendKind;
    const float rest = 1.0f - share;
    switch (kind) {
    case Screen:
        return 1.0f - (rest + share * (1.0f - b)) * (1.0f - a);
    case Overlay:
        return each_channel([&](int i) { return overlaid(a[i], b[i], share); });
    case Divide:
        return each_channel([&](int i) { return b[i] != 0.0f ? rest * a[i] + share * a[i] / b[i] : a[i]; });
    case Difference:
        return mixed(a, glm::abs(a - b), share);
    case Exclusion:
        return glm::max(mixed(a, a + b - 2.0f * a * b, share), 0.0f);
    case Darken:
        return mixed(a, glm::min(a, b), share);
    case Lighten:
        return mixed(a, glm::max(a, b), share);
    case Dodge:
        return each_channel([&](int i) { return dodged(a[i], b[i], share); });
    case Burn:
        return each_channel([&](int i) { return burnt(a[i], b[i], share); });
    case Hue: {
        const Rgb other = hsv_of(b), own = hsv_of(a);
        return other.y != 0.0f ? mixed(a, of_hsv({other.x, own.y, own.z}), share) : a;
    }
    case Saturation: {
        const Rgb own = hsv_of(a);
        return own.y != 0.0f ? of_hsv({own.x, rest * own.y + share * hsv_of(b).y, own.z}) : a;
    }
    case Value: {
        const Rgb own = hsv_of(a);
        return of_hsv({own.x, own.y, rest * own.z + share * hsv_of(b).z});
    }
    case Colour: {
        const Rgb other = hsv_of(b);
        return other.y != 0.0f ? mixed(a, of_hsv({other.x, other.y, hsv_of(a).z}), share) : a;
    }
    case SoftLight: {
        const Rgb screen = 1.0f - (1.0f - b) * (1.0f - a);
        return rest * a + share * ((1.0f - a) * b * a + a * screen);
    }
    case LinearLight:
        return a + share * (2.0f * b - 1.0f);
    case Count:
        break;
    }
    return a;
}

vec4 looked_up(std::span<const vec4> values, float place, std::uint8_t options) {
    const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
    const auto steps = static_cast<float>(last);
    const auto at = [&](std::ptrdiff_t index) { return values[static_cast<std::size_t>(index)]; };
    if ((options & CurveOptions::goes_on) != 0 && last > 0) {
        if (place < 0.0f)
            return at(0) + (at(0) - at(1)) * (-place * steps);
        if (place > 1.0f)
            return at(last) + (at(last) - at(last - 1)) * ((place - 1.0f) * steps);
    }
    const float clamped = place > 0.0f ? std::min(place, 1.0f) : 0.0f; // a NaN is at the start
    const auto index = static_cast<std::ptrdiff_t>(clamped * steps);
    const float into = clamped * steps - static_cast<float>(index);
    if ((options & CurveOptions::steps) != 0 || into <= 0.0f)
        return at(index);
    return (1.0f - into) * at(index) + into * at(index + 1);
}

Rgb curved(const SurfaceOp& op, const Operands& in, std::span<const vec4> values) {
    const auto at = [&](float x) { return looked_up(values, (x - op.value.x) / (op.value.y - op.value.x), op.option); };
    switch (static_cast<CurveOf>(op.selector)) {
    case CurveOf::Colour:
        return Rgb(at(in.a.x));
    case CurveOf::Alpha:
        return Rgb(at(in.a.x).w);
    default:
        return (1.0f - in.b) * in.a + in.b * each_channel([&](int i) { return at(in.a[i])[i]; });
    }
}

/// b, c and d shift the hue, and scale saturation and value; e is the share of the result.
Rgb adjusted(const Operands& in) {
    const Rgb hsv = hsv_of(in.a);
    const float hue = hsv.x + in.b.x + 0.5f;
    const Rgb other = of_hsv({hue - std::floor(hue), std::clamp(hsv.y * in.c.x, 0.0f, 1.0f), hsv.z * in.d.x});
    return glm::max(in.e.x * other + (1.0f - in.e.x) * in.a, 0.0f);
}
} // namespace

Rgb colour_value(const SurfaceOp& op, const Operands& in, std::span<const ColorTable> tables) {
    using Code = SurfaceOp::Code;
    const auto model = static_cast<ColourModel>(op.option);
    switch (op.code) {
    case Code::Curve:
        return curved(op, in, tables[op.table].values);
    case Code::HueSaturation:
        return adjusted(in);
    case Code::Gamma:
        return in.b.x == 0.0f
                   ? Rgb(1.0f)
                   : each_channel([&](int i) { return in.a[i] > 0.0f ? std::pow(in.a[i], in.b.x) : in.a[i]; });
    case Code::Blend:
        return blended(static_cast<BlendKind>(op.option), in.a, in.b, in.c.x);
    case Code::Combine: {
        const Rgb channels(in.a.x, in.b.x, in.c.x);
        return model == ColourModel::HueSaturationValue ? of_hsv(channels) : of_hsl(channels);
    }
    default: {
        const Rgb channels = model == ColourModel::HueSaturationValue ? hsv_of(in.a) : hsl_of(in.a);
        return Rgb(channels[op.selector]);
    }
    }
}
} // namespace tyndall
