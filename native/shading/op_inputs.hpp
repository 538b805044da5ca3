// SPDX-License-Identifier: GPL-3.0-or-later
// What programs read of a point, of its object and of the asking ray: Blender's Texture Coordinate, Geometry, Object
// Info, Particle Info, Light Path, Vector Transform and Tangent.
// Based on: blender/cycles v4.5.0 and v5.0.0, src/kernel/svm/{tex_coord,geometry,light_path,vector_transform}.h: what is
//           what there; and intern/cycles/blender/object.cpp, which instances are particles.
// Differs:  bounces count as one.
#pragma once
#include "shading/operands.hpp"
#include "shading/program_point.hpp"

namespace tyndall {
/// SurfaceOp::option of Code::Input; python/tyndall/surface_inputs.py has the same numbers. Those from DirectionToWorld
/// on read `a`.
enum class PointInput : std::uint8_t {
    Position = 0, ///< In the world.
    Normal = 1,   ///< Shading normal, on the ray's side.
    TrueNormal = 2,
    Incoming = 3,
    Parametric = 4,
    ObjectPosition = 5,
    ObjectNormal = 6,
    Reflection = 7,
    ObjectLocation = 8,
    ObjectColor = 9,
    ObjectAlpha = 10,
    ObjectIndex = 11,
    ObjectRandom = 12,
    RayLength = 13,
    IsRay = 14,        ///< 1 if the bit of the asking RayKind is set in `selector`, else 0.
    EdgeDistance = 15, ///< To the nearest edge of the triangle, in the world; infinite on all else.
    PixelWidth = 16,   ///< Of what a pixel covers here, as it is seen from the viewer, in metres; 0: not known.
    ParticleIndex = 17,
    ParticleRandom = 18,
    ParticleAge = 19,
    ParticleLifetime = 20,
    ParticleSize = 21,
    ParticleLocation = 22, ///< In the world, as the others.
    ParticleVelocity = 23,
    ParticleAngularVelocity = 24,
    InstancerColor = 25, ///< Of the values that its instancer gives to the instance, that of number `selector`.
    InstancerAlpha = 26, ///< Of the same.
    PassedCount = 27,    ///< Of transparent surfaces, on the whole way.
    PlainCount = 28,
    DirectionToWorld = 32,
    DirectionToObject = 33,
    PointToWorld = 34,
    PointToObject = 35,
    NormalToWorld = 36,
    NormalToObject = 37,
    Tangent = 38, ///< Across the shading normal, from a direction in the object.
    End = 39,
};
[[nodiscard]] inline bool reads_operand(PointInput input) { return input >= PointInput::DirectionToWorld; }
[[nodiscard]] inline bool is_known(PointInput input) {
    return input < PointInput::PlainCount || (reads_operand(input) && input < PointInput::End);
}
[[nodiscard]] inline bool is_number(PointInput input) {
    return (input >= PointInput::ObjectAlpha && input < PointInput::ParticleLocation) ||
           input == PointInput::InstancerAlpha || input == PointInput::PassedCount;
}

/// Whether the operation is that input.
[[nodiscard]] inline bool reads(const SurfaceOp& op, PointInput input) {
    return op.code == SurfaceOp::Code::Input && static_cast<PointInput>(op.option) == input;
}

/// Of an operation of Code::Input.
[[nodiscard]] Rgb input_value(const SurfaceOp& op, const ProgramPoint& point, const Operands& in);
} // namespace tyndall
