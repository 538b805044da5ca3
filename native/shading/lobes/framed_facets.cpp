// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/framed_facets.hpp"
#include "shading/lobes/ashikhmin_shirley.hpp"
#include "shading/lobes/beckmann.hpp"
#include "shading/lobes/ggx.hpp"
#include <tuple>

namespace tyndall::framed_facets {
namespace {
/// Axes of the facets: along the tangent, across it, and the normal.
struct FacetFrame {
    vec3 along, across, normal;
    vec2 alpha;

    FacetFrame(const Lobe& lobe, const vec3& axis) : normal(axis) {
        if (lobe.is_anisotropic()) {
            const float ratio = glm::length(lobe.tangent);
            along = lobe.tangent / ratio;
            across = glm::cross(axis, along);
            alpha = lobe.alpha * vec2(ratio, 1.0f / ratio);
        } else {
            std::tie(along, across) = orthonormal_basis(axis);
            alpha = vec2(lobe.alpha);
        }
    }
    [[nodiscard]] vec3 local(const vec3& v) const {
        return {glm::dot(v, along), glm::dot(v, across), glm::dot(v, normal)};
    }
    [[nodiscard]] vec3 in_scene(const vec3& v) const { return v.x * along + v.y * across + v.z * normal; }
    /// Lambda of a direction that is given along the axes.
    [[nodiscard]] float lambda(Lobe::Kind kind, const vec3& direction) const {
        const vec2 wide = alpha * vec2(direction);
        const float slope2 = glm::dot(wide, wide) / (direction.z * direction.z);
        return kind == Lobe::Kind::Beckmann ? beckmann::lambda(slope2) : 0.5f * (std::sqrt(1.0f + slope2) - 1.0f);
    }
    [[nodiscard]] float distribution(Lobe::Kind kind, const vec3& half) const {
        const vec2 narrow = vec2(half) / alpha;
        const float stretched2 = glm::dot(narrow, narrow), cosine2 = half.z * half.z, alpha2 = alpha.x * alpha.y;
        if (kind == Lobe::Kind::Beckmann)
            return beckmann::distribution(alpha2, stretched2, cosine2);
        const float spread = stretched2 + cosine2;
        return 1.0f / (pi * alpha2 * spread * spread);
    }
};
constexpr float least_cosine = 1e-6f;
} // namespace

float per_irradiance(const Lobe& lobe, const vec3& normal, const vec3& outgoing, const vec3& incoming) {
    const FacetFrame frame(lobe, normal);
    const vec3 view = frame.local(outgoing), light = frame.local(incoming),
               half = frame.local(glm::normalize(outgoing + incoming));
    const float view_cosine = std::max(view.z, least_cosine), light_cosine = std::max(light.z, least_cosine);
    if (lobe.kind == Lobe::Kind::AshikhminShirley) {
        const float on_facet = std::max(glm::dot(half, view), least_cosine);
        return ashikhmin_shirley::density_per_sr(ashikhmin_shirley::exponents(frame.alpha), half) /
               (4.0f * on_facet * std::max(view_cosine, light_cosine));
    }
    const float masking = frame.lambda(lobe.kind, vec3(vec2(view), view_cosine)),
                shadowing = frame.lambda(lobe.kind, vec3(vec2(light), light_cosine));
    const float hidden = lobe.is_separable ? (1.0f + masking) * (1.0f + shadowing) : 1.0f + masking + shadowing;
    return frame.distribution(lobe.kind, half) / (4.0f * view_cosine * light_cosine * hidden);
}

float pdf_per_sr(const Lobe& lobe, const vec3& normal, const vec3& outgoing, const vec3& incoming) {
    const vec3 sum = outgoing + incoming;
    const float length2 = glm::dot(sum, sum);
    if (length2 <= 0.0f)
        return 0.0f;
    const FacetFrame frame(lobe, normal);
    const vec3 view = frame.local(outgoing), half = frame.local(sum / std::sqrt(length2));
    if (view.z <= 0.0f || half.z <= 0.0f)
        return 0.0f;
    if (lobe.kind == Lobe::Kind::AshikhminShirley)
        return ashikhmin_shirley::density_per_sr(ashikhmin_shirley::exponents(frame.alpha), half) /
               (4.0f * std::max(glm::dot(half, view), least_cosine));
    return frame.distribution(lobe.kind, half) / (4.0f * view.z * (1.0f + frame.lambda(lobe.kind, view)));
}

vec3 sample_normal(const Lobe& lobe, const vec3& normal, const vec3& outgoing, vec2 u) {
    const FacetFrame frame(lobe, normal);
    if (lobe.kind == Lobe::Kind::AshikhminShirley)
        return frame.in_scene(ashikhmin_shirley::sample_half(ashikhmin_shirley::exponents(frame.alpha), u));
    const vec3 view = frame.local(outgoing);
    return frame.in_scene(lobe.kind == Lobe::Kind::Beckmann ? beckmann::sample_visible_normal(view, frame.alpha, u)
                                                            : ggx::sample_visible_normal(view, frame.alpha, u));
}

float most_pdf_per_sr(const Lobe& lobe, const vec3& normal, const vec3& outgoing) {
    const FacetFrame frame(lobe, normal);
    vec3 view = frame.local(outgoing);
    const float widest = std::max(frame.alpha.x, frame.alpha.y);
    // Where the facet is the surface's own.
    if (lobe.kind == Lobe::Kind::AshikhminShirley)
        return ashikhmin_shirley::density_per_sr(ashikhmin_shirley::exponents(frame.alpha), {0, 0, 1}) /
               (4.0f * std::max(view.z, widest));
    view.z = std::max(view.z, 1e-4f);
    // Beckmann's of a width above the root of 1/2 are densest on facets that lean: of 1 by half.
    const float leaning = lobe.kind == Lobe::Kind::Beckmann && widest * widest > 0.5f ? 1.5f : 1.0f;
    return leaning * frame.distribution(lobe.kind, {0, 0, 1}) /
           (4.0f * view.z * (1.0f + frame.lambda(lobe.kind, view)));
}
} // namespace tyndall::framed_facets
