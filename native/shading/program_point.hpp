// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface program may read of a point, beside UV maps and attributes: it lives while the program runs.
#pragma once
#include "shading/material.hpp"
#include <limits>
#include <span>

namespace tyndall {
class Surroundings; // surroundings.hpp
/// Which ray asks: a node program may answer each in its own way.
enum class RayKind : std::uint8_t {
    Camera = 0,
    Shadow = 1,
    Diffuse = 2,
    Glossy = 3,
    Mirror = 4,
    Transmission = 5,
    Scatter = 6 ///< By media.
};

/// What Blender's Particle Info tells of the particle that an instance is; without values: of what is none.
struct ParticleState {
    float index = 0.0f;
    float random = 0.0f;               ///< [0, 1)
    float age = 0.0f, lifetime = 0.0f; ///< In frames.
    float size = 0.0f;
    vec3 location{0.0f}, velocity{0.0f}, angular_velocity{0.0f}; ///< In the world, metres and radians per second.
    bool operator==(const ParticleState&) const = default;
};

/// The object that a point is on. Pointers may be null, and must outlive the program's run.
struct ShadedObject {
    const mat4* scene_from_object = nullptr;
    const mat4* object_from_scene = nullptr;
    const ObjectInfo* info = nullptr;
    float random = 0.0f; ///< [0, 1)
    const ParticleState* particle = nullptr;
    std::span<const vec4> instancer_values = {}; ///< That its material asks for; none: they are 0.
};

struct ProgramPoint {
    ShadingPoint surface;
    RayKind ray_kind = RayKind::Camera;
    bool is_of_light = false; ///< Its emission is asked for as a light's, which no coat or sheen dims, as in Cycles.
    vec3 incoming{0, 0, 1};   ///< Unit, back along the ray.
    float ray_length_m = 0.0f;
    std::uint32_t passed_count = 0; ///< Transparent surfaces that the way here led through.
    float footprint_m = 0.0f;       ///< What a pixel covers here, across the ray; 0: not known. Bumps differ over it.
    vec3 object_position{0.0f};     ///< In the object's space.
    vec3 origin_in_world{0.0f};     ///< What positions are relative to.
    ShadedObject object = {};
    /// Interpolated in the object's space, not of unit length; zero where the surface is flat.
    vec3 object_normal{0.0f};
    float edge_distance_m = std::numeric_limits<float>::infinity(); ///< Where the material asks for it: see PointInput.
    const Surroundings* surroundings = nullptr;                     ///< Null: a program may trace no rays here.
};
} // namespace tyndall
