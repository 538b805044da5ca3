// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/surface_program.hpp"
#include "core/errors.hpp"
#include "shading/fresnel.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/op_colour.hpp"
#include "shading/op_images.hpp"
#include "shading/op_inputs.hpp"
#include "shading/op_math.hpp"
#include "shading/op_normals.hpp"
#include "shading/op_patterns.hpp"
#include "shading/op_photometry.hpp"
#include "shading/op_surroundings.hpp"
#include "shading/point_values.hpp"
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace tyndall {
namespace {
using Code = SurfaceOp::Code;
using Registers = std::array<Rgb, surface_register_count>;

std::uint64_t bit(std::uint16_t index) { return std::uint64_t{1} << index; }

/// The registers that the operation reads.
std::uint64_t inputs(const SurfaceOp& op) {
    const std::uint16_t operands[] = {op.a, op.b, op.c, op.d, op.e, op.f};
    std::uint64_t read = 0;
    for (int operand = 0; operand < operand_count(op); ++operand)
        read |= bit(operands[operand]);
    return read;
}

/// The UV map that the operation reads; half a pixel beside the point where these are known, too. On back faces Cycles
/// turns the triangle's axes around, and with them which side is beside.
vec2 uv_of(const SurfaceOp& op, const Material& material, const ProgramPoint& point, std::span<const vec2> uvs) {
    const std::size_t beside = op.shift * material.uv_map_names.size() + op.texture_uv;
    if (op.shift == 0 || beside >= uvs.size())
        return uvs[op.texture_uv];
    const float share = point.surface.is_backface ? -op.value.x : op.value.x;
    return uvs[op.texture_uv] + share * (uvs[beside] - uvs[op.texture_uv]);
}

/// What images and UV maps give to an operation; `at` is its first operand.
vec4 texture_value(const SurfaceOp& op, const Material& material, const ProgramPoint& point, std::span<const vec2> uvs,
                   const Rgb& at) {
    switch (op.code) {
    case Code::ImageAt:
    case Code::ImageAlphaAt:
    case Code::EnvironmentAt:
        return image_at(op, material, point, at);
    default:
        break;
    }
    const vec3 uv = op.uv_matrix * vec3(uv_of(op, material, point, uvs), 1.0f);
    if (op.code == Code::Uv)
        return {uv, 1.0f};
    return material.textures[op.texture]->lookup(vec2(uv));
}

Operands operands_of(const SurfaceOp& op, const Registers& registers) {
    return {registers[op.a], registers[op.b], registers[op.c], registers[op.d], registers[op.e], registers[op.f]};
}

/// `image_value` answers for the images and the UV maps that an operation reads.
template <typename ImageValue>
Rgb result_of(const SurfaceOp& op, const Registers& registers, std::span<const ColorTable> tables,
              const ProgramPoint& point, const ImageValue& image_value) {
    const Rgb& a = registers[op.a];
    const Rgb& b = registers[op.b];
    switch (op.code) {
    case Code::Constant:
        return op.value;
    case Code::Texture:
    case Code::Uv:
    case Code::ImageAt:
    case Code::EnvironmentAt:
        return Rgb(image_value(op, a));
    case Code::TextureAlpha:
    case Code::ImageAlphaAt:
        return Rgb(image_value(op, a).w);
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
        return Rgb(point.surface.is_backface ? 1.0f : 0.0f);
    case Code::Math:
    case Code::VectorMath:
    case Code::MapRange:
    case Code::VectorRotate:
    case Code::Affine:
        return math_value(op, operands_of(op, registers));
    case Code::Curve:
    case Code::HueSaturation:
    case Code::Gamma:
    case Code::Blend:
    case Code::Combine:
    case Code::Separate:
        return colour_value(op, operands_of(op, registers), tables);
    case Code::Photometry:
        return Rgb(photometric_value(tables[op.table].values, a));
    case Code::Noise:
    case Code::Voronoi:
    case Code::Wave:
    case Code::Magic:
    case Code::Gradient:
    case Code::Checker:
    case Code::Brick:
    case Code::Musgrave:
    case Code::WhiteNoise:
    case Code::Gabor:
        return pattern_value(op, operands_of(op, registers));
    case Code::Input:
        return input_value(op, point, operands_of(op, registers));
    case Code::Fresnel:
        return Rgb(fresnel_value(point, operands_of(op, registers)));
    case Code::LayerWeight:
        return Rgb(layer_weight(op, point, operands_of(op, registers)));
    case Code::NormalMap:
        return mapped_normal(op, point, operands_of(op, registers));
    case Code::Bump:
        return bumped_normal(op, point, operands_of(op, registers));
    case Code::AmbientOcclusion:
        return Rgb(open_share(op, point, operands_of(op, registers)));
    case Code::Bevel:
        return rounded_normal(op, point, operands_of(op, registers));
    default:
        return Rgb(0.0f);
    }
}

/// Places of the operations that this register's last value depends on, in their order.
std::vector<std::uint16_t> live_operations(const Material& material, std::uint16_t result) {
    std::vector<std::uint16_t> live;
    std::uint64_t wanted = bit(result);
    for (std::size_t index = material.program.size(); index-- > 0;) {
        const SurfaceOp& op = material.program[index];
        if ((wanted & bit(op.out)) == 0)
            continue;
        live.push_back(static_cast<std::uint16_t>(index));
        wanted = (wanted & ~bit(op.out)) | inputs(op);
    }
    std::ranges::reverse(live);
    return live;
}

/// A surface neither creates nor removes light that passes: [0, 1]. The comparison's order turns a NaN into 0.
Rgb share(const Rgb& value) {
    const auto channel = [](float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; };
    return {channel(value.x), channel(value.y), channel(value.z)};
}
/// Beyond it, light on what it lights would be so large that the film counts it as none: all would be dark.
constexpr float largest_radiance = 1e18f;
Rgb bounded(const Rgb& radiance) { return glm::clamp(radiance, -largest_radiance, largest_radiance); }
/// Cycles shows what glows below 0, too: normals as colours, say.
Rgb sound_radiance(const Rgb& value) {
    const auto channel = [](float x) {
        return std::isfinite(x) ? std::clamp(x, -largest_radiance, largest_radiance) : 0.0f;
    };
    return {channel(value.x), channel(value.y), channel(value.z)};
}
/// What a program makes of a division by nearly 0 is no light.
Rgb sound_colour(const Rgb& value) {
    const auto channel = [](float x) { return x > 0.0f && x <= std::numeric_limits<float>::max() ? x : 0.0f; };
    return {channel(value.x), channel(value.y), channel(value.z)};
}
} // namespace

/// What the layers of `gloss` mirror at the point's angle, and what the coat lets in of the light on what lies below it.
static void add_gloss(const GlossLayers& layers, const Gloss& gloss, const ShadingPoint& point,
                      SurfaceClosures& closures) {
    // Of large indices dielectrics mirror less at an angle than straight on; in Cycles, whose shaders only rise, they do not.
    const float rise = fresnel_rise(point.view_cosine, layers.mirror_ior),
                by_coat = std::max(fresnel_dielectric(point.view_cosine, layers.coat_ior),
                                   fresnel_dielectric(1.0f, layers.coat_ior));
    closures.mirrored =
        point.tint * share(gloss.facing + (gloss.edge - gloss.facing) * rise) + share(gloss.coat) * by_coat;
    closures.diffuse_albedo += point.tint * sound_colour(gloss.coated) * (1.0f - by_coat);
}

/// Zero, too, where it is the point's own, or no direction.
static vec3 own_normal(std::uint16_t index, std::span<const Rgb> registers, const ShadingPoint& point) {
    if (index == LobeSource::no_register || registers[index] == point.shading_normal)
        return vec3(0.0f);
    const vec3& normal = registers[index];
    return std::abs(glm::dot(normal, normal) - 1.0f) < 1e-3f ? normal : vec3(0.0f);
}

/// A smooth mesh's, for what mirrors around it, as in Cycles; zero where the point's own will do.
static vec3 turned_normal(const ProgramPoint& at) {
    const vec3& smooth = at.surface.shading_normal;
    const vec3 turned = at.surface.is_smooth ? valid_specular(at, smooth) : smooth;
    return turned == smooth ? vec3(0.0f) : turned;
}

/// The registers are those of the program; a material without one has none.
/// What a shader's surface glows with, below its layers.
static Rgb emission_of(const LobeSource& source, std::span<const Rgb> inputs) {
    return has_emission(source.model)
               ? glm::max(Rgb(0.0f), inputs[0]) * glm::max(Rgb(0.0f), inputs[principled_emission])
               : Rgb(0.0f);
}

static void add_sources(const Material& material, std::span<const Rgb> registers, const ProgramPoint& at,
                        SurfaceClosures& closures, Lobes* lobes) {
    const ShadingPoint& point = at.surface;
    for (const LobeSource& source : material.lobe_sources) {
        LobeInputs inputs;
        for (std::size_t input = 0; input < source.constants.size(); ++input) {
            const std::uint16_t index = source.registers[input];
            inputs[input] = index == LobeSource::no_register ? source.constants[input] : registers[index];
        }
        if (at.is_of_light) {
            closures.emission += emission_of(source, inputs);
            continue;
        }
        const vec3 turned = source.turns_smooth_normals ? turned_normal(at) : vec3(0.0f);
        const auto mirror_normal = [&](std::uint16_t index) {
            const vec3 own = own_normal(index, registers, point);
            return own == vec3(0.0f) ? turned : own;
        };
        add_lobes(source, inputs, point, closures, lobes,
                  {.diffuse = own_normal(source.diffuse_normal, registers, point),
                   .facets = mirror_normal(source.facet_normal),
                   .coat = mirror_normal(source.coat_normal),
                   .outgoing = at.incoming,
                   .tangent = source.tangent == LobeSource::no_register ? vec3(0.0f) : registers[source.tangent]});
    }
}

static Registers run(const Material& material, const ProgramPoint& at, std::span<const vec2> uvs) {
    Registers registers{};
    for (const SurfaceOp& op : material.program)
        registers[op.out] =
            result_of(op, registers, material.tables, at, [&](const SurfaceOp& lookup, const Rgb& vector) {
                return texture_value(lookup, material, at, uvs, vector);
            });
    return registers;
}

Rgb emission_register_at(const Material& material, const ProgramPoint& point, std::span<const vec2> uvs) {
    return material.program.empty() ? material.constant.emission
                                    : run(material, point, uvs)[material.emission_register];
}

Rgb constant_emission(const Material& material) {
    Rgb sum = material.constant.emission;
    for (const LobeSource& source : material.lobe_sources)
        sum += emission_of(source, source.constants);
    return bounded(sum);
}

SurfaceClosures evaluate(const Material& material, const ProgramPoint& at, std::span<const vec2> uvs, Lobes* lobes) {
    const ShadingPoint& point = at.surface;
    if (material.is_constant()) {
        SurfaceClosures closures = material.constant;
        closures.diffuse_albedo *= point.tint;
        if (material.gloss)
            add_gloss(*material.gloss, material.gloss->constant, point, closures);
        if (!material.lobe_sources.empty())
            add_sources(material, {}, at, closures, lobes);
        closures.emission = bounded(closures.emission);
        return closures;
    }
    const Registers registers = run(material, at, uvs);
    SurfaceClosures closures{.diffuse_albedo = point.tint * sound_colour(registers[material.diffuse_register]),
                             .transparent = share(registers[material.transparent_register]),
                             .emission = sound_radiance(registers[material.emission_register])};
    if (material.held_out_register)
        closures.held_out = average(share(registers[*material.held_out_register]));
    if (const auto& gloss = material.gloss)
        add_gloss(*gloss,
                  {.facing = registers[gloss->facing_register],
                   .edge = registers[gloss->edge_register],
                   .coat = registers[gloss->coat_register],
                   .coated = registers[gloss->coated_register]},
                  point, closures);
    if (!material.lobe_sources.empty())
        add_sources(material, registers, at, closures, lobes);
    closures.emission = bounded(closures.emission);
    return closures;
}

TransparentOperations::TransparentOperations(const Material& material)
    : places(live_operations(material, material.transparent_register)) {
    for (const std::uint16_t place : places)
        reads |= facts_of(material.program[place]).value_or(OpFacts{}).reads;
    if (material.is_constant())
        constant = material.constant.transparent;
    else if (reads == OpReads::nothing)
        constant = evaluate_transparent(material, *this, vec4(0.0f), false);
}

template <typename ImageValue>
static Rgb transparent_by(const Material& material, const TransparentOperations& operations, const ProgramPoint& point,
                          const ImageValue& image_value) {
    if (operations.constant)
        return *operations.constant;
    Registers registers{};
    for (const std::uint16_t place : operations.places) {
        const SurfaceOp& op = material.program[place];
        registers[op.out] = result_of(op, registers, material.tables, point, image_value);
    }
    return share(registers[material.transparent_register]);
}

Rgb evaluate_transparent(const Material& material, const TransparentOperations& operations, const ProgramPoint& point,
                         std::span<const vec2> uvs) {
    return transparent_by(material, operations, point, [&](const SurfaceOp& lookup, const Rgb& vector) {
        return texture_value(lookup, material, point, uvs, vector);
    });
}

Rgb evaluate_transparent(const Material& material, const TransparentOperations& operations, const vec4& image_value,
                         bool is_backface) {
    return transparent_by(material, operations, {.surface = {.is_backface = is_backface}},
                          [&](const SurfaceOp&, const Rgb&) { return image_value; });
}

void run_on_answers(const Material& material, std::uint16_t result, std::span<const Answer> answers,
                    std::span<Rgb> values) {
    std::vector<const Answer*> answer_of(material.program.size(), nullptr);
    for (const Answer& answer : answers) {
        require(answer.place < answer_of.size() && answer.values.size() == values.size(), "material \"", material.name,
                "\" has an answer to operation ", answer.place, " of ", answer_of.size());
        answer_of[answer.place] = &answer;
    }
    for (std::size_t place = 0; place < answer_of.size(); ++place) {
        const SurfaceOp& op = material.program[place];
        require(answer_of[place] != nullptr || (facts_of(op).value_or(OpFacts{}).reads & ~OpReads::table) == 0,
                "material \"", material.name, "\" reads more than its operands in operation ",
                static_cast<int>(op.code));
    }
    for (std::size_t point = 0; point < values.size(); ++point) {
        Registers registers{};
        for (std::size_t place = 0; place < answer_of.size(); ++place) {
            const SurfaceOp& op = material.program[place];
            registers[op.out] = answer_of[place] != nullptr
                                    ? answer_of[place]->values[point]
                                    : result_of(op, registers, material.tables, {},
                                                [](const SurfaceOp&, const Rgb&) { return vec4(0.0f); });
        }
        values[point] = registers[result];
    }
}

bool has_coloured_transparency(const Material& material) {
    if (!material.has_surface || material.is_constant()) {
        const Rgb& all = material.constant.transparent;
        return material.has_surface && (all.x != all.y || all.y != all.z);
    }
    std::uint64_t coloured = 0; // registers
    for (const SurfaceOp& op : material.program) {
        const Channels channels = facts_of(op).value_or(OpFacts{}).channels;
        const bool is_coloured =
            channels == Channels::Own || (channels == Channels::AsOperands && (inputs(op) & coloured) != 0);
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
    for (const LobeSource& source : material.lobe_sources)
        if (has_emission(source.model) && (source.registers[principled_emission] != LobeSource::no_register ||
                                           source.constants[principled_emission] != Rgb(0.0f)))
            return false;
    return material.is_constant() ? material.constant.emission == Rgb(0.0f)
                                  : ends_as_zero(material, material.emission_register);
}
} // namespace tyndall
