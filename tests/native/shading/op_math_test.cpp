// SPDX-License-Identifier: GPL-3.0-or-later
// Operations of numbers and vectors are what their names say: closed forms, inverses, and the cases without an answer.
#include "shading/op_math.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

namespace op_math_test {
using namespace tyndall;
using Code = SurfaceOp::Code;

namespace {

float number(MathOperation operation, float a, float b = 0.0f, float c = 0.0f) {
    const Rgb all = math_value({.code = Code::Math, .option = static_cast<std::uint8_t>(operation)},
                               {.a = Rgb(a), .b = Rgb(b), .c = Rgb(c)});
    CHECK(all.x == all.y);
    CHECK(all.y == all.z);
    return all.x;
}
vec3 vector(VectorOperation operation, const vec3& a, const vec3& b = vec3(0.0f), const vec3& c = vec3(0.0f)) {
    return math_value({.code = Code::VectorMath, .option = static_cast<std::uint8_t>(operation)},
                      {.a = a, .b = b, .c = c});
}
bool is_near(float a, float b, float within = 1e-6f) { return std::abs(a - b) <= within * std::max(1.0f, std::abs(b)); }
bool is_near(const vec3& a, const vec3& b) { return is_near(a.x, b.x) && is_near(a.y, b.y) && is_near(a.z, b.z); }
const std::vector<float> some = {-2.6f, -1.0f, -0.5f, -1e-3f, 0.0f, 0.25f, 1.0f, 1.75f, 40.0f};
} // namespace

TEST_CASE("functions undo one another where both are defined") {
    using enum MathOperation;
    for (const float x : some) {
        CAPTURE(x);
        CHECK(is_near(number(Logarithm, number(Exponent, x), number(Exponent, 1.0f)), x, 1e-5f));
        CHECK(is_near(number(ToDegrees, number(ToRadians, x)), x));
        CHECK(is_near(number(ArcTangent2, number(Sine, x), number(Cosine, x)), std::remainder(x, 2.0f * pi), 1e-5f));
        CHECK(is_near(number(Tangent, number(ArcTangent, x)), x, 1e-4f));
        if (std::abs(x) <= 1.0f) {
            CHECK(is_near(number(Sine, number(ArcSine, x)), x));
            CHECK(is_near(number(Cosine, number(ArcCosine, x)), x));
        }
        if (std::abs(x) < 4.0f) {
            CHECK(is_near(number(HyperbolicCosine, x) * number(HyperbolicCosine, x) -
                              number(HyperbolicSine, x) * number(HyperbolicSine, x),
                          1.0f, 1e-4f));
            CHECK(is_near(number(HyperbolicTangent, x) * number(HyperbolicCosine, x), number(HyperbolicSine, x)));
        }
        if (x > 0.0f) {
            CHECK(is_near(number(SquareRoot, x) * number(InverseSquareRoot, x), 1.0f));
            CHECK(is_near(number(Power, number(Power, x, 3.0f), 1.0f / 3.0f), x, 1e-5f));
        }
    }
}

TEST_CASE("a number is its whole part and its fraction, on either side of 0") {
    using enum MathOperation;
    for (const float x : some) {
        CAPTURE(x);
        CHECK(is_near(number(Floor, x) + number(Fraction, x), x));
        CHECK(number(Ceil, x) == -number(Floor, -x));
        CHECK(std::abs(number(Truncate, x)) == number(Floor, number(Absolute, x)));
        CHECK(is_near(number(Sign, x) * number(Absolute, x), x));
        for (const float y : {0.75f, -0.75f, 2.0f}) {
            CHECK(is_near(number(Truncate, x / y) * y + number(TruncatedModulo, x, y), x, 1e-5f));
            CHECK(is_near(number(Floor, x / y) * y + number(FlooredModulo, x, y), x, 1e-5f));
            CHECK(is_near(number(Snap, x, y), number(Floor, x / y) * y));
        }
    }
    CHECK(number(Round, 0.5f) == 1.0f);
    CHECK(number(Round, -0.5f) == 0.0f);
}

TEST_CASE("what leaves a range comes back: at its other end, or as in a mirror") {
    using enum MathOperation;
    for (const float x : some)
        for (const int turns : {-3, 0, 2}) {
            CAPTURE(x);
            const float wrapped = number(Wrap, x, 3.0f, -1.0f), moved = x + 4.0f * static_cast<float>(turns);
            CHECK(wrapped >= -1.0f);
            CHECK(wrapped < 3.0f);
            CHECK(is_near(number(Wrap, moved, 3.0f, -1.0f), wrapped, 1e-5f));
            CHECK(is_near(number(PingPong, moved, 2.0f), number(PingPong, x, 2.0f), 1e-5f));
            CHECK(is_near(number(PingPong, -x, 2.0f), number(PingPong, x, 2.0f), 1e-5f));
        }
    CHECK(number(PingPong, 1.5f, 2.0f) == 1.5f);
    CHECK(number(PingPong, 2.5f, 2.0f) == 1.5f);
}

TEST_CASE("smooth extremes are the plain ones where numbers lie apart, and a sixth of the reach off where they meet") {
    using enum MathOperation;
    CHECK(number(SmoothMinimum, 1.0f, 3.0f, 1.5f) == 1.0f);
    CHECK(number(SmoothMaximum, 1.0f, 3.0f, 1.5f) == 3.0f);
    CHECK(number(SmoothMinimum, 1.0f, 3.0f, 0.0f) == 1.0f);
    CHECK(is_near(number(SmoothMinimum, 2.0f, 2.0f, 1.5f), 1.75f));
    CHECK(is_near(number(SmoothMaximum, 2.0f, 2.0f, 1.5f), 2.25f));
}

TEST_CASE("what has no answer is 0, and comparisons answer 0 or 1") {
    using enum MathOperation;
    CHECK(number(Divide, 3.0f, 0.0f) == 0.0f);
    CHECK(number(Power, -8.0f, 0.5f) == 0.0f);
    CHECK(number(Power, -2.0f, 3.0f) == -8.0f);
    CHECK(number(Logarithm, -1.0f, 2.0f) == 0.0f);
    CHECK(number(Logarithm, 3.0f, 1.0f) == 0.0f);
    CHECK(number(SquareRoot, -4.0f) == 0.0f);
    CHECK(number(InverseSquareRoot, 0.0f) == 0.0f);
    CHECK(number(TruncatedModulo, 1.0f, 0.0f) == 0.0f);
    CHECK(number(Wrap, 5.0f, 2.0f, 2.0f) == 2.0f);
    CHECK(number(LessThan, 1.0f, 2.0f) == 1.0f);
    CHECK(number(GreaterThan, 1.0f, 2.0f) == 0.0f);
    CHECK(number(Compare, 1.0f, 1.2f, 0.3f) == 1.0f);
    CHECK(number(Compare, 1.0f, 1.2f, 0.1f) == 0.0f);
    CHECK(number(Minimum, 1.0f, 2.0f) == 1.0f);
    CHECK(number(Maximum, 1.0f, 2.0f) == 2.0f);
    CHECK(number(ClampBetween, 5.0f, 3.0f, 1.0f) == 1.0f);
    CHECK(number(ClampBetweenEither, 5.0f, 3.0f, 1.0f) == 3.0f);
    CHECK(number(ClampBetweenEither, -5.0f, 3.0f, 1.0f) == 1.0f);
}

TEST_CASE("vectors keep the rules of geometry") {
    using enum VectorOperation;
    const vec3 a(1.0f, -2.0f, 0.5f), b(0.25f, 3.0f, -1.0f), up(0.0f, 0.0f, 2.0f);
    const vec3 cross = vector(CrossProduct, a, b);
    CHECK(is_near(vector(DotProduct, cross, a), vec3(0.0f)));
    CHECK(is_near(vector(DotProduct, cross, b), vec3(0.0f)));
    const vec3 along = vector(Project, a, b);
    CHECK(is_near(vector(CrossProduct, along, b), vec3(0.0f)));
    CHECK(is_near(vector(DotProduct, a - along, b), vec3(0.0f)));
    CHECK(vector(Reflect, a, up) == vec3(1.0f, -2.0f, -0.5f)); // however long the normal
    CHECK(vector(Distance, a, b).x == vector(Length, a - b).x);
    CHECK(is_near(vector(Length, vector(Normalize, a)).x, 1.0f));
    CHECK(vector(Normalize, vec3(0.0f)) == vec3(0.0f));
    CHECK(vector(FaceForward, a, up, -up) == a);
    CHECK(vector(FaceForward, a, up, up) == -a);
    CHECK(vector(Project, a, vec3(0.0f)) == vec3(0.0f));
    CHECK(vector(Divide, a, vec3(2.0f, 0.0f, 0.25f)) == vec3(0.5f, 0.0f, 2.0f));
    CHECK(vector(Floor, a) + vector(Fraction, a) == a);
    CHECK(vector(Sign, a) * vector(Absolute, a) == a);
    CHECK(vector(Maximum, a, b) + vector(Minimum, a, b) == a + b);
    CHECK(vector(Power, vec3(4.0f, -2.0f, -2.0f), vec3(0.5f, 2.0f, 0.5f)) == vec3(2.0f, 4.0f, 0.0f));
}

TEST_CASE("a refracted direction follows Snell's law, and is nothing beyond the critical angle") {
    const vec3 normal(0.0f, 0.0f, 1.0f);
    for (const float angle : {0.1f, 0.4f, 0.7f}) {
        const vec3 incident(std::sin(angle), 0.0f, -std::cos(angle));
        const vec3 inside = vector(VectorOperation::Refract, incident, normal * 3.0f, vec3(1.0f / 1.5f));
        CHECK(is_near(inside.x * 1.5f, std::sin(angle)));
        CHECK(is_near(glm::length(inside), 1.0f));
        CHECK((vector(VectorOperation::Refract, incident, normal, vec3(1.8f)) == vec3(0.0f)) ==
              (1.8f * std::sin(angle) > 1.0f));
    }
}

TEST_CASE("a range goes from one end to the other, by steps or smoothly, and nowhere from a point") {
    const auto mapped = [](RangeKind kind, RangeOf of, float x, float steps = 4.0f) {
        return math_value(
                   {.code = Code::MapRange,
                    .option = static_cast<std::uint8_t>(kind),
                    .selector = static_cast<std::uint8_t>(of)},
                   {.a = Rgb(x), .b = Rgb(2.0f), .c = Rgb(4.0f), .d = Rgb(10.0f), .e = Rgb(-10.0f), .f = Rgb(steps)})
            .x;
    };
    for (const RangeKind kind : {RangeKind::Linear, RangeKind::Stepped, RangeKind::Smooth, RangeKind::Smoother}) {
        CHECK(mapped(kind, RangeOf::Numbers, 2.0f) == 10.0f);
        if (kind != RangeKind::Stepped) {
            CHECK(mapped(kind, RangeOf::Numbers, 3.0f) == 0.0f);
            CHECK(mapped(kind, RangeOf::Numbers, 4.0f) == -10.0f);
        }
        CHECK(mapped(kind, RangeOf::VectorsClamped, 9.0f) == -10.0f);
        CHECK(mapped(kind, RangeOf::Vectors, 3.5f) == mapped(kind, RangeOf::Numbers, 3.5f));
    }
    CHECK(mapped(RangeKind::Linear, RangeOf::Numbers, 5.0f) == -20.0f);
    CHECK(mapped(RangeKind::Smooth, RangeOf::Numbers, 5.0f) == -10.0f);
    CHECK(mapped(RangeKind::Stepped, RangeOf::Numbers, 2.3f) == 10.0f); // of 5 levels, 0.4 wide each
    CHECK(mapped(RangeKind::Stepped, RangeOf::Numbers, 2.45f) == 5.0f);
    CHECK(mapped(RangeKind::Stepped, RangeOf::Numbers, 3.9f, 0.0f) == 10.0f);
    CHECK(math_value({.code = Code::MapRange}, {.a = Rgb(3.0f), .d = Rgb(5.0f), .e = Rgb(6.0f)}) == Rgb(0.0f));
}

TEST_CASE("rotations keep lengths, go back again, and agree between axes and angles") {
    const auto turned = [](RotationKind kind, const vec3& a, const vec3& centre, const vec3& axis, float angle = 0.0f) {
        return math_value({.code = Code::VectorRotate, .option = static_cast<std::uint8_t>(kind)},
                          {.a = a, .b = centre, .c = axis, .d = Rgb(angle)});
    };
    using enum RotationKind;
    const vec3 a(1.0f, -2.0f, 0.5f), centre(0.5f, 0.25f, -3.0f), axis(1.0f, 2.0f, -0.5f), angles(0.3f, -1.1f, 2.0f);
    const vec3 once = turned(AroundAxis, a, centre, axis, 1.2f);
    CHECK(is_near(glm::distance(once, centre), glm::distance(a, centre)));
    CHECK(is_near(turned(AroundAxisBack, once, centre, axis, 1.2f), a));
    CHECK(is_near(turned(ByAnglesBack, turned(ByAngles, a, centre, angles), centre, angles), a));
    CHECK(is_near(turned(AroundAxis, vec3(1, 0, 0), vec3(0.0f), vec3(0, 0, 3), pi / 2.0f), vec3(0, 1, 0)));
    CHECK(turned(AroundAxis, a, centre, vec3(0.0f), 1.2f) == a);
    vec3 by_axes = a;
    for (int i = 0; i < 3; ++i) {
        vec3 unit(0.0f);
        unit[i] = 1.0f;
        by_axes = turned(AroundAxis, by_axes, centre, unit, angles[i]);
    }
    CHECK(is_near(turned(ByAngles, a, centre, angles), by_axes)); // about x first, z last
}
} // namespace op_math_test
