// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_surroundings.hpp"
#include "core/sampling.hpp"
#include "shading/pixel_steps.hpp"
#include "shading/surroundings.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tyndall {
namespace {
// Of random pairs: far from what the renderer asks of the same pixel.
constexpr std::uint32_t of_occlusion = 0x6f63636cu, of_bevel = 0x62657665u;

/// How a probe that goes through a disc around the point weighs surfaces, by their distance as a share of the radius: the
/// cube of what is left of it. What the disc's area turns that into has the cumulative distribution
/// 10 s^2 - 20 s^3 + 15 s^4 - 4 s^5.
float falloff(float share) {
    const float left = std::max(1.0f - share, 0.0f);
    return left * left * left;
}

/// The share of the radius at which that distribution is u, by Newton's steps kept within a bracket: near both ends it is
/// flat, and plain steps leave [0, 1].
float sample_falloff(float u) {
    float low = 0.0f, high = 1.0f, share = 0.25f;
    for (int step = 0; step < 24; ++step) {
        const float squared = share * share;
        const float excess = squared * (10.0f + share * (-20.0f + share * (15.0f - 4.0f * share))) - u;
        if (std::abs(excess) < 1e-6f)
            break;
        (excess > 0.0f ? high : low) = share;
        const float next = share - excess / (20.0f * share * falloff(share));
        share = next > low && next < high ? next : 0.5f * (low + high);
    }
    return share;
}

/// What few probes say together is no mean of what each says: how their places hang together shows in the mean of all
/// samples, so that each deals them out anew. From 16 on that is less than 0.002, and all samples' probes are spread as one
/// set, which has half of the noise.
vec2 bevel_pair(const Surroundings& surroundings, std::uint32_t index, std::uint32_t count) {
    constexpr std::uint32_t many = 16;
    return count < many ? surroundings.own_pair(index, of_bevel) : surroundings.pair(index, count, of_bevel);
}

/// A line through a disc, which is around the point and at right angles to one of three axes.
struct Probe {
    std::array<vec3, 3> axes;   ///< The disc's own first.
    std::array<float, 3> picks; ///< How often each is the disc's.
    vec3 origin;                ///< From the point.
    float half_length_m;
    float share; ///< Of the radius, at which it goes through the disc.
};

Probe probe_of(const std::array<vec3, 3>& frame, vec2 u, float radius_m) {
    Probe probe{.axes = frame, .picks = {0.5f, 0.25f, 0.25f}, .origin = {}, .half_length_m = 0.0f, .share = 0.0f};
    if (u.x < 0.5f) {
        u.x *= 2.0f;
    } else {
        const std::size_t axis = u.x < 0.75f ? 1 : 2;
        std::swap(probe.axes[0], probe.axes[axis]);
        std::swap(probe.picks[0], probe.picks[axis]);
        u.x = axis == 1 ? 4.0f * u.x - 2.0f : 4.0f * u.x - 3.0f;
    }
    const float angle = 2.0f * std::numbers::pi_v<float> * u.x;
    probe.share = sample_falloff(u.y);
    probe.half_length_m = radius_m * std::sqrt(std::max(1.0f - probe.share * probe.share, 0.0f));
    probe.origin = probe.half_length_m * probe.axes[0] +
                   radius_m * probe.share * (std::cos(angle) * probe.axes[1] + std::sin(angle) * probe.axes[2]);
    return probe;
}

/// Of a surface that the probe meets: how the falloff there differs from that on the disc, by the power heuristic among the
/// probes along the three axes that might have met it.
float weight_of(const Probe& probe, const OwnSurface& surface, const vec3& point, float radius_m) {
    std::array<float, 3> densities;
    float squares = 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        densities[axis] = probe.picks[axis] * std::abs(glm::dot(probe.axes[axis], surface.geometric_normal));
        squares += densities[axis] * densities[axis];
    }
    const float on_disc = falloff(probe.share);
    if (!(squares > 0.0f) || !(on_disc > 0.0f))
        return 0.0f;
    return densities[0] / squares * falloff(glm::length(surface.position - point) / radius_m) / on_disc;
}
} // namespace

float open_share(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const float reach_m = in.a.x;
    if (point.surroundings == nullptr || !(reach_m > 0.0f))
        return 1.0f;
    const float length = glm::length(in.b);
    if (!(length > 0.0f && std::isfinite(length)))
        return 1.0f; // as in Cycles, whose rays then go nowhere
    const vec3 normal = ((op.option & OcclusionOptions::inside) != 0 ? -in.b : in.b) / length;
    const std::uint32_t count = op.selector;
    const auto among =
        (op.option & OcclusionOptions::only_local) != 0 ? Surroundings::Among::OwnObject : Surroundings::Among::All;
    constexpr std::uint32_t most = 16; // at a time
    std::array<vec3, most> directions;
    std::size_t open = 0;
    for (std::uint32_t first = 0; first < count; first += most) {
        const std::uint32_t these = std::min(most, count - first);
        for (std::uint32_t i = 0; i < these; ++i)
            directions[i] =
                from_frame(normal, sample_cosine_hemisphere(point.surroundings->pair(first + i, count, of_occlusion)));
        open += point.surroundings->open_count(std::span(directions).first(these), reach_m, among);
    }
    return static_cast<float>(open) / static_cast<float>(count);
}

vec3 rounded_normal(const SurfaceOp& op, const ProgramPoint& point, const Operands& in) {
    const ShadingPoint& surface = point.surface;
    constexpr float largest_m = 1e9f; // beyond it, what lies at its end is no place any more
    const float radius_m = std::min(in.a.x, largest_m);
    // Rays that gather light are blurred enough without it, as in Cycles.
    if (point.surroundings == nullptr || !(radius_m > 0.0f) || point.ray_kind == RayKind::Diffuse)
        return in.b;
    // Few probes depend on how the discs are turned, for what is normalized is no mean of means.
    const vec3 outwards = true_normal(point);
    const auto [tangent, bitangent] = axes_across(outwards);
    const std::array<vec3, 3> frame{outwards, tangent, bitangent};
    thread_local std::vector<OwnSurface> met;
    dvec3 sum(0.0); // so that as a float it does not tell in which order surfaces were met
    for (std::uint32_t index = 0; index < op.selector; ++index) {
        const Probe probe = probe_of(frame, bevel_pair(*point.surroundings, index, op.selector), radius_m);
        met.clear();
        point.surroundings->meet_own(surface.position + probe.origin, -probe.axes[0], 2.0f * probe.half_length_m, met);
        for (const OwnSurface& of : met)
            sum += dvec3(weight_of(probe, of, surface.position, radius_m) * of.shading_normal);
    }
    const vec3& own = surface.shading_normal;
    vec3 rounded = unit_or(vec3(sum), vec3(0.0f));
    if (rounded == vec3(0.0f))
        rounded = own; // nothing was met
    else if (surface.is_backface)
        rounded = -rounded;
    return in.b == own ? rounded : unit_or(in.b + (rounded - own), own);
}

bool asks_for_others(const Material& material) {
    return std::ranges::any_of(material.program, [](const SurfaceOp& op) {
        return op.code == SurfaceOp::Code::AmbientOcclusion && (op.option & OcclusionOptions::only_local) == 0;
    });
}
} // namespace tyndall
