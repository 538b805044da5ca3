// SPDX-License-Identifier: GPL-3.0-or-later
// One shader at one point, on its way to lobes: of lobe_models.cpp, principled_lobes.cpp and subsurface_lobes.cpp alone.
#pragma once
#include "shading/lobes/diffuse_lobes.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/lobes/ggx_energy.hpp"
#include "shading/lobes/hair_models.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/lobes/sheen.hpp"
#include "shading/lobes/subsurface.hpp"
#include "shading/lobes/thin_film.hpp"
#include "shading/material.hpp"
#include <algorithm>

namespace tyndall {
/// One shader at one point.
class LobeBuilder {
public:
    LobeBuilder(const LobeSource& source, const LobeInputs& inputs, const ShadingPoint& point,
                SurfaceClosures& closures, Lobes* lobes, const LobeNormals& normals)
        : source_(source), inputs_(inputs), point_(point), closures_(closures), lobes_(lobes), normals_(normals),
          diffuse_cosine_(cosine_around(normals.diffuse)), cosine_(cosine_around(normals.facets)),
          coat_cosine_(cosine_around(normals.coat)), weight_(non_negative(inputs[0])) {}

    void build() {
        if (largest(weight_) <= least_share)
            return;
        using Model = LobeModel;
        switch (source_.model) {
        case Model::OrenNayar3:
            return rough_diffuse(weight_ * colour(1), clamped(colour(1)), clamped(number(2)), true);
        case Model::OrenNayar:
            return rough_diffuse(weight_ * colour(1), clamped(colour(1)), clamped(number(2)), false);
        case Model::Lambert:
            return lambert(weight_ * colour(1));
        case Model::Translucent:
            closures_.translucent += weight_ * colour(1);
            return;
        case Model::Glossy3:
        case Model::Glossy:
            return glossy();
        case Model::MetalF82:
            return metal(weight_, clamped(colour(1)), f82_dark(clamped(colour(1)), clamped(non_negative(inputs_[3]))),
                         clamped(number(2)));
        case Model::Conductor:
            return conductor();
        case Model::Glass3:
        case Model::Glass:
            return glass({.reflecting = weight_ * colour(1),
                          .passing = weight_ * colour(1),
                          .let_in = clamped(colour(1)),
                          .straight = Rgb(source_.model == Model::Glass3 ? 1.0f : straight_share(index(3))),
                          .roughness = number(2),
                          .ior = number(3),
                          .is_of_blender3 = source_.model == Model::Glass3});
        case Model::Velvet:
            return velvet();
        case Model::DiffuseToon:
        case Model::GlossyToon:
            return toon();
        case Model::Principled3:
        case Model::Principled3Subsurface:
            return principled_of_blender3();
        case Model::Principled:
        case Model::PrincipledSheen:
        case Model::PrincipledSubsurface:
            return principled();
        case Model::Subsurface:
            return subsurface(weight_ * colour(1), {.albedo = colour(1),
                                                    .radius_m = inputs_[2],
                                                    .alpha = number(3),
                                                    .ior = number(4),
                                                    .anisotropy = number(5)});
        case Model::Sheen:
            sheen(weight_ * colour(1), number(2));
            return;
        case Model::BentGlass3:
        case Model::BentGlass:
            return bent_glass();
        case Model::Refraction:
            return bend(weight_ * colour(1), weight_ * colour(1), Rgb(0.0f), index(2));
        case Model::HairOfColour:
        case Model::HairOfMelanin:
        case Model::HairOfAbsorption:
        case Model::HairReflection:
        case Model::HairTransmission:
            return add_hair_lobes(source_, inputs_, point_, normals_.outgoing, closures_, lobes_);
        }
    }

private:
    /// Shares below do not count.
    static constexpr float least_share = 1e-5f;
    static float largest(const Rgb& value) { return std::max({value.x, value.y, value.z}); }
    static float clamped(float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; }
    static Rgb clamped(const Rgb& value) { return {clamped(value.x), clamped(value.y), clamped(value.z)}; }
    /// Nor so large that light on it would be infinite, of which a mean is no number.
    static Rgb non_negative(const Rgb& value) {
        const auto channel = [](float x) { return x > 0.0f ? std::min(x, 1e18f) : 0.0f; };
        return {channel(value.x), channel(value.y), channel(value.z)};
    }

    [[nodiscard]] float number(std::size_t input) const { return inputs_[input].x; }
    [[nodiscard]] float index(std::size_t i) const { return std::min(std::max(1e-5f, number(i)), 1e6f); } // of NaN, too
    /// The surface's own colour.
    [[nodiscard]] Rgb colour(std::size_t input) const { return point_.tint * non_negative(inputs_[input]); }

    /// On the surface's outer side; no film where it is too thin.
    [[nodiscard]] ThinFilm film() const {
        const std::size_t at = input_count(source_.model);
        if (!source_.film || !(number(at) > thinnest_film_nm))
            return {};
        return {.spectra = source_.film.get(), .thickness_nm = number(at), .ior = index(at + 1)};
    }
    /// Of the way to the viewer.
    [[nodiscard]] float cosine_around(const vec3& normal) const {
        return normal == vec3(0.0f) ? point_.view_cosine : std::max(glm::dot(normal, normals_.outgoing), 0.0f);
    }

    /// `sampling`: how much it shines, of light from all around.
    void add(Lobe lobe) {
        const float cosine = cosine_around(lobe.normal);
        if (!(largest(lobe.weight) > least_share) || (lobe.has_own_normal() && !lobe.is_matte() && cosine <= 0.0f))
            return;
        if (lobe.has_own_normal() && lobe.is_matte())
            lobe.bump_shadowing = source_.bump_shadowing;
        if (lobes_ == nullptr) { // as if it were Lambert's
            closures_.diffuse_albedo += lobe.weight * (lobe.is_diffuse() ? Rgb(1.0f) : facet_colour(lobe, cosine));
            return;
        }
        if (lobe.is_of_facets())
            lobe.sampling = std::max(average(lobe.weight * facet_colour(lobe, cosine)), 1e-3f * average(lobe.weight));
        lobes_->push_back(lobe);
    }
    [[nodiscard]] Lobe facets(float roughness, const Rgb& weight) const {
        constexpr Lobe::Kind kinds[] = {Lobe::Kind::Ggx, Lobe::Kind::Beckmann, Lobe::Kind::AshikhminShirley};
        const float alpha = clamped(roughness) * clamped(roughness);
        return {.kind = kinds[static_cast<std::size_t>(source_.distribution)],
                .alpha = std::max(alpha, least_alpha),
                .own_alpha = alpha,
                .weight = weight,
                .normal = normals_.facets};
    }
    /// The same along the tangent, if there is one.
    [[nodiscard]] Lobe facets_along_tangent(float roughness, const Rgb& weight) const {
        Lobe lobe = facets(roughness, weight);
        if (normals_.tangent != vec3(0.0f) && lobe.own_alpha > 0.0f)
            widen_along(lobe, normals_.tangent, lobe.has_own_normal() ? lobe.normal : point_.shading_normal);
        return lobe;
    }
    /// By the tangent's length. No width exceeds 1, as in Cycles.
    static void widen_along(Lobe& lobe, const vec3& tangent, const vec3& normal) {
        constexpr float narrowest = 0.1f * least_alpha; // of which floats still tell half vectors by hundreds
        const vec3 across = glm::cross(normal, tangent);
        const float ratio2 = glm::dot(tangent, tangent), across2 = glm::dot(across, across);
        if (!(across2 > 1e-12f * ratio2) || !(ratio2 > 1e-12f && ratio2 < 1e12f))
            return;
        const float ratio = std::sqrt(ratio2);
        const float along = std::min(lobe.own_alpha * ratio, 1.0f), beside = std::min(lobe.own_alpha / ratio, 1.0f);
        if (along == beside)
            return;
        lobe.own_alpha = std::sqrt(along * beside);
        lobe.alpha = std::max(lobe.own_alpha, least_alpha);
        if (lobe.kind == Lobe::Kind::Ggx)
            lobe.kind = Lobe::Kind::GgxAlongTangent;
        const float widest = lobe.alpha / narrowest;
        lobe.tangent = glm::cross(across, normal) *
                       (std::clamp(std::sqrt(along / beside), 1.0f / widest, widest) / std::sqrt(across2));
    }
    /// That by which tables know the facets.
    [[nodiscard]] static float evened_roughness(const Lobe& lobe, float roughness) {
        return lobe.is_anisotropic() ? std::sqrt(lobe.own_alpha) : roughness;
    }
    /// Facets as they are with what they hide from one another, of which the mean of their colour is `mean`. The share of
    /// the weight that counts as their albedo.
    Rgb preserve_energy(Lobe& lobe, const Rgb& mean, float roughness) const {
        if (!source_.preserves_energy)
            return Rgb(1.0f);
        return give_back(lobe, mean, ggx::albedo(evened_roughness(lobe, roughness), cosine_));
    }
    static Rgb give_back(Lobe& lobe, const Rgb& mean, const ggx::Albedo& albedo) {
        const float missing = (1.0f - albedo.seen) / albedo.seen;
        const Rgb factor = 1.0f + mean * albedo.mean / (1.0f - mean * (1.0f - albedo.mean)) * missing;
        lobe.weight *= factor;
        return factor / (1.0f + missing);
    }
    /// What a layer of this albedo leaves of the weight below.
    [[nodiscard]] static Rgb below(const Rgb& albedo, const Rgb& weight) {
        const auto share = [&](int channel) {
            return weight[channel] > 0.0f ? albedo[channel] / weight[channel] : 0.0f;
        };
        return weight * clamped(1.0f - std::max({share(0), share(1), share(2)}));
    }

    void lambert(const Rgb& weight) {
        if (normals_.diffuse == vec3(0.0f))
            closures_.diffuse_albedo += weight;
        else
            add({.kind = Lobe::Kind::Lambert, .weight = weight, .normal = normals_.diffuse});
    }

    void rough_diffuse(const Rgb& weight, const Rgb& albedo, float roughness, bool is_of_blender3) {
        if (roughness < least_share)
            return lambert(weight);
        const auto of =
            is_of_blender3 ? oren_nayar::coefficients_of_blender3(roughness) : oren_nayar::coefficients(roughness);
        add({.kind = Lobe::Kind::OrenNayar,
             .alpha = of.a,
             .ior = of.b,
             .weight = weight,
             .b = is_of_blender3 ? Rgb(0.0f) : oren_nayar::further(of, albedo, diffuse_cosine_),
             .normal = normals_.diffuse});
    }

    void glossy() {
        Lobe lobe = facets_along_tangent(number(2), weight_ * colour(1));
        lobe.is_separable = source_.model == LobeModel::Glossy3;
        preserve_energy(lobe, clamped(colour(1)), clamped(number(2)));
        add(lobe);
    }

    void metal(const Rgb& weight, const Rgb& straight, const Rgb& dark, float roughness) {
        Lobe lobe = facets_along_tangent(roughness, weight);
        lobe.fresnel = Lobe::Fresnel::F82;
        lobe.a = straight;
        lobe.b = dark;
        if (source_.film && source_.film->covers_metals)
            lobe.film = film();
        preserve_energy(lobe, mean_f82(straight, dark), roughness);
        add(lobe);
    }

    void conductor() {
        const Rgb n = non_negative(inputs_[1]), k = non_negative(inputs_[3]);
        Lobe lobe = facets_along_tangent(number(2), weight_);
        lobe.fresnel = Lobe::Fresnel::Conductor;
        lobe.a = n;
        lobe.b = k;
        lobe.film = film();
        // Its mean by the metal of fresnel_f82 that reflects as much straight and at 82 degrees.
        const Rgb straight = fresnel_conductor(1.0f, n, k);
        const Rgb dark = f82_dark_of_edge(straight, fresnel_conductor(1.0f / 7.0f, n, k));
        preserve_energy(lobe, clamped(mean_f82(straight, dark)), clamped(number(2)));
        add(lobe);
    }

    struct Glass {
        Rgb reflecting; ///< Times what rises from `straight` to 1.
        Rgb passing;    ///< Already among what is transparent; what is not mirrored stays.
        Rgb let_in;     ///< Its colour.
        Rgb straight;
        float roughness;
        float ior; ///< From without.
        /// The whole lobe has the share of the surface's own cosine.
        bool is_of_blender3;
    };
    void glass(const Glass& of) {
        const float outside = std::max(of.ior, 1e-5f), ior = point_.is_backface ? 1.0f / outside : outside;
        const float share = fresnel_of_any_index(cosine_, ior);
        Lobe lobe = facets(of.roughness, of.is_of_blender3 ? of.reflecting * share : of.reflecting);
        lobe.is_separable = of.is_of_blender3;
        if (!of.is_of_blender3 || of.straight != Rgb(1.0f)) {
            lobe.fresnel = Lobe::Fresnel::Dielectric;
            lobe.a = of.straight;
            lobe.ior = ior;
        }
        cover_glass(lobe, outside);
        const Rgb kept = lobe.film.spectra == nullptr ? Rgb(share) : facet_colour(lobe, cosine_);
        closures_.transparent = glm::max(closures_.transparent - of.passing * kept, Rgb(0.0f));
        // What is hidden is mostly let in at last, as it is in Cycles. Sharp facets hide nothing.
        if (source_.preserves_energy && !of.is_of_blender3 && lobe.own_alpha > 0.0f)
            give_back(lobe, of.let_in, ggx::glass_albedo(clamped(of.roughness), cosine_, ior));
        add(lobe);
    }

    /// Seen from within, the film lies beyond the glass: its index counts against that.
    void cover_glass(Lobe& lobe, float outside) const {
        lobe.film = film();
        if (point_.is_backface)
            lobe.film.ior /= outside;
    }

    void bent_glass() {
        const bool is_of_blender3 = source_.model == LobeModel::BentGlass3;
        const Rgb reflecting = weight_ * colour(1), passing = weight_ * colour(2), tint = clamped(inputs_[3]);
        const float from_outside = index(4);
        const Rgb straight = is_of_blender3 ? tint : straight_share(from_outside) * tint;
        if (lobes_ == nullptr)
            return glass({.reflecting = reflecting,
                          .passing = passing,
                          .let_in = Rgb(1.0f),
                          .straight = straight,
                          .roughness = 0.0f,
                          .ior = from_outside,
                          .is_of_blender3 = is_of_blender3});
        const float ior = point_.is_backface ? 1.0f / from_outside : from_outside;
        const float share = fresnel_of_any_index(cosine_, ior), rise = fresnel_rise_of_any_index(cosine_, ior);
        const Rgb risen = glm::mix(straight, Rgb(1.0f), rise);
        Rgb mirrored = is_of_blender3 ? share * risen : tint == Rgb(1.0f) ? Rgb(share) : risen;
        Lobe covered{.fresnel = Lobe::Fresnel::Dielectric, .ior = ior, .a = straight};
        cover_glass(covered, from_outside);
        if (covered.film.spectra != nullptr)
            mirrored = facet_colour(covered, cosine_);
        bend(passing, passing * (1.0f - (is_of_blender3 ? Rgb(share) : mirrored)), reflecting * mirrored, from_outside);
    }

    /// Of `passing`, which is among what is transparent, nothing passes straight any more.
    void bend(const Rgb& passing, const Rgb& let_in, const Rgb& mirrored, float from_outside) {
        if (lobes_ == nullptr)
            return;
        constexpr float rounding = 1e-6f; // the program has its own way to the same product
        const Rgb rest = closures_.transparent - passing;
        closures_.transparent = rest * Rgb(glm::greaterThan(rest, Rgb(rounding)));
        lobes_->push_back({.kind = Lobe::Kind::Bent,
                           .ior = point_.is_backface ? 1.0f / from_outside : from_outside,
                           .weight = let_in,
                           .a = mirrored,
                           .normal = normals_.facets});
    }

    void velvet() {
        const float sigma = std::max(clamped(number(2)), 0.01f);
        add({.kind = Lobe::Kind::Velvet,
             .alpha = 1.0f / (sigma * sigma),
             .weight = weight_ * colour(1),
             .normal = normals_.diffuse});
    }

    /// Its albedo.
    Rgb sheen(const Rgb& weight, float roughness) {
        const auto [a, b, albedo] = sheen::shape(clamped(roughness), diffuse_cosine_);
        Lobe lobe{
            .kind = Lobe::Kind::Sheen, .alpha = a, .ior = b, .weight = weight * albedo, .normal = normals_.diffuse};
        lobe.sampling = average(lobe.weight);
        add(lobe);
        return lobe.weight;
    }

    void toon() {
        constexpr float quarter_turn = 1.57079633f;
        const Rgb weight = weight_ * colour(1);
        add({.kind = source_.model == LobeModel::DiffuseToon ? Lobe::Kind::DiffuseToon : Lobe::Kind::GlossyToon,
             .alpha = quarter_turn * clamped(number(2)),
             .ior = quarter_turn * clamped(number(3)),
             .sampling = average(weight),
             .weight = weight,
             .normal = normals_.diffuse});
    }

    /// Layers, in principled_lobes.cpp.
    void principled_of_blender3();
    void principled();
    /// What lies below a surface.
    struct Below {
        Rgb albedo;   ///< Of a thick piece of it.
        Rgb radius_m; ///< As the artist has it.
        float alpha;  ///< Width of the facets by which a walk begins.
        float ior;    ///< By which they refract.
        float anisotropy;
        float roughness = 0.0f; ///< Of what the surface sends back by itself: up to Blender 3.x.
    };
    /// In subsurface_lobes.cpp.
    void subsurface(const Rgb& weight, const Below& below);
    /// Of fresnel_rise_of_any_index, over the hemisphere by the cosine.
    [[nodiscard]] static float mean_rise_of(float ior);
    [[nodiscard]] Rgb below_coat(const Rgb& weight, float coat);

    const LobeSource& source_;
    const LobeInputs& inputs_;
    const ShadingPoint& point_;
    SurfaceClosures& closures_;
    Lobes* lobes_;
    const LobeNormals& normals_;
    float diffuse_cosine_, cosine_, coat_cosine_; ///< Of the way to the viewer; the second around the facets' normal.
    Rgb weight_;
};
} // namespace tyndall
