// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/lobe_set.hpp"
#include "shading/lobes/ashikhmin_shirley.hpp"
#include "shading/lobes/clearcoat.hpp"
#include "shading/lobes/diffuse_lobes.hpp"
#include "shading/lobes/fibre.hpp"
#include "shading/lobes/framed_facets.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/lobes/ggx.hpp"
#include "shading/lobes/sheen.hpp"
#include <algorithm>
#include <optional>

namespace tyndall {
namespace {
/// What lobes ask of two directions, once for all of them.
struct Angles {
    float view, light, between;     ///< Cosines.
    float normal_half = 0.0f;       ///<
    float normal_half2 = 0.0f;      ///< Squared cosine of normal and half vector.
    float normal_half_sine2 = 0.0f; ///< And squared sine.
    float view_half = 0.0f;         ///< Cosine of view and half vector.

    Angles(const vec3& normal, const vec3& outgoing, const vec3& incoming)
        : view(glm::dot(normal, outgoing)), light(glm::dot(normal, incoming)), between(glm::dot(outgoing, incoming)) {
        const vec3 sum = outgoing + incoming;
        const float length2 = glm::dot(sum, sum);
        if (length2 <= 0.0f)
            return;
        const vec3 half = sum / std::sqrt(length2), across = glm::cross(normal, half);
        normal_half = glm::dot(normal, half);
        normal_half2 = normal_half * normal_half;
        normal_half_sine2 = glm::dot(across, across);
        view_half = glm::dot(half, outgoing);
    }
};

const vec3& normal_of(const Lobe& lobe, const LobeSet& set) { return lobe.has_own_normal() ? lobe.normal : set.normal; }

/// In the middle of its cone.
vec3 toon_axis(const Lobe& lobe, const LobeSet& set) {
    const vec3& normal = normal_of(lobe, set);
    return lobe.kind == Lobe::Kind::DiffuseToon ? normal
                                                : 2.0f * glm::dot(normal, set.outgoing) * normal - set.outgoing;
}

Rgb reflected(const Lobe& lobe, const LobeSet& set, const vec3& incoming, const Angles& angles) {
    switch (lobe.kind) {
    case Lobe::Kind::Lambert:
        return Rgb(std::numbers::inv_pi_v<float>);
    case Lobe::Kind::OrenNayar: {
        const oren_nayar::Coefficients of{lobe.alpha, lobe.ior};
        const float once = oren_nayar::once(of, angles.light, angles.view, angles.between);
        return Rgb(once) + (lobe.b == Rgb(0.0f) ? lobe.b : lobe.b * (1.0f - oren_nayar::once_albedo(of, angles.light)));
    }
    case Lobe::Kind::Burley:
        return Rgb(burley::diffuse(lobe.alpha, angles.light, angles.view, angles.between));
    case Lobe::Kind::BurleyRetro:
        return Rgb(burley::retro(lobe.alpha, angles.light, angles.view, angles.between));
    case Lobe::Kind::BurleySheen:
        return Rgb(burley::sheen(angles.view_half));
    case Lobe::Kind::Sheen:
        return Rgb(sheen::per_irradiance(lobe.alpha, lobe.ior, angles.light, angles.view, angles.between));
    case Lobe::Kind::Velvet:
        return Rgb(velvet(lobe.alpha, angles.light, angles.view, std::sqrt(angles.normal_half2), angles.view_half));
    case Lobe::Kind::DiffuseToon:
        return Rgb(toon::reflected(lobe.alpha, lobe.ior, angles.light) / angles.light);
    case Lobe::Kind::GlossyToon:
        return Rgb(toon::reflected(lobe.alpha, lobe.ior, glm::dot(toon_axis(lobe, set), incoming)) / angles.light);
    case Lobe::Kind::Clearcoat:
        return facet_colour(lobe, angles.view_half) *
               (clearcoat::distribution(lobe.alpha, angles.normal_half2) *
                ggx::masking_and_shadowing(clearcoat::masking_alpha, angles.view, angles.light, true) /
                (4.0f * angles.view * angles.light));
    case Lobe::Kind::Fibre: // and its others: see LobeSet::of_fibre
    case Lobe::Kind::FibreReflection:
    case Lobe::Kind::FibreTransmission:
    case Lobe::Kind::Bent: // these two are none of its lobes
    case Lobe::Kind::Subsurface:
    case Lobe::Kind::GgxAlongTangent: // see reflected_by_framed
    case Lobe::Kind::Beckmann:
    case Lobe::Kind::AshikhminShirley:
    case Lobe::Kind::Ggx:
        break;
    }
    return facet_colour(lobe, angles.view_half) *
           (ggx::distribution(lobe.alpha, angles.normal_half_sine2, angles.normal_half2) *
            ggx::masking_and_shadowing(lobe.alpha, angles.view, angles.light, lobe.is_separable) /
            (4.0f * angles.view * angles.light));
}

/// Apart, so that other lobes do not have to make room for what these compute.
[[gnu::noinline]] Rgb reflected_by_framed(const Lobe& lobe, const LobeSet& set, const vec3& incoming, float view_half) {
    return facet_colour(lobe, view_half) *
           framed_facets::per_irradiance(lobe, normal_of(lobe, set), set.outgoing, incoming);
}

/// Of what is seen past its smooth normal, along a coarse mesh's silhouette, only what is broad sends light there.
bool sees(const Lobe& lobe, const Angles& angles) {
    return angles.light > 0.0f && (angles.view > 0.0f || lobe.is_broad());
}
/// It looks as it does from along the surface; sheen has axes by the view.
void limit_view(const Lobe& lobe, Angles& angles) {
    if (lobe.kind != Lobe::Kind::Sheen)
        angles.view = std::max(angles.view, 0.0f);
}

/// The same around the lobe's own normal; `light`: the cosine that is in the irradiance.
Rgb reflected_around_own(const Lobe& lobe, const LobeSet& set, const vec3& incoming, float light) {
    Angles angles(lobe.normal, set.outgoing, incoming);
    const float between = glm::dot(set.normal, lobe.normal);
    const bool is_turned_away = lobe.is_matte() && (light <= 0.0f || between <= 0.0f);
    if (is_turned_away || !sees(lobe, angles))
        return Rgb(0.0f);
    limit_view(lobe, angles);
    const float left = unshadowed_by_bumps(lobe.bump_shadowing, light, angles.light, between);
    const Rgb found = lobe.is_framed() ? reflected_by_framed(lobe, set, incoming, angles.view_half)
                                       : reflected(lobe, set, incoming, angles);
    return found * (left * angles.light / std::max(light, LobeSet::least_cosine));
}

float pdf_of(const Lobe& lobe, const Angles& angles) {
    if (lobe.kind == Lobe::Kind::Sheen)
        return angles.light > 0.0f ? angles.light * sheen::per_irradiance(lobe.alpha, lobe.ior, angles.light,
                                                                          angles.view, angles.between)
                                   : 0.0f;
    if (angles.view <= 0.0f)
        return 0.0f;
    if (lobe.kind == Lobe::Kind::Clearcoat)
        return clearcoat::distribution(lobe.alpha, angles.normal_half2) * std::sqrt(angles.normal_half2) /
               (4.0f * std::max(angles.view_half, 1e-6f));
    if (angles.normal_half <= 0.0f) // no facet that is seen sends light there
        return 0.0f;
    return ggx::reflected_pdf_per_sr(lobe.alpha, angles.view, angles.normal_half_sine2, angles.normal_half2);
}

/// The axes are the sheen's: x along the view's part in the surface.
vec3 sample_sheen(const Lobe& lobe, const vec3& normal, const vec3& outgoing, vec2 u) {
    const vec3 across = outgoing - glm::dot(outgoing, normal) * normal;
    const float sine = glm::length(across);
    const vec3 x = sine > 1e-6f ? across / sine : orthonormal_basis(normal).first;
    const vec3 direction = sheen::sample(lobe.alpha, lobe.ior, u);
    return glm::normalize(direction.x * x + direction.y * glm::cross(normal, x) + direction.z * normal);
}

vec3 mirrored(const vec3& outgoing, const vec3& facet) {
    return glm::normalize(2.0f * glm::dot(outgoing, facet) * facet - outgoing);
}

float sum_of_sampling(std::span<const Lobe> lobes) {
    float sum = 0.0f;
    for (const Lobe& lobe : lobes)
        sum += lobe.sampling;
    return sum;
}
} // namespace

/// Of a film over a dielectric whose share straight is `a` in place of its own: what the film mirrors counts as much
/// more or less, and the same where it is all.
static Rgb scaled_film(const Lobe& lobe, float cosine) {
    const Rgb mirrored = film_over_dielectric(cosine, lobe.film, lobe.ior);
    const float straight = straight_share(lobe.ior);
    if (!(straight > 1e-5f))
        return mirrored;
    const Rgb from_all = glm::clamp((mirrored - 1.0f) / (straight - 1.0f), 0.0f, 1.0f);
    return mirrored * glm::mix(Rgb(1.0f), lobe.a / straight, from_all);
}

/// Apart: what has no film shall not make room for it.
[[gnu::noinline]] static Rgb colour_of_film(const Lobe& lobe, float cosine) {
    switch (lobe.fresnel) {
    case Lobe::Fresnel::Dielectric:
        return scaled_film(lobe, cosine);
    case Lobe::Fresnel::F82:
        return film_over_f82(cosine, lobe.film, lobe.a, lobe.b);
    case Lobe::Fresnel::Conductor:
        return film_over_conductor(cosine, lobe.film, lobe.a, lobe.b);
    case Lobe::Fresnel::None:
        break;
    }
    return Rgb(1.0f);
}

Rgb facet_colour(const Lobe& lobe, float cosine) {
    if (lobe.film.spectra != nullptr)
        return colour_of_film(lobe, cosine);
    switch (lobe.fresnel) {
    case Lobe::Fresnel::Dielectric:
        return glm::mix(lobe.a, lobe.b, fresnel_rise_of_any_index(cosine, lobe.ior));
    case Lobe::Fresnel::F82:
        return fresnel_f82(cosine, lobe.a, lobe.b);
    case Lobe::Fresnel::Conductor:
        return fresnel_conductor(cosine, lobe.a, lobe.b);
    case Lobe::Fresnel::None:
        break;
    }
    return Rgb(1.0f);
}

/// What Cycles takes for a mirror, up to 3.x and since: a square of alpha that is no more than 1e-7 and 2e-10.
static bool is_mirror(const Lobe& lobe) {
    if (lobe.kind == Lobe::Kind::AshikhminShirley) {
        const float ratio = lobe.is_anisotropic() ? glm::length(lobe.tangent) : 1.0f;
        return lobe.own_alpha * std::max(ratio, 1.0f / ratio) <= ashikhmin_shirley::least_width;
    }
    const bool is_old = lobe.is_separable || lobe.kind == Lobe::Kind::Clearcoat;
    return lobe.own_alpha * lobe.own_alpha <= (is_old ? 1e-7f : 2e-10f);
}

namespace {
Rgb reflected_by_any(const Lobe& lobe, const LobeSet& set, const vec3& incoming, const Angles& angles) {
    if (lobe.has_own_normal())
        return reflected_around_own(lobe, set, incoming, angles.light);
    if (!sees(lobe, angles))
        return Rgb(0.0f);
    if (lobe.is_framed())
        return reflected_by_framed(lobe, set, incoming, angles.view_half);
    Angles limited = angles;
    limit_view(lobe, limited);
    return reflected(lobe, set, incoming, limited);
}

/// By facets as narrow as they are.
[[gnu::noinline]] Rgb reflected_by_narrow(const Lobe& lobe, const LobeSet& set, const vec3& incoming,
                                          const Angles& angles) {
    if (is_mirror(lobe))
        return Rgb(0.0f);
    Lobe narrow = lobe;
    narrow.alpha = lobe.own_alpha;
    return reflected_by_any(narrow, set, incoming, angles);
}

/// Of neighbouring lobes along one fibre, worked out once.
class Meetings {
public:
    Meetings(const vec3& outgoing, const vec3& incoming) : outgoing_(outgoing), incoming_(incoming) {}
    const fibre::Meeting& along(const vec3& fibre) {
        if (!last_ || last_->frame.along != fibre)
            last_.emplace(fibre, outgoing_, incoming_);
        return *last_;
    }

private:
    const vec3 &outgoing_, &incoming_;
    std::optional<fibre::Meeting> last_;
};
} // namespace

float LobeSet::of_fibre(const Lobe& lobe, const fibre::Meeting& meeting, Way way) const {
    if (way == Way::Drawn)
        return fibre::pdf_per_sr(lobe, meeting);
    const bool is_seen_side = glm::dot(normal, outgoing) > 0.0f;
    if (lobe.kind == (is_seen_side ? Lobe::Kind::FibreTransmission : Lobe::Kind::FibreReflection))
        return 0.0f;
    return fibre::scattered(lobe, meeting);
}

Rgb LobeSet::sum_of(const vec3& incoming, Way way) const {
    const Angles angles(normal, outgoing, incoming);
    Rgb sum(0.0f);
    if (angles.light <= 0.0f && !reflects_from_behind())
        return sum;
    Meetings meetings(outgoing, incoming);
    for (const Lobe& lobe : lobes) {
        if (lobe.is_of_fibre()) {
            if (angles.light <= 0.0f) // it has the other side for that
                continue;
            sum +=
                lobe.weight * (of_fibre(lobe, meetings.along(lobe.normal), way) / std::max(angles.light, least_cosine));
            continue;
        }
        if (way == Way::FromPoint && lobe.is_of_facets() && lobe.own_alpha < lobe.alpha)
            sum += lobe.weight * reflected_by_narrow(lobe, *this, incoming, angles);
        else
            sum += lobe.weight * reflected_by_any(lobe, *this, incoming, angles);
    }
    return sum;
}

bool LobeSet::draws_on_both_sides() const {
    return std::ranges::any_of(lobes, [](const Lobe& lobe) { return lobe.kind > Lobe::Kind::Fibre; });
}

bool LobeSet::reflects_from_behind() const {
    return std::ranges::any_of(lobes, [](const Lobe& lobe) { return lobe.has_own_normal() && !lobe.is_matte(); });
}

float LobeSet::share_of_directions(float lambert_share) const {
    float with_directions = 0.0f, without = lambert_share;
    for (const Lobe& lobe : lobes) {
        with_directions += lobe.sampling;
        if (lobe.sampling <= 0.0f)
            without += average(lobe.weight);
    }
    if (!(with_directions > 0.0f))
        return 0.0f;
    return std::clamp(with_directions / (with_directions + std::max(without, 0.0f)), least_share, most_share);
}

bool LobeSet::has_directions() const { return sum_of_sampling(lobes) > 0.0f; }

vec3 LobeSet::sample(vec2 u) const {
    float left = u.x * sum_of_sampling(lobes);
    const Lobe* drawn = nullptr;
    for (const Lobe& lobe : lobes) {
        if (lobe.sampling <= 0.0f)
            continue;
        drawn = &lobe;
        if (left < lobe.sampling)
            break;
        left -= lobe.sampling;
    }
    u.x = std::min(left / drawn->sampling, 0.99999994f); // what chose a lobe is even again within it
    if (drawn->is_of_fibre())
        return fibre::sample(*drawn, outgoing, u);
    if (drawn->is_toon())
        return from_frame(toon_axis(*drawn, *this),
                          sample_uniform_cone(u, toon::one_minus_cos_half_angle(drawn->alpha, drawn->ior)));
    const vec3& around = normal_of(*drawn, *this);
    if (drawn->kind == Lobe::Kind::Sheen)
        return sample_sheen(*drawn, around, outgoing, u);
    if (drawn->is_framed())
        return mirrored(outgoing, framed_facets::sample_normal(*drawn, around, outgoing, u));
    const auto [tangent, bitangent] = orthonormal_basis(around);
    const vec3 view(glm::dot(outgoing, tangent), glm::dot(outgoing, bitangent), glm::dot(outgoing, around));
    const vec3 facet = drawn->kind == Lobe::Kind::Clearcoat ? clearcoat::sample_normal(drawn->alpha, u)
                                                            : ggx::sample_visible_normal(view, vec2(drawn->alpha), u);
    return mirrored(outgoing, facet.x * tangent + facet.y * bitangent + facet.z * around);
}

float LobeSet::pdf_per_sr(const vec3& incoming) const {
    const Angles angles(normal, outgoing, incoming);
    const float all = sum_of_sampling(lobes);
    if (all <= 0.0f)
        return 0.0f;
    float sum = 0.0f;
    Meetings meetings(outgoing, incoming);
    for (const Lobe& lobe : lobes) {
        if (lobe.sampling <= 0.0f)
            continue;
        if (lobe.is_of_fibre())
            sum += lobe.sampling * fibre::pdf_per_sr(lobe, meetings.along(lobe.normal));
        else if (lobe.is_toon())
            sum += lobe.sampling * toon::pdf_per_sr(lobe.alpha, lobe.ior, glm::dot(toon_axis(lobe, *this), incoming));
        else if (lobe.is_framed())
            sum += lobe.sampling * framed_facets::pdf_per_sr(lobe, normal_of(lobe, *this), outgoing, incoming);
        else if (angles.view_half > 0.0f)
            sum +=
                lobe.sampling * pdf_of(lobe, lobe.has_own_normal() ? Angles(lobe.normal, outgoing, incoming) : angles);
    }
    return sum / all;
}

Rgb LobeSet::albedo() const {
    Rgb sum(0.0f);
    for (const Lobe& lobe : lobes)
        sum += lobe.weight * facet_colour(lobe, std::max(glm::dot(normal_of(lobe, *this), outgoing), 0.0f));
    return sum;
}

Rgb LobeSet::diffuse_colour() const {
    Rgb sum(0.0f);
    for (const Lobe& lobe : lobes)
        sum += lobe.is_matte() ? lobe.weight : Rgb(0.0f); // velvet's is that of gloss
    return sum;
}
} // namespace tyndall
