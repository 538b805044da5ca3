// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/hair_models.hpp"
#include "shading/lobes/fibre.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/material.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
namespace hair {
namespace {
constexpr std::size_t principled_inputs = 13, hair_bsdf_inputs = 6;
constexpr float least_roughness = 1e-3f;
constexpr float least_share = 1e-5f; ///< Shares below do not count.

float clamped(float x, float low, float high) { return x > low ? std::min(x, high) : low; } // low for a NaN
Rgb non_negative(const Rgb& value) {
    return {clamped(value.x, 0.0f, 1e18f), clamped(value.y, 0.0f, 1e18f), clamped(value.z, 0.0f, 1e18f)};
}
float largest(const Rgb& value) { return std::max({value.x, value.y, value.z}); }
float root(float x) { return std::sqrt(std::max(x, 0.0f)); }

float power(float x, int exponent) {
    float product = 1.0f;
    for (; exponent > 0; --exponent)
        product *= x;
    return product;
}
} // namespace

Rgb absorption_of_colour(const Rgb& colour, float radial_roughness) {
    const float b = radial_roughness;
    const float fit = 5.969f + b * (-0.215f + b * (2.532f + b * (-10.73f + b * (5.574f + b * 0.245f))));
    const Rgb logarithm = glm::log(glm::max(non_negative(colour), Rgb(1e-20f))) / fit;
    return logarithm * logarithm;
}

Rgb absorption_of_melanin(float melanin, float redness) {
    const float concentration = -std::log(std::max(1.0f - melanin, 1e-4f));
    return concentration * ((1.0f - redness) * Rgb(0.506f, 0.841f, 1.653f) + redness * Rgb(0.343f, 0.733f, 1.924f));
}

float variance_along(float roughness) {
    const float b = clamped(roughness, least_roughness, 1.0f);
    const float deviation = 0.726f * b + 0.812f * b * b + 3.7f * power(b, 20);
    return deviation * deviation;
}

float scale_around(float roughness) {
    const float b = clamped(roughness, least_roughness, 1.0f);
    const float root_pi_8 = std::sqrt(std::numbers::pi_v<float> / 8.0f);
    return root_pi_8 * (0.265f * b + 1.194f * b * b + 5.372f * power(b, 22));
}

Shares shares(float sine_theta, float cosine_theta, float gamma, const Rgb& absorption, float ior) {
    const float across = std::sin(gamma), sine_inside = sine_theta / ior;
    const float cosine_inside = std::max(root(1.0f - sine_inside * sine_inside), 1e-4f);
    const float of_slant = std::max(root(ior * ior - sine_theta * sine_theta), 1e-4f); // ior across, as it seems there
    const float sine_refracted = std::clamp(across * cosine_theta / of_slant, -1.0f, 1.0f);
    const float chord = 2.0f * root(1.0f - sine_refracted * sine_refracted) / cosine_inside;
    const Rgb passing = glm::exp(-absorption * chord);
    const float mirrored = fresnel_of_any_index(cosine_theta * std::cos(gamma), ior);
    const Rgb through = (1.0f - mirrored) * (1.0f - mirrored) * passing, inside = through * passing * mirrored;
    return {.mirrored = Rgb(mirrored),
            .through = through,
            .mirrored_inside = inside,
            .further = inside * (passing * mirrored) / glm::max(1.0f - passing * mirrored, Rgb(1e-6f)),
            .refracted = std::asin(sine_refracted)};
}
namespace {
/// A point without a direction along it, as on a sphere, has any.
vec3 unit_tangent(const vec3& tangent, const vec3& normal) { return unit_or(tangent, orthonormal_basis(normal).first); }

/// One lobe, or where there is no list, as if it were Lambert's.
void add(Lobe lobe, SurfaceClosures& closures, Lobes* lobes) {
    lobe.sampling = average(lobe.weight);
    if (!(largest(lobe.weight) > least_share))
        return;
    if (lobes == nullptr)
        closures.diffuse_albedo += lobe.weight;
    else
        lobes->push_back(lobe);
}

Rgb absorption(LobeModel model, const LobeInputs& inputs, const Rgb& tint, float of_hair, float radial_roughness) {
    if (model == LobeModel::HairOfAbsorption)
        return non_negative(inputs[1]);
    const Rgb of_colour = absorption_of_colour(tint * non_negative(inputs[1]), radial_roughness);
    if (model == LobeModel::HairOfColour)
        return of_colour;
    const float differing = 1.0f + 2.0f * (of_hair - 0.5f) * clamped(inputs[10].x, 0.0f, 1.0f);
    return non_negative(of_colour + absorption_of_melanin(inputs[2].x * differing, inputs[3].x));
}

void add_principled(const LobeSource& source, const LobeInputs& inputs, const Rgb& weight, const vec3& along,
                    const vec3& normal, const vec3& outgoing, const Rgb& tint, SurfaceClosures& closures,
                    Lobes* lobes) {
    const float of_hair = inputs[9].x;
    const float differing = 1.0f + 2.0f * (of_hair - 0.5f) * clamped(inputs[11].x, 0.0f, 1.0f);
    const float roughness = clamped(inputs[4].x * differing, least_roughness, 1.0f), radial = inputs[5].x * differing,
                coat = 1.0f - clamped(inputs[6].x, 0.0f, 1.0f);
    const fibre::Frame frame(along, outgoing);
    const float sine = std::clamp(glm::dot(outgoing, along), -1.0f, 1.0f), cosine = root(1.0f - sine * sine);
    const float gamma = std::asin(std::clamp(glm::dot(normal, frame.across), -1.0f, 1.0f));
    const Shares of = shares(sine, cosine, gamma, absorption(source.model, inputs, tint, of_hair, radial),
                             std::max(inputs[7].x, 1e-3f));
    const float variance = variance_along(roughness), scale = scale_around(radial);
    const float offset = std::isfinite(inputs[8].x) ? inputs[8].x : 0.0f;
    const auto add_lobe = [&](const Rgb& share, float along_variance, float around_scale, float tilt, float turns) {
        const float phi = 2.0f * gamma + turns * (pi - 2.0f * of.refracted);
        add({.kind = Lobe::Kind::Fibre,
             .is_separable = !source.preserves_energy,
             .alpha = along_variance,
             .ior = around_scale,
             .weight = weight * share,
             .a = {std::sin(tilt), std::cos(tilt), phi},
             .b = fibre::inverse_integrals(along_variance, around_scale),
             .normal = along},
            closures, lobes);
    };
    add_lobe(of.mirrored, variance_along(coat * roughness), scale, 2.0f * offset, 0.0f);
    add_lobe(of.through, 0.25f * variance, scale, -offset, 1.0f);
    add_lobe(of.mirrored_inside, 4.0f * variance, scale, -4.0f * offset, 2.0f);
    add_lobe(of.further, 4.0f * variance, 0.0f, 0.0f, 0.0f);
}
} // namespace
} // namespace hair

std::size_t hair_input_count(LobeModel model) {
    switch (model) {
    case LobeModel::HairOfColour:
    case LobeModel::HairOfMelanin:
    case LobeModel::HairOfAbsorption:
        return hair::principled_inputs;
    case LobeModel::HairReflection:
    case LobeModel::HairTransmission:
        return hair::hair_bsdf_inputs;
    default:
        return 0;
    }
}

void add_hair_lobes(const LobeSource& source, const LobeInputs& inputs, const ShadingPoint& point, const vec3& outgoing,
                    SurfaceClosures& closures, Lobes* lobes) {
    const Rgb weight = hair::non_negative(inputs[0]);
    if (hair::largest(weight) <= hair::least_share)
        return;
    const vec3 normal = point.is_backface ? -point.geometric_normal : point.geometric_normal;
    if (hair_input_count(source.model) == hair::principled_inputs) {
        hair::add_principled(source, inputs, weight,
                             hair::unit_tangent(point.is_backface ? -inputs[12] : inputs[12], normal), normal, outgoing,
                             point.tint, closures, lobes);
        return;
    }
    hair::add({.kind = source.model == LobeModel::HairReflection ? Lobe::Kind::FibreReflection
                                                                 : Lobe::Kind::FibreTransmission,
               .alpha = hair::clamped(inputs[3].x, hair::least_roughness, 1.0f),
               .ior = hair::clamped(inputs[4].x, hair::least_roughness, 1.0f),
               .weight = weight * (point.tint * hair::non_negative(inputs[1])),
               .a = {std::isfinite(inputs[2].x) ? inputs[2].x : 0.0f, 0.0f, 0.0f},
               .normal = hair::unit_tangent(inputs[5], normal)},
              closures, lobes);
}
} // namespace tyndall
