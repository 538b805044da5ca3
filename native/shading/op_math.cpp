// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_math.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace tyndall {
namespace {

/// 0 where there is nothing to divide by.
float quotient(float a, float b) { return b != 0.0f ? a / b : 0.0f; }
float power(float base, float exponent) {
    const bool is_undefined = base < 0.0f && exponent != std::trunc(exponent);
    return is_undefined ? 0.0f : std::pow(base, exponent);
}
float sign(float a) { return static_cast<float>(a > 0.0f) - static_cast<float>(a < 0.0f); }
float fraction(float a) { return a - std::floor(a); }
float truncated_modulo(float a, float b) { return b != 0.0f ? std::fmod(a, b) : 0.0f; }
float wrapped(float a, float high, float low) {
    const float range = high - low;
    return range != 0.0f ? a - range * std::floor((a - low) / range) : low;
}
float snapped(float a, float step) { return std::floor(quotient(a, step)) * step; }
float ping_pong(float a, float scale) {
    return scale != 0.0f ? std::abs(fraction((a - scale) / (scale * 2.0f)) * scale * 2.0f - scale) : 0.0f;
}
/// Below both by up to reach / 6 where they are closer than `reach`.
float smooth_minimum(float a, float b, float reach) {
    if (reach == 0.0f)
        return std::min(a, b);
    const float nearness = std::max(reach - std::abs(a - b), 0.0f) / reach;
    return std::min(a, b) - nearness * nearness * nearness * reach * (1.0f / 6.0f);
}
float clamped(float a, float low, float high) { return std::min(std::max(a, low), high); }
float clamped_either(float a, float b, float c) { return b > c ? clamped(a, c, b) : clamped(a, b, c); }

float number(MathOperation operation, float a, float b, float c) {
    using enum MathOperation;
    switch (operation) {
    case Divide:
        return quotient(a, b);
    case Power:
        return power(a, b);
    case Logarithm:
        return a <= 0.0f || b <= 0.0f ? 0.0f : quotient(std::log(a), std::log(b));
    case SquareRoot:
        return std::sqrt(std::max(a, 0.0f));
    case InverseSquareRoot:
        return a > 0.0f ? 1.0f / std::sqrt(a) : 0.0f;
    case Absolute:
        return std::abs(a);
    case Exponent:
        return std::exp(a);
    case Minimum:
        return std::min(a, b);
    case Maximum:
        return std::max(a, b);
    case LessThan:
        return a < b ? 1.0f : 0.0f;
    case GreaterThan:
        return a > b ? 1.0f : 0.0f;
    case Sign:
        return sign(a);
    case Compare:
        return a == b || std::abs(a - b) <= std::max(c, std::numeric_limits<float>::epsilon()) ? 1.0f : 0.0f;
    case SmoothMinimum:
        return smooth_minimum(a, b, c);
    case SmoothMaximum:
        return -smooth_minimum(-a, -b, c);
    case Round:
        return std::floor(a + 0.5f);
    case Floor:
        return std::floor(a);
    case Ceil:
        return std::ceil(a);
    case Truncate:
        return std::trunc(a);
    case Fraction:
        return fraction(a);
    case TruncatedModulo:
        return truncated_modulo(a, b);
    case FlooredModulo:
        return b != 0.0f ? a - std::floor(a / b) * b : 0.0f;
    case Wrap:
        return wrapped(a, b, c);
    case Snap:
        return snapped(a, b);
    case PingPong:
        return ping_pong(a, b);
    case Sine:
        return std::sin(a);
    case Cosine:
        return std::cos(a);
    case Tangent:
        return std::tan(a);
    case ArcSine:
        return std::asin(clamped(a, -1.0f, 1.0f));
    case ArcCosine:
        return std::acos(clamped(a, -1.0f, 1.0f));
    case ArcTangent:
        return std::atan(a);
    case ArcTangent2:
        return std::atan2(a, b);
    case HyperbolicSine:
        return std::sinh(a);
    case HyperbolicCosine:
        return std::cosh(a);
    case HyperbolicTangent:
        return std::tanh(a);
    case ToRadians:
        return a * (pi / 180.0f);
    case ToDegrees:
        return a * (180.0f / pi);
    case ClampBetween:
        return clamped(a, b, c);
    case ClampBetweenEither:
        return clamped_either(a, b, c);
    case Count:
        break;
    }
    return 0.0f;
}

template <typename Each>
vec3 each(const Each& value) {
    return {value(0), value(1), value(2)};
}
vec3 unit(const vec3& a) {
    const float length = glm::length(a);
    return length != 0.0f ? a / length : a;
}
vec3 refracted(const vec3& incident, const vec3& normal, float index) {
    const float cosine = glm::dot(normal, incident), rest = 1.0f - index * index * (1.0f - cosine * cosine);
    return rest < 0.0f ? vec3(0.0f) : index * incident - (index * cosine + std::sqrt(rest)) * normal;
}

vec3 vector(VectorOperation operation, const vec3& a, const vec3& b, const vec3& c) {
    using enum VectorOperation;
    switch (operation) {
    case CrossProduct:
        return glm::cross(a, b);
    case Project: {
        const float squared = glm::dot(b, b);
        return squared != 0.0f ? glm::dot(a, b) / squared * b : vec3(0.0f);
    }
    case Reflect: {
        const vec3 normal = unit(b);
        return a - 2.0f * normal * glm::dot(a, normal);
    }
    case Refract:
        return refracted(a, unit(b), c.x);
    case FaceForward:
        return glm::dot(c, b) < 0.0f ? a : -a;
    case DotProduct:
        return vec3(glm::dot(a, b));
    case Distance:
        return vec3(glm::distance(a, b));
    case Length:
        return vec3(glm::length(a));
    case Normalize:
        return unit(a);
    case Divide:
        return each([&](int i) { return quotient(a[i], b[i]); });
    case Snap:
        return each([&](int i) { return snapped(a[i], b[i]); });
    case Floor:
        return glm::floor(a);
    case Ceil:
        return glm::ceil(a);
    case Modulo:
        return each([&](int i) { return truncated_modulo(a[i], b[i]); });
    case Fraction:
        return each([&](int i) { return fraction(a[i]); });
    case Absolute:
        return glm::abs(a);
    case Power:
        return each([&](int i) { return power(a[i], b[i]); });
    case Sign:
        return each([&](int i) { return sign(a[i]); });
    case Minimum:
        return glm::min(a, b);
    case Maximum:
        return glm::max(a, b);
    case Wrap:
        return each([&](int i) { return wrapped(a[i], b[i], c[i]); });
    case Sine:
        return each([&](int i) { return std::sin(a[i]); });
    case Cosine:
        return each([&](int i) { return std::cos(a[i]); });
    case Tangent:
        return each([&](int i) { return std::tan(a[i]); });
    case Count:
        break;
    }
    return vec3(0.0f);
}

float bent(RangeKind kind, float share) {
    const float t = clamped(share, 0.0f, 1.0f);
    return kind == RangeKind::Smooth ? (3.0f - 2.0f * t) * t * t : t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}
float stepped(float share, float steps) { return steps > 0.0f ? std::floor(share * (steps + 1.0f)) / steps : 0.0f; }

/// What the number is of its way from `low` to `high`.
float share_of_range(RangeKind kind, float value, float low, float high, float steps) {
    switch (kind) {
    case RangeKind::Stepped:
        return stepped(quotient(value - low, high - low), steps);
    case RangeKind::Smooth:
    case RangeKind::Smoother:
        return bent(kind, quotient(value - low, high - low));
    default:
        return quotient(value - low, high - low);
    }
}

vec3 mapped(RangeKind kind, RangeOf of, const Operands& in) {
    const auto channel = [&](int i) {
        const float to = in.d[i], span = in.e[i] - in.d[i];
        if (of == RangeOf::Numbers && in.b[i] == in.c[i])
            return 0.0f;
        const float value = to + share_of_range(kind, in.a[i], in.b[i], in.c[i], in.f[i]) * span;
        return of == RangeOf::VectorsClamped ? clamped_either(value, in.d[i], in.e[i]) : value;
    };
    return of == RangeOf::Numbers ? vec3(channel(0)) : each(channel);
}

/// About x first, then y, then z.
mat3 by_angles(const vec3& angles) {
    const vec3 c = glm::cos(angles), s = glm::sin(angles);
    return {vec3(c.y * c.z, c.y * s.z, -s.y), vec3(s.x * s.y * c.z - c.x * s.z, s.x * s.y * s.z + c.x * c.z, s.x * c.y),
            vec3(c.x * s.y * c.z + s.x * s.z, c.x * s.y * s.z - s.x * c.z, c.x * c.y)};
}
vec3 around(const vec3& a, const vec3& axis, float angle) {
    const float cosine = std::cos(angle), sine = std::sin(angle);
    return a * cosine + glm::cross(axis, a) * sine + axis * (glm::dot(axis, a) * (1.0f - cosine));
}
vec3 rotated(RotationKind kind, const Operands& in) {
    const vec3 from_centre = in.a - in.b;
    if (kind == RotationKind::ByAngles)
        return by_angles(in.c) * from_centre + in.b;
    if (kind == RotationKind::ByAnglesBack)
        return from_centre * by_angles(in.c) + in.b;
    const float length = glm::length(in.c);
    if (length == 0.0f)
        return in.a;
    return around(from_centre, in.c / length, kind == RotationKind::AroundAxis ? in.d.x : -in.d.x) + in.b;
}
} // namespace

Rgb math_value(const SurfaceOp& op, const Operands& in) {
    switch (op.code) {
    case SurfaceOp::Code::Math:
        return Rgb(number(static_cast<MathOperation>(op.option), in.a.x, in.b.x, in.c.x));
    case SurfaceOp::Code::VectorMath:
        return vector(static_cast<VectorOperation>(op.option), in.a, in.b, in.c);
    case SurfaceOp::Code::MapRange:
        return mapped(static_cast<RangeKind>(op.option), static_cast<RangeOf>(op.selector), in);
    case SurfaceOp::Code::VectorRotate:
        return rotated(static_cast<RotationKind>(op.option), in);
    default:
        return op.uv_matrix * in.a + op.value;
    }
}
} // namespace tyndall
