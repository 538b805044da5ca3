// SPDX-License-Identifier: GPL-3.0-or-later
// Operations of colours: models that go there and back, blends at their ends, tables between their steps.
#include "shading/op_colour.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

namespace op_colour_test {
using namespace tyndall;
using Code = SurfaceOp::Code;

namespace {
bool is_near(const Rgb& a, const Rgb& b, float within = 2e-6f) {
    return glm::length(a - b) <= within * std::max(1.0f, glm::length(b));
}
Rgb blended(BlendKind kind, const Rgb& a, const Rgb& b, float share) {
    return colour_value({.code = Code::Blend, .option = static_cast<std::uint8_t>(kind)},
                        {.a = a, .b = b, .c = Rgb(share)}, {});
}
Rgb separated(ColourModel model, const Rgb& a) {
    Rgb channels;
    for (std::uint8_t i = 0; i < 3; ++i)
        channels[i] = colour_value({.code = Code::Separate, .option = static_cast<std::uint8_t>(model), .selector = i},
                                   {.a = a}, {})[i];
    return channels;
}
Rgb combined(ColourModel model, const Rgb& channels) {
    return colour_value({.code = Code::Combine, .option = static_cast<std::uint8_t>(model)},
                        {.a = Rgb(channels.x), .b = Rgb(channels.y), .c = Rgb(channels.z)}, {});
}
const std::vector<Rgb> colours = {Rgb(0.2f, 0.6f, 0.4f),
                                  Rgb(0.9f, 0.1f, 0.3f),
                                  Rgb(0.1f, 0.2f, 0.8f),
                                  Rgb(0.7f, 0.7f, 0.1f),
                                  Rgb(0.5f),
                                  Rgb(0.0f),
                                  Rgb(1.0f),
                                  Rgb(0.6f, 0.2f, 0.9f),
                                  Rgb(0.9f, 0.2f, 0.6f)};
} // namespace

TEST_CASE("hue, saturation, and value or lightness are the colour again") {
    for (const ColourModel model : {ColourModel::HueSaturationValue, ColourModel::HueSaturationLightness})
        for (const Rgb& colour : colours) {
            const Rgb channels = separated(model, colour);
            CAPTURE(channels.x);
            CHECK(is_near(combined(model, channels), colour));
            CHECK(channels.x >= 0.0f);
            CHECK(channels.x < 1.0f);
        }
    CHECK(separated(ColourModel::HueSaturationValue, Rgb(0.0f, 0.5f, 0.0f)) == Rgb(1.0f / 3.0f, 1.0f, 0.5f));
    CHECK(separated(ColourModel::HueSaturationLightness, Rgb(0.0f, 0.0f, 1.0f)) == Rgb(2.0f / 3.0f, 1.0f, 0.5f));
    CHECK(combined(ColourModel::HueSaturationValue, Rgb(1.0f, 1.0f, 2.0f)) == Rgb(2.0f, 0.0f, 0.0f)); // red once more
}

TEST_CASE("a blend without a share leaves its colour alone") {
    for (std::uint8_t kind = 0; kind < static_cast<std::uint8_t>(BlendKind::Count); ++kind)
        for (const Rgb& a : colours)
            for (const Rgb& b : colours) {
                CAPTURE(kind);
                CHECK(is_near(blended(static_cast<BlendKind>(kind), a, b, 0.0f), a));
            }
}

TEST_CASE("blends keep what their names say") {
    using enum BlendKind;
    const auto hsv = [](const Rgb& a) { return separated(ColourModel::HueSaturationValue, a); };
    for (const Rgb& a : colours)
        for (const Rgb& b : colours) {
            CHECK(is_near(blended(Screen, a, b, 1.0f), blended(Screen, b, a, 1.0f)));
            CHECK(is_near(blended(Difference, a, b, 1.0f), blended(Lighten, a, b, 1.0f) - blended(Darken, a, b, 1.0f)));
            CHECK(is_near(blended(LinearLight, a, Rgb(0.5f), 0.7f), a)); // half is its neutral colour
            CHECK(is_near(blended(SoftLight, a, Rgb(0.5f), 0.7f),
                          a + 0.7f * (0.5f * a * (1.0f - a) + a * (0.5f + 0.5f * a) - a)));
            CHECK(is_near(blended(Exclusion, a, Rgb(1.0f), 1.0f), 1.0f - a));
            CHECK(is_near(Rgb(hsv(blended(Value, a, b, 1.0f)).z), Rgb(hsv(b).z)));
            if (hsv(a).y > 0.0f)
                CHECK(is_near(Rgb(hsv(blended(Saturation, a, b, 1.0f)).y), Rgb(hsv(b).y)));
            if (hsv(a).y > 0.0f && hsv(b).y > 0.0f)
                CHECK(is_near(Rgb(hsv(blended(Hue, a, b, 1.0f)).x), Rgb(hsv(b).x)));
            if (hsv(b).y > 0.0f && hsv(a).z > 0.0f) {
                const Rgb found = hsv(blended(Colour, a, b, 1.0f));
                CHECK(is_near(found, Rgb(hsv(b).x, hsv(b).y, hsv(a).z)));
            }
        }
    CHECK(blended(Divide, Rgb(0.5f), Rgb(0.25f, 0.0f, 2.0f), 1.0f) == Rgb(2.0f, 0.5f, 0.25f));
    CHECK(blended(Dodge, Rgb(0.25f, 0.0f, 0.9f), Rgb(0.5f, 1.0f, 0.5f), 1.0f) == Rgb(0.5f, 0.0f, 1.0f));
    CHECK(blended(Burn, Rgb(0.75f, 0.2f, 1.0f), Rgb(0.5f, 0.0f, 0.5f), 1.0f) == Rgb(0.5f, 0.0f, 1.0f));
    CHECK(blended(Overlay, Rgb(0.25f, 0.75f, 0.5f), Rgb(0.5f), 1.0f) == Rgb(0.25f, 0.75f, 0.5f));
    CHECK(blended(Overlay, Rgb(0.25f), Rgb(1.0f), 1.0f) == Rgb(0.5f));
}

TEST_CASE("hue goes round, saturation ends at 1, and a share mixes") {
    const auto adjusted = [](const Rgb& a, float hue, float saturation, float value, float share) {
        return colour_value({.code = Code::HueSaturation},
                            {.a = a, .b = Rgb(hue), .c = Rgb(saturation), .d = Rgb(value), .e = Rgb(share)}, {});
    };
    for (const Rgb& a : colours) {
        CHECK(is_near(adjusted(a, 0.5f, 1.0f, 1.0f, 1.0f), a));
        CHECK(is_near(adjusted(a, 1.5f, 1.0f, 1.0f, 1.0f), a));
        CHECK(is_near(adjusted(a, 0.5f, 1.0f, 3.0f, 0.5f), 2.0f * a));
        CHECK(is_near(adjusted(a, 0.1f, 0.0f, 1.0f, 1.0f), Rgb(std::max({a.x, a.y, a.z}))));
    }
    CHECK(is_near(adjusted(Rgb(1.0f, 0.0f, 0.0f), 0.5f + 1.0f / 3.0f, 1.0f, 1.0f, 1.0f), Rgb(0.0f, 1.0f, 0.0f)));
    CHECK(adjusted(Rgb(1.0f, 0.5f, 0.5f), 0.5f, 9.0f, 1.0f, 1.0f) == Rgb(1.0f, 0.0f, 0.0f));
    CHECK(adjusted(Rgb(0.5f), 0.5f, 1.0f, -2.0f, 1.0f) == Rgb(0.0f)); // light is not negative
}

TEST_CASE("gamma bends what is light, and only that") {
    const auto bent = [](const Rgb& a, float gamma) {
        return colour_value({.code = Code::Gamma}, {.a = a, .b = Rgb(gamma)}, {});
    };
    CHECK(bent(Rgb(4.0f, -4.0f, 0.25f), 0.5f) == Rgb(2.0f, -4.0f, 0.5f));
    CHECK(bent(Rgb(4.0f, -4.0f, 0.25f), 0.0f) == Rgb(1.0f));
}

TEST_CASE("a table is straight between its steps, and ends or goes on beyond them") {
    const std::vector<ColorTable> tables = {
        {{vec4(0.0f, 1.0f, 2.0f, 0.5f), vec4(1.0f, 3.0f, 2.0f, 1.0f), vec4(0.0f, 7.0f, 4.0f, 0.0f)}}};
    const auto at = [&](float x, CurveOf of, std::uint8_t options = 0) {
        return colour_value({.code = Code::Curve,
                             .option = options,
                             .selector = static_cast<std::uint8_t>(of),
                             .value = Rgb(10.0f, 14.0f, 0.0f)},
                            {.a = Rgb(x), .b = Rgb(1.0f)}, tables);
    };
    CHECK(at(10.0f, CurveOf::Colour) == Rgb(0.0f, 1.0f, 2.0f));
    CHECK(at(11.0f, CurveOf::Colour) == Rgb(0.5f, 2.0f, 2.0f));
    CHECK(at(11.0f, CurveOf::Alpha) == Rgb(0.75f));
    CHECK(at(13.0f, CurveOf::Each) == Rgb(0.5f, 5.0f, 3.0f));
    CHECK(at(11.9f, CurveOf::Colour, CurveOptions::steps) == Rgb(0.0f, 1.0f, 2.0f));
    CHECK(at(99.0f, CurveOf::Colour) == Rgb(0.0f, 7.0f, 4.0f));
    CHECK(at(-99.0f, CurveOf::Colour) == Rgb(0.0f, 1.0f, 2.0f));
    CHECK(at(15.0f, CurveOf::Each, CurveOptions::goes_on) == Rgb(-0.5f, 9.0f, 5.0f));
    CHECK(at(8.0f, CurveOf::Each, CurveOptions::goes_on) == Rgb(-1.0f, -1.0f, 2.0f));
    CHECK(at(std::nanf(""), CurveOf::Colour) == Rgb(0.0f, 1.0f, 2.0f));
}

TEST_CASE("each channel has its own curve, and a share of the result is mixed in") {
    const std::vector<ColorTable> tables = {{{vec4(0.0f), vec4(1.0f, 2.0f, 4.0f, 0.0f)}}};
    const Rgb half = colour_value(
        {.code = Code::Curve, .selector = static_cast<std::uint8_t>(CurveOf::Each), .value = Rgb(0.0f, 1.0f, 0.0f)},
        {.a = Rgb(0.5f, 0.25f, 1.0f), .b = Rgb(0.5f)}, tables);
    CHECK(half == Rgb(0.5f, 0.375f, 2.5f));
}
} // namespace op_colour_test
