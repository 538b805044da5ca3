// SPDX-License-Identifier: GPL-3.0-or-later
// Images at any vector: Blender's Image Texture and Environment Texture.
// Based on: blender/cycles v4.5.0, src/kernel/svm/image.h, src/kernel/camera/projection.h and src/util/math_float3.h.
#pragma once
#include "shading/program_point.hpp"

namespace tyndall {
/// SurfaceOp::option of Code::ImageAt and Code::ImageAlphaAt.
enum class ImageProjection : std::uint8_t {
    Flat = 0,
    Box = 1, ///< From six sides of the object, by its normal; value.x of the way between them they blend.
    Sphere = 2,
    Tube = 3,
    Count = 4,
};
/// SurfaceOp::option of Code::EnvironmentAt.
enum class EnvironmentProjection : std::uint8_t { Equirectangular = 0, MirrorBall = 1, Count = 2 };
/// SurfaceOp::selector of Code::ImageAt and Code::ImageAlphaAt: the image of each tile is in the table, (column, row,
/// index into the textures, 0) each; `texture` is the first. Outside of them it is magenta.
inline constexpr std::uint8_t image_has_tiles = 1;

/// Colour and alpha of the image of a validated operation, at a vector.
[[nodiscard]] vec4 image_at(const SurfaceOp& op, const Material& material, const ProgramPoint& point,
                            const vec3& vector);
} // namespace tyndall
