// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_inputs.hpp"
#include "shading/pixel_steps.hpp"

namespace tyndall {
namespace {
const mat4& or_identity(const mat4* matrix) {
    static const mat4 identity(1.0f);
    return matrix == nullptr ? identity : *matrix;
}
const ObjectInfo& info_of(const ProgramPoint& point) {
    static const ObjectInfo plain;
    return point.object.info == nullptr ? plain : *point.object.info;
}

const ParticleState& particle_of(const ProgramPoint& point) {
    // As in Cycles, for which all else is particle 0 with an empty state: Jenkins' hash of 0 and 0.
    static const ParticleState none{.random = 0.86031276f};
    return point.object.particle == nullptr ? none : *point.object.particle;
}

vec4 instancer_value(const SurfaceOp& op, const ProgramPoint& point) {
    const std::span<const vec4> values = point.object.instancer_values;
    return op.selector < values.size() ? values[op.selector] : vec4(0.0f);
}

/// Half a pixel beside the point, or at it.
vec3 step(const SurfaceOp& op, const ProgramPoint& point) {
    return op.shift == 0 ? vec3(0.0f) : op.value.x * pixel_steps(point).at(op.shift - 1);
}

Rgb plain_input(PointInput input, const SurfaceOp& op, const ProgramPoint& point) {
    const ShadingPoint& surface = point.surface;
    switch (input) {
    case PointInput::Position:
        return surface.position + point.origin_in_world + step(op, point);
    case PointInput::Normal:
        return surface.shading_normal;
    case PointInput::TrueNormal:
        return true_normal(point);
    case PointInput::Incoming:
        return point.incoming;
    case PointInput::Parametric:
        return {1.0f - surface.barycentrics.x - surface.barycentrics.y, surface.barycentrics.x, 0.0f};
    case PointInput::ObjectPosition:
        return point.object_position + mat3(or_identity(point.object.object_from_scene)) * step(op, point);
    case PointInput::ObjectNormal:
        return normal_in_object(point, surface.shading_normal);
    case PointInput::Reflection:
        return -glm::reflect(point.incoming, surface.shading_normal);
    case PointInput::ObjectLocation:
        return vec3(or_identity(point.object.scene_from_object)[3]) + point.origin_in_world;
    case PointInput::ObjectColor:
        return Rgb(info_of(point).color);
    case PointInput::ObjectAlpha:
        return Rgb(info_of(point).color.w);
    case PointInput::ObjectIndex:
        return Rgb(info_of(point).pass_index);
    case PointInput::ObjectRandom:
        return Rgb(point.object.random);
    case PointInput::ParticleIndex:
        return Rgb(particle_of(point).index);
    case PointInput::ParticleRandom:
        return Rgb(particle_of(point).random);
    case PointInput::ParticleAge:
        return Rgb(particle_of(point).age);
    case PointInput::ParticleLifetime:
        return Rgb(particle_of(point).lifetime);
    case PointInput::ParticleSize:
        return Rgb(particle_of(point).size);
    case PointInput::ParticleLocation:
        return particle_of(point).location;
    case PointInput::ParticleVelocity:
        return particle_of(point).velocity;
    case PointInput::ParticleAngularVelocity:
        return particle_of(point).angular_velocity;
    case PointInput::InstancerColor:
        return Rgb(instancer_value(op, point));
    case PointInput::InstancerAlpha:
        return Rgb(instancer_value(op, point).w);
    case PointInput::RayLength:
        return Rgb(point.ray_length_m);
    case PointInput::PassedCount:
        return Rgb(static_cast<float>(point.passed_count));
    case PointInput::IsRay:
        return Rgb(((op.selector >> static_cast<unsigned>(point.ray_kind)) & 1u) != 0 ? 1.0f : 0.0f);
    case PointInput::EdgeDistance:
        return Rgb(point.edge_distance_m);
    case PointInput::PixelWidth: {
        float sum = 0.0f;
        for (const vec3& step : pixel_steps(point))
            sum += glm::length(step - glm::dot(step, point.incoming) * point.incoming);
        return Rgb(0.5f * sum);
    }
    default:
        return Rgb(0.0f);
    }
}
} // namespace

vec3 true_normal(const ProgramPoint& point) {
    return point.surface.is_backface ? -point.surface.geometric_normal : point.surface.geometric_normal;
}

vec3 normal_in_scene(const ProgramPoint& point, const vec3& in_object) {
    const vec3 normal = glm::transpose(mat3(or_identity(point.object.object_from_scene))) * in_object;
    return unit_or(normal, normal);
}

vec3 normal_in_object(const ProgramPoint& point, const vec3& in_scene) {
    const vec3 normal = glm::transpose(mat3(or_identity(point.object.scene_from_object))) * in_scene;
    return unit_or(normal, normal);
}

std::array<vec3, 2> axes_across(const vec3& normal) {
    const vec3 across = normal.x != normal.y || normal.x != normal.z
                            ? vec3(normal.z - normal.y, normal.x - normal.z, normal.y - normal.x)
                            : vec3(normal.z - normal.y, normal.x + normal.z, -normal.y - normal.x);
    const vec3 first = unit_or(across, across);
    return {first, glm::cross(normal, first)};
}

std::array<vec3, 2> pixel_steps(const ProgramPoint& point) {
    const auto [first, second] = axes_across(true_normal(point));
    return {point.footprint_m * first, point.footprint_m * second};
}

Rgb input_value(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const mat4 &to_scene = or_identity(point.object.scene_from_object),
               &to_object = or_identity(point.object.object_from_scene);
    switch (const auto input = static_cast<PointInput>(op.option)) {
    case PointInput::DirectionToWorld:
        return mat3(to_scene) * in.a;
    case PointInput::DirectionToObject:
        return mat3(to_object) * in.a;
    case PointInput::PointToWorld:
        return vec3(to_scene * vec4(in.a, 1.0f)) + point.origin_in_world;
    case PointInput::PointToObject:
        return vec3(to_object * vec4(in.a - point.origin_in_world, 1.0f));
    case PointInput::NormalToWorld:
        return normal_in_scene(point, in.a);
    case PointInput::NormalToObject:
        return normal_in_object(point, in.a);
    case PointInput::Tangent: {
        const vec3& normal = point.surface.shading_normal;
        const vec3 across = glm::cross(normal_in_scene(point, in.a), normal);
        return glm::cross(normal, unit_or(across, vec3(0.0f)));
    }
    default:
        return plain_input(input, op, point);
    }
}
} // namespace tyndall
