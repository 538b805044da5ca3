// SPDX-License-Identifier: GPL-3.0-or-later
// Operations of numbers and vectors: Blender's Math, Vector Math, Map Range, Clamp, Vector Rotate and Mapping.
// Based on: the definitions in Blender's manual; where it leaves a case open (a division by 0), what Cycles gives.
#pragma once
#include "shading/operands.hpp"
#include "shading/surface_op.hpp"

namespace tyndall {
/// SurfaceOp::option of Code::Math, whose operands and result are numbers. python/tyndall/surface_codes.py has them, too.
enum class MathOperation : std::uint8_t {
    Divide,
    Power,
    Logarithm,
    SquareRoot,
    InverseSquareRoot,
    Absolute,
    Exponent,
    Minimum,
    Maximum,
    LessThan,
    GreaterThan,
    Sign,
    Compare,       ///< |a - b| <= c
    SmoothMinimum, ///< Of a and b, over c.
    SmoothMaximum,
    Round,
    Floor,
    Ceil,
    Truncate,
    Fraction,
    TruncatedModulo,
    FlooredModulo,
    Wrap, ///< a between c and b
    Snap,
    PingPong,
    Sine,
    Cosine,
    Tangent,
    ArcSine,
    ArcCosine,
    ArcTangent,
    ArcTangent2,
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
    ToRadians,
    ToDegrees,
    ClampBetween,       ///< a between b and c; c, where b is the larger.
    ClampBetweenEither, ///< a between b and c, whichever is larger.
    Count,
};

/// SurfaceOp::option of Code::VectorMath. DotProduct, Distance and Length are numbers.
enum class VectorOperation : std::uint8_t {
    CrossProduct,
    Project,
    Reflect,
    Refract, ///< a at the normal b, by the index in c.
    FaceForward,
    DotProduct,
    Distance,
    Length,
    Normalize,
    Divide,
    Snap,
    Floor,
    Ceil,
    Modulo,
    Fraction,
    Absolute,
    Power,
    Sign,
    Minimum,
    Maximum,
    Wrap,
    Sine,
    Cosine,
    Tangent,
    Count,
};
[[nodiscard]] constexpr int operand_count(MathOperation operation) {
    using enum MathOperation;
    switch (operation) {
    case Divide:
    case Power:
    case Logarithm:
    case Minimum:
    case Maximum:
    case LessThan:
    case GreaterThan:
    case TruncatedModulo:
    case FlooredModulo:
    case Snap:
    case PingPong:
    case ArcTangent2:
        return 2;
    case Compare:
    case SmoothMinimum:
    case SmoothMaximum:
    case Wrap:
    case ClampBetween:
    case ClampBetweenEither:
        return 3;
    default:
        return 1;
    }
}
[[nodiscard]] constexpr int operand_count(VectorOperation operation) {
    using enum VectorOperation;
    switch (operation) {
    case Refract:
    case FaceForward:
    case Wrap:
        return 3;
    case CrossProduct:
    case Project:
    case Reflect:
    case DotProduct:
    case Distance:
    case Divide:
    case Snap:
    case Modulo:
    case Power:
    case Minimum:
    case Maximum:
        return 2;
    default:
        return 1;
    }
}
[[nodiscard]] constexpr bool is_number(VectorOperation operation) {
    return operation == VectorOperation::DotProduct || operation == VectorOperation::Distance ||
           operation == VectorOperation::Length;
}

/// SurfaceOp::option of Code::MapRange: a from [b, c] to [d, e], with f steps.
enum class RangeKind : std::uint8_t { Linear, Stepped, Smooth, Smoother, Count };
/// SurfaceOp::selector of Code::MapRange.
enum class RangeOf : std::uint8_t { Numbers, Vectors, VectorsClamped, Count };

/// SurfaceOp::option of Code::VectorRotate: a around b, by the axis c and the angle d, or by the three angles c.
enum class RotationKind : std::uint8_t { AroundAxis, AroundAxisBack, ByAngles, ByAnglesBack, Count };

/// Of the codes Math to Affine.
[[nodiscard]] Rgb math_value(const SurfaceOp& op, const Operands& in);
} // namespace tyndall
