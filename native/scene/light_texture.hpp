// SPDX-License-Identifier: GPL-3.0-or-later
// What colours the beam of a light: an image in its node tree, read as Cycles reads it, or a gobo before a sun.
// Based on: blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/kernel/light and src/kernel/svm: which vectors a light's shader
//           sees. Measured in the three; tests/blender/test_gobos.py compares pictures.
// Differs:  the one light that a shader makes by the distance, Light Falloff, is not in the picture but beside it. A sun's
//           shader sees no position, so that a sun's image is ours alone: it lies across the light in metres. What an
//           area light's nodes show is such a picture, too, drawn once (shading/emitter_program.hpp).
#pragma once
#include "core/math.hpp"
#include "image/filtered_texture.hpp"
#include "scene/light.hpp"
#include "scene/planar_placement.hpp"
#include <memory>

namespace tyndall {
/// How a place in the light's space becomes a place in the picture.
enum class LightProjection : std::uint8_t {
    Planar = 0,      ///< Sun: across the light, in metres.
    Direct = 1,      ///< Its first two components.
    Perspective = 2, ///< Those divided by the third: how a slide is thrown.
    Sphere = 3,      ///< Longitude and latitude, as Cycles' map_to_sphere.
    Emitter = 4,     ///< Area: where the light leaves it; its box is (0, 0) to (1, 1) along its light_axes.
    Directions = 5,  ///< As Sphere, of a picture whose texels are an angle apart, without a seam: texel_rad.
};

/// Of a point and a light: vector = the direction in which the light leaves, or the emitter's normal there; axes =
/// axes_from_world * vector, of unit length; place = place_from_axes * (axes, 1); projected to a uv; uv_from_projected *
/// (uv, 1). A planar picture has its place from the light's axes, and uses none of it; one on the emitter only the last.
struct LightTexture {
    std::shared_ptr<const FilteredTexture> image = {};
    LightProjection projection = LightProjection::Planar;
    /// Planar: width and height, (0, 1e6]; upright along the light's axes, as a LightMask; centre_m is where its middle
    /// is, from the line through the light's origin.
    vec2 size_m{10.0f};
    vec2 centre_m{0.0f};
    bool follows_normal = false; ///< Of a sphere that emits. Discs and points have their normal along the light.
    mat3 axes_from_world{1.0f};
    glm::mat4x3 place_from_axes{1.0f};
    mat3 uv_from_projected{1.0f}; ///< Affine.
    /// The light's strength is multiplied by offset + gain * image.
    Rgb offset{0.0f};
    mat3 gain{1.0f};
    /// But of a sun: by the distance d from where the light leaves, times d^distance_power, [0, 2], and d^2 / (d^2 + smooth).
    std::uint8_t distance_power = 0;
    float smooth_m2 = 0.0f; ///< [0, 1e12]

    bool operator==(const LightTexture&) const = default; ///< Of the same image, not of an equal one.
    /// Of a uv, mean of a square `texels` wide; up to one: as sharp as the image is.
    [[nodiscard]] Rgb colour(vec2 uv, float texels = 1.0f) const { return offset + gain * image->lookup(uv, texels); }
};

/// How a spot throws a picture over its cone, and a point light all around it: without the picture.
[[nodiscard]] LightTexture thrown_by(const Light& lamp);
/// Throws InvalidInput that names what is out of its range.
void require_usable(const LightTexture& texture);
/// What the distance multiplies the light by, given its square.
[[nodiscard]] inline float distance_share(const LightTexture& texture, float distance2_m2) {
    const float power = texture.distance_power == 0   ? 1.0f
                        : texture.distance_power == 1 ? std::sqrt(distance2_m2)
                                                      : distance2_m2;
    return texture.smooth_m2 > 0.0f ? power * distance2_m2 / (distance2_m2 + texture.smooth_m2) : power;
}
[[nodiscard]] inline bool changes_with_distance(const LightTexture& texture) {
    return texture.distance_power > 0 || texture.smooth_m2 > 0.0f;
}
/// Of a picture of directions: the angle from one row to the next.
[[nodiscard]] float texel_rad(const LightTexture& texture);
/// Where the picture of a textured light is read for light that leaves `emitter`, a point on or in the light, for `point`.
/// Of a sun, emitter is any point towards it.
[[nodiscard]] vec2 texture_uv(const Light& light, const vec3& emitter, const vec3& point);
/// The same of a vector along axes_from_world, of any length.
[[nodiscard]] vec2 uv_of_axes(const LightTexture& texture, const vec3& axes);
/// offset + gain * image there, times the distance_share; white for a light without a texture.
[[nodiscard]] Rgb texture_colour(const Light& light, const vec3& emitter, const vec3& point);
/// Of a sample that is textured: what multiplies its strength for a point. Patches of an area light have their part of the
/// picture in it.
[[nodiscard]] Rgb texture_colour(const LightSample& sample, const vec3& point);
/// Of an area light, the mean over one of `part_count` equal parts of it around a point on it; 1: over all of it.
[[nodiscard]] Rgb mean_colour(const Light& light, const vec3& emitter, std::uint32_t part_count);
/// How a planar picture lies across a sun.
[[nodiscard]] PlanarPlacement planar_placement(const Light& sun, const LightTexture& texture);
} // namespace tyndall
