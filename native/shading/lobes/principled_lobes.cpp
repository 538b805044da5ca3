// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/lobe_builder.hpp"

namespace tyndall {
void LobeBuilder::principled_of_blender3() {
    const Rgb base = colour(1);
    const float metallic = clamped(number(2)), roughness = clamped(number(3)), specular = number(4),
                specular_tint = clamped(number(5)), transmission = clamped(number(10));
    const Rgb diffuse = weight_ * ((1.0f - metallic) * (1.0f - transmission));
    const bool has_subsurface = source_.model == LobeModel::Principled3Subsurface && std::abs(number(12)) > least_share;
    if (has_subsurface)
        subsurface(diffuse * colour(16), {.albedo = colour(16),
                                          .radius_m = number(12) * inputs_[13],
                                          .alpha = 1.0f,
                                          .ior = number(14),
                                          .anisotropy = number(15),
                                          .roughness = roughness});
    else
        add({.kind = Lobe::Kind::Burley, .alpha = roughness, .weight = diffuse * base, .normal = normals_.diffuse});
    const auto hue = [&](const Rgb& luminance) {
        const float light = glm::dot(base, luminance);
        return light > 0.0f ? base / light : Rgb(1.0f);
    };
    const Rgb sheen_colour = glm::mix(Rgb(1.0f), hue({0.2126729f, 0.7151522f, 0.0721750f}), clamped(number(7)));
    add({.kind = Lobe::Kind::BurleySheen,
         .weight = diffuse * sheen_colour * std::max(number(6), 0.0f),
         .normal = normals_.diffuse});
    const float passing = transmission * (1.0f - metallic);
    if (specular > least_share || metallic > least_share) {
        const Rgb tinted = glm::mix(Rgb(1.0f), hue({0.3f, 0.6f, 0.1f}), specular_tint);
        Lobe lobe = facets_along_tangent(roughness, weight_ * (1.0f - passing));
        lobe.is_separable = true;
        lobe.fresnel = Lobe::Fresnel::Dielectric;
        lobe.ior = ior_of_straight_share(0.08f * specular);
        lobe.a = clamped(0.08f * specular * tinted * (1.0f - metallic) + base * metallic);
        preserve_energy(lobe, glm::mix(lobe.a, Rgb(1.0f), mean_rise_of(lobe.ior)), roughness);
        add(lobe);
    }
    if (passing > least_share)
        glass({.reflecting = weight_ * passing,
               .passing = weight_ * base * passing,
               .let_in = clamped(base),
               .straight = clamped(glm::mix(Rgb(1.0f), base, specular_tint)),
               .roughness = roughness,
               .ior = number(11),
               .is_of_blender3 = true});
    Lobe coat = facets(number(9), weight_ * (0.25f * std::max(number(8), 0.0f)));
    coat.kind = Lobe::Kind::Clearcoat;
    coat.normal = normals_.coat;
    coat.fresnel = Lobe::Fresnel::Dielectric;
    coat.a = Rgb(0.04f);
    add(coat);
}

void LobeBuilder::principled() {
    const Rgb base = colour(1);
    const float metallic = clamped(number(2)), roughness = clamped(number(3)), transmission = clamped(number(6));
    const Rgb tint = non_negative(inputs_[5]);
    const bool has_subsurface = source_.model == LobeModel::PrincipledSubsurface;
    const bool has_sheen = source_.model == LobeModel::PrincipledSheen || (has_subsurface && inputs_[14] != Rgb(0.0f));
    const Rgb below_sheen =
        has_sheen ? below(sheen(weight_ * non_negative(inputs_[14]), number(15)), weight_) : weight_;
    Rgb weight = below_sheen;
    if (const float coat = std::max(number(8), 0.0f); coat > least_share)
        weight = below_coat(weight, coat);
    closures_.emission += weight * non_negative(inputs_[principled_emission]);
    if (metallic > least_share) {
        const Rgb straight = clamped(base);
        metal(weight * metallic, straight, f82_dark(straight, glm::min(tint, Rgb(1.0f))), roughness);
        weight *= 1.0f - metallic;
    }
    const float ior = index(7);
    if (transmission > least_share) {
        const Rgb all = weight_ * ((1.0f - metallic) * transmission);
        const Rgb share = below_sheen * ((1.0f - metallic) * transmission);
        const Rgb let_in = glm::sqrt(base);
        closures_.transparent = glm::max(closures_.transparent - (all - share) * let_in, Rgb(0.0f));
        glass({.reflecting = weight * transmission,
               .passing = share * let_in,
               .let_in = clamped(let_in),
               .straight = clamped(straight_share(ior) * tint),
               .roughness = roughness,
               .ior = ior,
               .is_of_blender3 = false});
        weight *= 1.0f - transmission;
    }
    const float level = std::max(number(4), 0.0f);
    float straight = straight_share(ior), eta = ior;
    if (level != 0.5f) {
        straight *= 2.0f * level;
        eta = ior_of_straight_share(straight);
        if (ior < 1.0f)
            eta = 1.0f / eta;
    }
    if (const ThinFilm covering = film(); eta != 1.0f || covering.spectra != nullptr) {
        Lobe lobe = facets_along_tangent(roughness, weight);
        lobe.fresnel = Lobe::Fresnel::Dielectric;
        lobe.ior = eta;
        lobe.a = clamped(straight * tint);
        lobe.film = covering;
        const Rgb mean = glm::mix(lobe.a, Rgb(1.0f), mean_rise_of(eta));
        const Rgb share = preserve_energy(lobe, mean, roughness);
        add(lobe);
        const float evened = evened_roughness(lobe, roughness);
        // No table knows a film's mean: it is what a smooth surface has.
        const Rgb albedo = covering.spectra != nullptr
                               ? facet_colour(lobe, cosine_)
                               : glm::mix(lobe.a, Rgb(1.0f), ggx::mean_rise(evened, cosine_, eta));
        weight = below(weight * share * albedo, weight);
    }
    if (has_subsurface) {
        const float share = clamped(number(16));
        subsurface(weight * clamped(base) * share,
                   {.albedo = clamped(base),
                    .radius_m = inputs_[17],
                    .alpha = roughness * roughness,
                    .ior = source_.subsurface == SubsurfaceMethod::SkinWalk ? number(18) : eta,
                    .anisotropy = number(19)});
        weight *= 1.0f - share;
    }
    rough_diffuse(weight * base, clamped(base), clamped(number(12)), false);
}

float LobeBuilder::mean_rise_of(float ior) {
    const float straight = straight_share(ior);
    return clamped((mean_fresnel(ior) - straight) / (1.0f - straight));
}

Rgb LobeBuilder::below_coat(const Rgb& weight, float coat) {
    const float ior = std::max(number(10), 1.0f), roughness = clamped(number(9));
    Lobe lobe = facets(roughness, weight * coat);
    lobe.normal = normals_.coat;
    lobe.fresnel = Lobe::Fresnel::Dielectric;
    lobe.ior = ior;
    lobe.a = Rgb(straight_share(ior));
    const Rgb share = give_back(lobe, Rgb(mean_fresnel(ior)), ggx::albedo(roughness, coat_cosine_));
    add(lobe);
    const Rgb albedo = glm::mix(lobe.a, Rgb(1.0f), ggx::mean_rise(roughness, coat_cosine_, ior));
    const Rgb left = below(weight * coat * share * albedo, weight);
    // Beer's law along the refracted way; the tint is that of the way straight through.
    const float inner = std::sqrt(std::max(0.0f, 1.0f - (1.0f - coat_cosine_ * coat_cosine_) / (ior * ior)));
    const Rgb through = glm::pow(non_negative(inputs_[11]), Rgb(1.0f / std::max(inner, 1e-3f)));
    return left * glm::mix(Rgb(1.0f), through, coat);
}
} // namespace tyndall
