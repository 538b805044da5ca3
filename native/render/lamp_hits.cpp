// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/lamp_hits.hpp"
#include "core/sampling.hpp"
#include <limits>
#include <numbers>

namespace tyndall::render {
static constexpr float pi = std::numbers::pi_v<float>;
using Kind = LightAim::Form::Kind;

static LampHit sun_hit(const LightAim::Form& form, const vec3& direction) {
    constexpr float far_m = std::numeric_limits<float>::infinity();
    const vec3 apart = direction - form.towards_light;
    const float one_minus_cosine = 0.5f * glm::dot(apart, apart); // 1 - cos of a small angle, with all digits
    if (form.cone <= 0.0f || one_minus_cosine >= 1.0f)
        return {};
    if (form.kind == Kind::SunCone) {
        if (one_minus_cosine > form.cone)
            return {};
        const float pdf = uniform_cone_pdf_per_sr(form.cone);
        return {far_m, pdf, form.weight * pdf};
    }
    const float cosine = 1.0f - one_minus_cosine, sine2 = one_minus_cosine * (2.0f - one_minus_cosine);
    if (sine2 > form.cone * form.cone * cosine * cosine)
        return {};
    const float pdf = 1.0f / (pi * form.cone * form.cone * cosine * cosine * cosine);
    return {far_m, pdf, form.weight * pdf};
}

LampHit lamp_hit(const LightAim::Form& form, const vec3& position, const vec3& direction) {
    if (form.kind == Kind::SunCone || form.kind == Kind::SunDisc)
        return sun_hit(form, direction);
    if (form.kind == Kind::Area)
        return {};
    const vec3 way = form.position - position;
    const float distance2 = glm::dot(way, way), radius2 = form.radius_m * form.radius_m;
    if (!(radius2 > 0.0f) || distance2 <= 0.0f)
        return {};
    const float along_m = glm::dot(way, direction), distance_m = std::sqrt(distance2);
    const vec3 beside = way - along_m * direction; // from the ray's nearest point to the centre
    if (along_m <= 0.0f)
        return {};
    if (form.kind == Kind::Sphere) {
        const float miss2 = glm::dot(beside, beside);
        if (distance_m <= form.radius_m || miss2 > radius2)
            return {};
        const float sine2 = radius2 / distance2, cone = sine2 / (1.0f + std::sqrt(1.0f - sine2));
        return {along_m - std::sqrt(radius2 - miss2), uniform_cone_pdf_per_sr(cone), 1.0f / (pi * radius2)};
    }
    const float cosine = along_m / distance_m; // against the disc that faces the point
    const float far_m = distance_m / cosine;
    const vec3 on_disc = far_m * direction - way;
    if (glm::dot(on_disc, on_disc) > radius2)
        return {};
    return {far_m, far_m * far_m / (pi * radius2 * cosine), 1.0f / (pi * radius2)};
}

/// Of directions that lobes draw: nothing is denser, roughly.
static float most_pdf_per_sr(const LobeSet& set) {
    float sum = 0.0f, all = 0.0f;
    for (const Lobe& lobe : set.lobes) {
        if (lobe.sampling <= 0.0f)
            continue;
        if (lobe.kind != Lobe::Kind::Ggx)
            return std::numeric_limits<float>::infinity();
        const vec3& normal = lobe.has_own_normal() ? lobe.normal : set.normal;
        const float cosine = std::max(glm::dot(normal, set.outgoing), 0.0f), alpha2 = lobe.alpha * lobe.alpha;
        // Where the facet is the surface's own: ggx::reflected_pdf_per_sr, without the quotient of two zeros.
        const float seen = 0.5f / (cosine + std::sqrt(cosine * cosine + alpha2 * (1.0f - cosine * cosine)));
        sum += lobe.sampling * seen / (pi * alpha2);
        all += lobe.sampling;
    }
    return all > 0.0f ? sum / all : 0.0f;
}

bool lobes_may_find(const LightAim::Form& form, const vec3& position, const LobeSet& lobes) {
    constexpr float hardly = 0.1f; // a hundredth of the power heuristic's weight
    float least_pdf = 0.0f;        // of aimed rays
    if (form.kind == Kind::Area)
        return false;
    if (form.kind == Kind::SunCone)
        least_pdf = form.cone > 0.0f ? uniform_cone_pdf_per_sr(form.cone) : 0.0f;
    else if (form.kind == Kind::SunDisc)
        least_pdf = form.cone > 0.0f ? 1.0f / (pi * form.cone * form.cone) : 0.0f;
    else {
        const vec3 way = form.position - position;
        const float distance2 = glm::dot(way, way), radius2 = form.radius_m * form.radius_m;
        if (distance2 <= radius2)
            return true;
        if (radius2 > 0.0f)
            least_pdf = (distance2 - radius2) / (pi * radius2);
    }
    return !(most_pdf_per_sr(lobes) <= hardly * least_pdf);
}
} // namespace tyndall::render
