// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/lamp_hits.hpp"
#include "core/sampling.hpp"
#include "scene/area_light.hpp"
#include "shading/lobes/diffuse_lobes.hpp"
#include "shading/lobes/fibre.hpp"
#include "shading/lobes/framed_facets.hpp"
#include "shading/lobes/sheen.hpp"
#include <cmath>
#include <limits>

namespace tyndall::render {
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

/// The densities are those of light_aim_area-inl.hpp: even over the directions of what is seen of the light's box, or from
/// afar over the places of that, or of a whole ellipse.
static LampHit area_hit(const LightAim::Form& form, const vec3& position, const vec3& direction) {
    const dvec3 way(position - form.position);
    const double height = -glm::dot(way, dvec3(form.area_axes[2]));
    const double cosine = glm::dot(dvec3(direction), dvec3(form.area_axes[2]));
    if (!(height > 0.0) || !(cosine > 0.0))
        return {};
    const double far_m = height / cosine;
    const auto in_plane = [&](const dvec3& v) {
        return dvec2(glm::dot(v, dvec3(form.area_axes[0])), glm::dot(v, dvec3(form.area_axes[1])));
    };
    const dvec2 foot = in_plane(way), beside = far_m * in_plane(dvec3(direction)), half(form.half_size_m);
    const dvec2 reach(form.spread.cotangent > 0.0f ? height / double{form.spread.cotangent} : INFINITY);
    const dvec2 low = glm::max(-half - foot, -reach), high = glm::min(half - foot, reach);
    const dvec2 on_unit = (foot + beside) / half;
    if (beside.x < low.x || beside.y < low.y || beside.x > high.x || beside.y > high.y ||
        (form.is_ellipse && glm::dot(on_unit, on_unit) > 1.0))
        return {};
    const dvec2 size = high - low, away = glm::max(glm::abs(foot) - half, dvec2(0.0)), across = glm::abs(foot) + half;
    const bool is_whole = size.x > 1.9999 * half.x && size.y > 1.9999 * half.y;
    const bool is_far =
        glm::dot(across, across) + height * height < double{area_far_ratio} * (glm::dot(away, away) + height * height);
    const double solid_angle_sr = rectangle_solid_angle_sr(low, high, height), m2_per_sr = far_m * far_m / cosine;
    const double pdf_per_sr = form.is_ellipse && is_whole && is_far           ? double{form.per_area_m2} * m2_per_sr
                              : solid_angle_sr < double{least_solid_angle_sr} ? m2_per_sr / (size.x * size.y)
                                                                              : 1.0 / solid_angle_sr;
    const double lobe =
        double{form.spread.gain} * std::max(0.0, 1.0 - double{form.spread.cotangent} * glm::length(beside) / height);
    return {static_cast<float>(far_m), static_cast<float>(pdf_per_sr),
            static_cast<float>(double{form.per_area_m2} * lobe)};
}

LampHit lamp_hit(const LightAim::Form& form, const vec3& position, const vec3& direction) {
    if (form.kind == Kind::SunCone || form.kind == Kind::SunDisc)
        return sun_hit(form, direction);
    if (form.kind == Kind::Area)
        return area_hit(form, position, direction);
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

float most_pdf_per_sr(const LobeSet& set) {
    float sum = 0.0f, all = 0.0f;
    for (const Lobe& lobe : set.lobes) {
        if (lobe.sampling <= 0.0f)
            continue;
        if (lobe.kind == Lobe::Kind::Sheen) {
            if (sheen::is_narrow(lobe.alpha))
                sum += lobe.sampling * sheen::most_pdf_per_sr(lobe.alpha, lobe.ior);
            all += lobe.sampling;
            continue;
        }
        if (lobe.is_of_fibre()) {
            sum += lobe.sampling * fibre::most_pdf_per_sr(lobe, set.outgoing);
            all += lobe.sampling;
            continue;
        }
        if (lobe.is_toon()) {
            constexpr float broad = 0.05f; // a half angle of 18 degrees
            if (const float cone = toon::one_minus_cos_half_angle(lobe.alpha, lobe.ior); cone < broad)
                sum += lobe.sampling * uniform_cone_pdf_per_sr(cone);
            all += lobe.sampling;
            continue;
        }
        const vec3& normal = lobe.has_own_normal() ? lobe.normal : set.normal;
        if (lobe.is_framed()) {
            sum += lobe.sampling * framed_facets::most_pdf_per_sr(lobe, normal, set.outgoing);
            all += lobe.sampling;
            continue;
        }
        if (lobe.kind != Lobe::Kind::Ggx)
            return std::numeric_limits<float>::infinity();
        const float cosine = std::max(glm::dot(normal, set.outgoing), 0.0f), alpha2 = lobe.alpha * lobe.alpha;
        // Where the facet is the surface's own: ggx::reflected_pdf_per_sr, without the quotient of two zeros.
        const float seen = 0.5f / (cosine + std::sqrt(cosine * cosine + alpha2 * (1.0f - cosine * cosine)));
        sum += lobe.sampling * seen / (pi * alpha2);
        all += lobe.sampling;
    }
    return all > 0.0f ? sum / all : 0.0f;
}

bool lobes_may_find(const LightAim::Form& form, const vec3& position, float most_pdf_per_sr) {
    constexpr float hardly = 0.1f; // a hundredth of the power heuristic's weight
    float least_pdf = 0.0f;        // of aimed rays
    if (form.kind == Kind::Area) {
        const float height = -glm::dot(position - form.position, form.area_axes[2]);
        if (!(height > 0.0f))
            return false;
        const float box_m2 =
            4.0f * form.half_size_m.x * form.half_size_m.y; // its solid angle is at most this over height^2
        least_pdf = std::max(0.5f / pi, height * height / box_m2);
    } else if (form.kind == Kind::SunCone)
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
    return !(most_pdf_per_sr <= hardly * least_pdf);
}

bool are_sharp(const LobeSet& lobes) {
    // GGX of roughness 0.37 from above. Measured beneath 33 to 10,000 lamps at 0.3: what is left of the noise costs as much.
    constexpr float broad_per_sr = 4.0f;
    return most_pdf_per_sr(lobes) > broad_per_sr;
}
} // namespace tyndall::render
