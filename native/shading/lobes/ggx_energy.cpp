// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/ggx_energy.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/lobes/ggx.hpp"
#include <array>
#include <vector>

namespace tyndall::ggx {
namespace {
constexpr std::size_t fine = 32, coarse = 16;
/// Means over directions that visible facets mirror light to, by strata of the disc: those at its rim, where the few
/// facets are that lean far, are narrow.
template <typename Rise>
std::array<float, 2> means(float roughness, float cosine, std::size_t side, const Rise& rise) {
    const float alpha = std::max(1e-4f, roughness * roughness);
    cosine = std::max(cosine, 1e-3f);
    const vec3 outgoing(std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)), 0.0f, cosine);
    double albedo = 0.0, risen = 0.0;
    for (std::size_t y = 0; y < side; ++y)
        for (std::size_t x = 0; x < side; ++x) {
            const vec2 u = (vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f) / static_cast<float>(side);
            const float radius = std::sqrt(1.0f - u.x * u.x * u.x), around = 2.0f * std::numbers::pi_v<float> * u.y;
            const float weight = 3.0f * u.x * u.x;
            const vec3 normal =
                visible_normal(outgoing, vec2(alpha), radius * vec2(std::cos(around), std::sin(around)));
            const float on_facet = glm::dot(outgoing, normal);
            const vec3 incoming = 2.0f * on_facet * normal - outgoing;
            if (incoming.z <= 0.0f)
                continue;
            const float share =
                weight * masking_and_shadowing(alpha, cosine, incoming.z, false) / masking(alpha, cosine);
            albedo += share;
            risen += share * rise(on_facet);
        }
    const double count = static_cast<double>(side * side);
    return {static_cast<float>(albedo / count), static_cast<float>(albedo > 0.0 ? risen / albedo : 0.0)};
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

struct Tables {
    std::vector<float> albedo = std::vector<float>(fine * fine); ///< Row: cosine, column: roughness.
    std::vector<float> mean = std::vector<float>(fine);
    std::vector<float> rise = std::vector<float>(coarse * coarse * coarse); ///< By index, cosine, roughness.

    Tables() {
        const auto none = [](float) { return 0.0f; };
        for (std::size_t roughness = 0; roughness < fine; ++roughness) {
            double sum = 0.0, weights = 0.0;
            for (std::size_t cosine = 0; cosine < fine; ++cosine) {
                const float value = means(step(roughness, fine), step(cosine, fine), 24, none)[0];
                albedo[cosine * fine + roughness] = value;
                const double weight = step(cosine, fine) * (cosine + 1 == fine ? 0.5 : 1.0);
                sum += weight * value;
                weights += weight;
            }
            mean[roughness] = static_cast<float>(sum / weights);
        }
        for (std::size_t index = 0; index < coarse; ++index) {
            const float root = std::min(step(index, coarse) * step(index, coarse), 0.999f);
            const float ior = (1.0f + root) / (1.0f - root);
            for (std::size_t cosine = 0; cosine < coarse; ++cosine)
                for (std::size_t roughness = 0; roughness < coarse; ++roughness)
                    rise[(index * coarse + cosine) * coarse + roughness] =
                        means(step(roughness, coarse), step(cosine, coarse), 16,
                              [&](float on_facet) { return fresnel_rise_of_any_index(on_facet, ior); })[1];
        }
    }
    [[nodiscard]] float plane(const float* values, std::size_t count, float x, float y) const {
        const Between across = between(x, count), up = between(y, count);
        const auto row = [&](std::size_t index) {
            const float* const first = values + index * count;
            return first[across.before] + (first[across.after] - first[across.before]) * across.share;
        };
        const float before = row(up.before);
        return before + (row(up.after) - before) * up.share;
    }
};
const Tables& tables() {
    static const Tables made;
    return made;
}
} // namespace

float albedo(float roughness, float cosine) {
    const Tables& known = tables();
    return known.plane(known.albedo.data(), fine, roughness, cosine);
}
float mean_albedo(float roughness) {
    const Between at = between(roughness, fine);
    const std::vector<float>& mean = tables().mean;
    return mean[at.before] + (mean[at.after] - mean[at.before]) * at.share;
}
float mean_rise(float roughness, float cosine, float ior) {
    const Tables& known = tables();
    const Between at = between(std::sqrt(std::abs((ior - 1.0f) / (ior + 1.0f))), coarse);
    const auto plane = [&](std::size_t index) {
        return known.plane(known.rise.data() + index * coarse * coarse, coarse, roughness, cosine);
    };
    const float before = plane(at.before);
    return before + (plane(at.after) - before) * at.share;
}
} // namespace tyndall::ggx
