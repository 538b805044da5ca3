// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/ggx_energy.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/lobes/ggx.hpp"
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <vector>

namespace tyndall::ggx {
namespace {
constexpr std::size_t fine = 32, coarse = 16;
/// Mean over the facets that are seen, by `count` points of the disc, each at a radius of its own: no edge of what is
/// mirrored falls between two rings. They lie close at the rim, where the few facets are that lean far. `of`: the facet's
/// normal, and the cosine that it is seen at.
template <std::size_t size, typename Of>
std::array<float, size> mean_over_visible(float alpha, const vec3& outgoing, std::size_t count, const Of& of) {
    constexpr double golden_turn = 2.39996322972865332; // radians
    std::array<double, size> sums{};
    for (std::size_t point = 0; point < count; ++point) {
        const float u = (static_cast<float>(point) + 0.5f) / static_cast<float>(count);
        const float radius = std::sqrt(1.0f - u * u * u), weight = 3.0f * u * u;
        const auto around =
            static_cast<float>(std::fmod(golden_turn * static_cast<double>(point), 2.0 * std::numbers::pi));
        const vec3 normal = visible_normal(outgoing, vec2(alpha), radius * vec2(std::cos(around), std::sin(around)));
        const std::array<float, size> values = of(normal, glm::dot(outgoing, normal));
        for (std::size_t i = 0; i < size; ++i)
            sums[i] += weight * values[i];
    }
    std::array<float, size> means;
    for (std::size_t i = 0; i < size; ++i)
        means[i] = static_cast<float>(sums[i] / static_cast<double>(count));
    return means;
}
/// Light that arrives at this cosine, of either side, is hidden by no other facet: of those that are seen.
float unshadowed(float alpha, float cosine, float incoming_cosine) {
    return masking_and_shadowing(alpha, cosine, incoming_cosine, false) / masking(alpha, cosine);
}
float alpha_of(float roughness) { return std::max(1e-4f, roughness * roughness); }
vec3 at_cosine(float cosine) { return {std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)), 0.0f, cosine}; }
float least(float cosine) { return std::max(cosine, 1e-3f); }

/// What white facets mirror, and that times `rise`.
template <typename Rise>
std::array<float, 2> mirrored(float roughness, float cosine, std::size_t count, const Rise& rise) {
    const float alpha = alpha_of(roughness);
    const vec3 outgoing = at_cosine(least(cosine));
    return mean_over_visible<2>(alpha, outgoing, count, [&](const vec3& normal, float on_facet) {
        const float incoming_cosine = 2.0f * on_facet * normal.z - outgoing.z;
        const float share = incoming_cosine > 0.0f ? unshadowed(alpha, outgoing.z, incoming_cosine) : 0.0f;
        return std::array{share, share * rise(on_facet)};
    });
}
/// What facets of glass mirror and let pass, to the other side, once.
float mirrored_or_bent(float roughness, float cosine, float ior, std::size_t count) {
    const float alpha = alpha_of(roughness);
    const vec3 outgoing = at_cosine(least(cosine));
    return mean_over_visible<1>(alpha, outgoing, count, [&](const vec3& normal, float on_facet) {
        const float share = fresnel_of_any_index(on_facet, ior);
        const float mirrored_cosine = 2.0f * on_facet * normal.z - outgoing.z;
        float sum = mirrored_cosine > 0.0f ? share * unshadowed(alpha, outgoing.z, mirrored_cosine) : 0.0f;
        if (share < 1.0f) {
            const float inner = std::sqrt(std::max(0.0f, 1.0f - (1.0f - on_facet * on_facet) / (ior * ior)));
            const float bent_cosine = (outgoing.z - on_facet * normal.z) / ior + inner * normal.z; // below the surface
            if (bent_cosine > 0.0f)
                sum += (1.0f - share) * unshadowed(alpha, outgoing.z, bent_cosine);
        }
        return std::array{sum};
    })[0];
}
float step(std::size_t index, std::size_t count) { return static_cast<float>(index) / static_cast<float>(count - 1); }
struct Between {
    std::size_t before, after;
    float share;
};
Between between(float x, std::size_t count) {
    const float at = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(count - 1);
    const auto before = std::min(static_cast<std::size_t>(at), count - 1);
    return {before, std::min(before + 1, count - 1), at - static_cast<float>(before)};
}

float line(const float* values, std::size_t count, float x) {
    const Between at = between(x, count);
    return values[at.before] + (values[at.after] - values[at.before]) * at.share;
}
/// Of one such line for each y.
float plane(const float* values, std::size_t count, float x, float y) {
    const Between at = between(y, count);
    const float before = line(values + at.before * count, count, x);
    return before + (line(values + at.after * count, count, x) - before) * at.share;
}
/// Of one such plane for each z.
float cube(const float* values, std::size_t count, float x, float y, float z) {
    const Between at = between(z, count);
    const float before = plane(values + at.before * count * count, count, x, y);
    return before + (plane(values + at.after * count * count, count, x, y) - before) * at.share;
}
/// All indices above 1, most of them next to 1, and back.
float place_of(float ior) { return std::sqrt(std::abs((ior - 1.0f) / (ior + 1.0f))); }
float ior_at(std::size_t index) {
    const float root = std::min(step(index, coarse) * step(index, coarse), 0.999f);
    return (1.0f + root) / (1.0f - root);
}
/// Of what is known at evenly spaced cosines, by the cosine.
template <typename At>
float mean_over_cosines(std::size_t count, const At& at) {
    double sum = 0.0, weights = 0.0;
    for (std::size_t cosine = 0; cosine < count; ++cosine) {
        const double weight = step(cosine, count) * (cosine + 1 == count ? 0.5 : 1.0);
        sum += weight * at(cosine);
        weights += weight;
    }
    return static_cast<float>(sum / weights);
}

struct Tables {
    std::vector<float> albedo = std::vector<float>(fine * fine); ///< Row: cosine, column: roughness.
    std::vector<float> mean = std::vector<float>(fine);
    std::vector<float> rise = std::vector<float>(coarse * coarse * coarse); ///< By index, cosine, roughness.

    Tables() {
        const auto none = [](float) { return 0.0f; };
        for (std::size_t roughness = 0; roughness < fine; ++roughness) {
            const auto at = [&](std::size_t cosine) -> float& { return albedo[cosine * fine + roughness]; };
            for (std::size_t cosine = 0; cosine < fine; ++cosine)
                at(cosine) = mirrored(step(roughness, fine), step(cosine, fine), 576, none)[0];
            mean[roughness] = mean_over_cosines(fine, at);
        }
        for (std::size_t index = 0; index < coarse; ++index)
            for (std::size_t cosine = 0; cosine < coarse; ++cosine)
                for (std::size_t roughness = 0; roughness < coarse; ++roughness) {
                    const auto [all, risen] =
                        mirrored(step(roughness, coarse), step(cosine, coarse), 256,
                                 [&](float on_facet) { return fresnel_rise_of_any_index(on_facet, ior_at(index)); });
                    rise[(index * coarse + cosine) * coarse + roughness] = all > 0.0f ? risen / all : 0.0f;
                }
    }
};
/// Of glass of one index, which scenes have few of: each is made when it is asked for.
struct GlassTables {
    std::array<float, coarse * coarse> albedo; ///< By cosine, roughness.
    std::array<float, coarse> mean;            ///< By roughness.

    void make(float ior) {
        for (std::size_t roughness = 0; roughness < coarse; ++roughness) {
            const auto at = [&](std::size_t cosine) -> float& { return albedo[cosine * coarse + roughness]; };
            for (std::size_t cosine = 0; cosine < coarse; ++cosine)
                at(cosine) = mirrored_or_bent(step(roughness, coarse), step(cosine, coarse), ior, 512);
            mean[roughness] = mean_over_cosines(coarse, at);
        }
    }
    [[nodiscard]] Albedo read(float roughness, float cosine) const {
        return {.seen = plane(albedo.data(), coarse, roughness, cosine), .mean = line(mean.data(), coarse, roughness)};
    }
};
const GlassTables& glass_tables(std::size_t index, bool is_within) {
    static std::array<std::array<GlassTables, coarse>, 2> tables;
    static std::array<std::array<std::once_flag, coarse>, 2> made;
    GlassTables& found = tables[is_within][index];
    std::call_once(made[is_within][index], [&] { found.make(is_within ? 1.0f / ior_at(index) : ior_at(index)); });
    return found;
}
const Tables& tables() {
    static const Tables made;
    return made;
}
} // namespace

Albedo albedo(float roughness, float cosine) {
    const Tables& known = tables();
    return {.seen = plane(known.albedo.data(), fine, roughness, cosine),
            .mean = line(known.mean.data(), fine, roughness)};
}
Albedo glass_albedo(float roughness, float cosine, float ior) {
    const Between at = between(place_of(ior), coarse);
    const auto known = [&](std::size_t index) { return glass_tables(index, ior < 1.0f).read(roughness, cosine); };
    const Albedo before = known(at.before), after = known(at.after);
    return {.seen = before.seen + (after.seen - before.seen) * at.share,
            .mean = before.mean + (after.mean - before.mean) * at.share};
}
float mean_rise(float roughness, float cosine, float ior) {
    return cube(tables().rise.data(), coarse, roughness, cosine, place_of(ior));
}
} // namespace tyndall::ggx
