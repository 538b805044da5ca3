// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/surface_program.hpp"
#include "core/errors.hpp"
#include "shading/fresnel.hpp"
#include <array>
#include <cstdint>

namespace tyndall {
namespace {
using Code = SurfaceOp::Code;
using Registers = std::array<Rgb, surface_register_count>;

bool is_finite(const Rgb& value) { return std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z); }

std::uint64_t bit(std::uint16_t index) { return std::uint64_t{1} << index; }

/// The registers that the operation reads.
std::uint64_t inputs(const SurfaceOp& op) {
    switch (op.code) {
    case Code::Multiply:
    case Code::Add:
    case Code::Subtract:
        return bit(op.a) | bit(op.b);
    case Code::Mix:
        return bit(op.a) | bit(op.b) | bit(op.c);
    case Code::Clamp:
    case Code::Average:
        return bit(op.a);
    case Code::Constant:
    case Code::Texture:
    case Code::TextureAlpha:
    case Code::Backfacing:
    case Code::Uv:
    default:
        return 0;
    }
}

vec4 texture_value(const SurfaceOp& op, const Material& material, std::span<const vec2> uvs) {
    const vec3 uv = op.uv_matrix * vec3(uvs[op.texture_uv], 1.0f);
    if (op.code == Code::Uv)
        return {uv, 1.0f};
    return material.textures[op.texture]->lookup(vec2(uv));
}

/// `image_value` answers for the images and the UV maps that an operation reads.
template <typename ImageValue>
Rgb result_of(const SurfaceOp& op, const Registers& registers, bool is_backface, const ImageValue& image_value) {
    const Rgb& a = registers[op.a];
    const Rgb& b = registers[op.b];
    switch (op.code) {
    case Code::Constant:
        return op.value;
    case Code::Texture:
    case Code::Uv:
        return Rgb(image_value(op));
    case Code::TextureAlpha:
        return Rgb(image_value(op).w);
    case Code::Multiply:
        return a * b;
    case Code::Add:
        return a + b;
    case Code::Subtract:
        return a - b;
    case Code::Mix:
        return a + (b - a) * glm::clamp(registers[op.c], 0.0f, 1.0f);
    case Code::Clamp:
        return glm::clamp(a, 0.0f, 1.0f);
    case Code::Average:
        return Rgb(average(a));
    case Code::Backfacing:
        return Rgb(is_backface ? 1.0f : 0.0f);
    default:
        return Rgb(0.0f);
    }
}

/// Operations that the registers in `wanted` depend on, as a mask by operation; programs of more than 64 run whole.
std::uint64_t live_operations(const Material& material, std::uint64_t wanted) {
    if (material.program.size() > 64)
        return ~std::uint64_t{0};
    std::uint64_t live = 0;
    for (std::size_t index = material.program.size(); index-- > 0;) {
        const SurfaceOp& op = material.program[index];
        if ((wanted & bit(op.out)) == 0)
            continue;
        live |= std::uint64_t{1} << index;
        wanted = (wanted & ~bit(op.out)) | inputs(op);
    }
    return live;
}

/// A surface neither creates nor removes light that passes: [0, 1]. The comparison's order turns a NaN into 0.
Rgb share(const Rgb& value) {
    const auto channel = [](float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; };
    return {channel(value.x), channel(value.y), channel(value.z)};
}
Rgb non_negative(const Rgb& value) {
    const auto channel = [](float x) { return x > 0.0f ? x : 0.0f; };
    return {channel(value.x), channel(value.y), channel(value.z)};
}
} // namespace

void validate(const Material& material) {
    const auto check_register = [&](std::uint16_t index) {
        require(index < surface_register_count, "material \"", material.name, "\" uses register ", index, " of ",
                surface_register_count);
    };
    check_register(material.diffuse_register);
    check_register(material.transparent_register);
    check_register(material.emission_register);
    const SurfaceClosures& constant = material.constant;
    require(is_finite(constant.diffuse_albedo) && is_finite(constant.transparent) && is_finite(constant.emission),
            "material \"", material.name, "\" has a colour that is not finite");
    if (material.gloss) {
        const GlossLayers& gloss = *material.gloss;
        for (const std::uint16_t index :
             {gloss.facing_register, gloss.edge_register, gloss.coat_register, gloss.coated_register})
            check_register(index);
        const Gloss& fixed = gloss.constant;
        require(is_finite(fixed.facing) && is_finite(fixed.edge) && is_finite(fixed.coat) && is_finite(fixed.coated),
                "material \"", material.name, "\" has a colour that is not finite");
        require(gloss.mirror_ior == 0.0f || (gloss.mirror_ior >= 1.0f && gloss.mirror_ior <= 1e3f), "material \"",
                material.name, "\" has a mirror_ior of ", gloss.mirror_ior, ", neither 0 nor in [1, 1000]");
        require_in(gloss.coat_ior, 1.0f, 1e3f, "coat_ior");
    }
    for (const SurfaceOp& op : material.program) {
        require(op.code <= Code::Uv, "material \"", material.name, "\" has an operation ", static_cast<int>(op.code),
                ", which this version does not know");
        for (const std::uint16_t index : {op.out, op.a, op.b, op.c, op.d, op.e, op.f})
            check_register(index);
        require(is_finite(op.value), "material \"", material.name, "\" has a value that is not finite");
        if (op.code != Code::Texture && op.code != Code::TextureAlpha && op.code != Code::Uv)
            continue;
        require(op.code == Code::Uv ||
                    (op.texture < material.textures.size() && material.textures[op.texture] != nullptr),
                "material \"", material.name, "\" reads texture ", op.texture, " of ", material.textures.size());
        require(op.texture_uv < material.uv_map_names.size(), "material \"", material.name, "\" reads UV map ",
                op.texture_uv, " of ", material.uv_map_names.size());
    }
}

/// What the layers of `gloss` mirror at the point's angle, and what the coat lets in of the light on what lies below it.
static void add_gloss(const GlossLayers& layers, const Gloss& gloss, const ShadingPoint& point,
                      SurfaceClosures& closures) {
    const float rise = fresnel_rise(point.view_cosine, layers.mirror_ior),
                by_coat = fresnel_dielectric(point.view_cosine, layers.coat_ior);
    closures.mirrored =
        point.tint * share(gloss.facing + (gloss.edge - gloss.facing) * rise) + share(gloss.coat) * by_coat;
    closures.diffuse_albedo += point.tint * non_negative(gloss.coated) * (1.0f - by_coat);
}

SurfaceClosures evaluate(const Material& material, const ProgramPoint& at, std::span<const vec2> uvs) {
    const ShadingPoint& point = at.surface;
    if (material.is_constant()) {
        SurfaceClosures closures = material.constant;
        closures.diffuse_albedo *= point.tint;
        if (material.gloss)
            add_gloss(*material.gloss, material.gloss->constant, point, closures);
        return closures;
    }
    Registers registers{};
    for (const SurfaceOp& op : material.program)
        registers[op.out] = result_of(op, registers, point.is_backface,
                                      [&](const SurfaceOp& lookup) { return texture_value(lookup, material, uvs); });
    SurfaceClosures closures{.diffuse_albedo = point.tint * non_negative(registers[material.diffuse_register]),
                             .transparent = share(registers[material.transparent_register]),
                             .emission = non_negative(registers[material.emission_register])};
    if (const auto& gloss = material.gloss)
        add_gloss(*gloss,
                  {.facing = registers[gloss->facing_register],
                   .edge = registers[gloss->edge_register],
                   .coat = registers[gloss->coat_register],
                   .coated = registers[gloss->coated_register]},
                  point, closures);
    return closures;
}

/// Those that SurfaceClosures::transparent depends on, in their order.
template <typename Visit>
static void for_each_of_transparent(const Material& material, const Visit& visit) {
    std::uint64_t live = live_operations(material, bit(material.transparent_register));
    for (const SurfaceOp& op : material.program) {
        if ((live & 1) != 0)
            visit(op);
        live = (live >> 1) | (std::uint64_t{1} << 63); // Past 64 operations all run.
    }
}

template <typename ImageValue>
static Rgb transparent_by(const Material& material, bool is_backface, const ImageValue& image_value) {
    if (material.is_constant())
        return material.constant.transparent;
    Registers registers{};
    for_each_of_transparent(
        material, [&](const SurfaceOp& op) { registers[op.out] = result_of(op, registers, is_backface, image_value); });
    return share(registers[material.transparent_register]);
}

Rgb evaluate_transparent(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs) {
    return transparent_by(material, point.surface.is_backface,
                          [&](const SurfaceOp& lookup) { return texture_value(lookup, material, uvs); });
}

Rgb evaluate_transparent(const Material& material, const vec4& image_value, bool is_backface) {
    return transparent_by(material, is_backface, [&](const SurfaceOp&) { return image_value; });
}

std::vector<const SurfaceOp*> operations_of_transparent(const Material& material) {
    std::vector<const SurfaceOp*> operations;
    for_each_of_transparent(material, [&](const SurfaceOp& op) { operations.push_back(&op); });
    return operations;
}

bool has_coloured_transparency(const Material& material) {
    const auto is_grey = [](const Rgb& value) { return value.x == value.y && value.y == value.z; };
    if (!material.has_surface || material.is_constant())
        return material.has_surface && !is_grey(material.constant.transparent);
    std::uint64_t coloured = 0; // registers
    for (const SurfaceOp& op : material.program) {
        const bool reads_colour = (inputs(op) & coloured) != 0;
        const bool is_coloured = op.code == Code::Texture || op.code == Code::Uv ||
                                 (op.code == Code::Constant && !is_grey(op.value)) ||
                                 (reads_colour && op.code != Code::Average);
        coloured = is_coloured ? coloured | bit(op.out) : coloured & ~bit(op.out);
    }
    return (coloured & bit(material.transparent_register)) != 0;
}

/// Only a register that ends as a constant is known without a point; 0 is also what an unwritten one holds.
static bool ends_as_zero(const Material& material, std::uint16_t index) {
    bool is_zero = true;
    for (const SurfaceOp& op : material.program)
        if (op.out == index)
            is_zero = op.code == Code::Constant && op.value == Rgb(0.0f);
    return is_zero;
}

bool is_opaque_everywhere(const Material& material) {
    if (!material.has_surface)
        return false;
    return material.is_constant() ? material.constant.transparent == Rgb(0.0f)
                                  : ends_as_zero(material, material.transparent_register);
}

bool is_transparent_everywhere(const Material& material) {
    return !material.has_surface || (material.is_constant() && material.constant.transparent == Rgb(1.0f));
}

bool glows_nowhere(const Material& material) {
    if (!material.has_surface)
        return true;
    return material.is_constant() ? material.constant.emission == Rgb(0.0f)
                                  : ends_as_zero(material, material.emission_register);
}
} // namespace tyndall
