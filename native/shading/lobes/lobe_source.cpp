// SPDX-License-Identifier: GPL-3.0-or-later
// What a source of lobes must hold, by its model.
#include "core/errors.hpp"
#include "shading/lobes/hair_models.hpp"
#include <cmath>

namespace tyndall {
using Model = LobeModel;

std::size_t input_count(Model model) {
    switch (model) {
    case Model::Translucent:
    case Model::Lambert:
        return 2;
    case Model::BentGlass3:
    case Model::BentGlass:
        return 5;
    case Model::OrenNayar3:
    case Model::OrenNayar:
    case Model::Glossy3:
    case Model::Glossy:
    case Model::Velvet:
    case Model::Sheen:
    case Model::Refraction:
        return 3;
    case Model::Principled3:
        return 12;
    case Model::Subsurface:
        return 6;
    case Model::Principled3Subsurface:
        return 17;
    case Model::PrincipledSubsurface:
        return 20;
    case Model::Principled:
        return 14;
    case Model::PrincipledSheen:
        return 16;
    case Model::MetalF82:
    case Model::Conductor:
    case Model::Glass3:
    case Model::Glass:
    case Model::DiffuseToon:
    case Model::GlossyToon:
        return 4;
    case Model::HairOfColour:
    case Model::HairOfMelanin:
    case Model::HairOfAbsorption:
    case Model::HairReflection:
    case Model::HairTransmission:
        return hair_input_count(model);
    }
    return 0;
}

void validate(const LobeSource& source, const std::string& material_name) {
    const std::size_t of_model = input_count(source.model), count = of_model + (source.film ? film_input_count : 0);
    require(of_model > 0, "material \"", material_name, "\" has a model ", static_cast<int>(source.model),
            " of lobes, which this version does not know");
    require(source.constants.size() == count && source.registers.size() == count, "material \"", material_name,
            "\" has ", source.constants.size(), " inputs of lobes in place of ", count);
    for (const Rgb& input : source.constants)
        require(std::isfinite(input.x) && std::isfinite(input.y) && std::isfinite(input.z), "material \"",
                material_name, "\" has a value that is not finite");
    const bool has_subsurface = source.model == Model::Subsurface || source.model == Model::PrincipledSubsurface ||
                                source.model == Model::Principled3Subsurface;
    require(source.subsurface < SubsurfaceMethod::Count &&
                has_subsurface == (source.subsurface != SubsurfaceMethod::None),
            "material \"", material_name, "\" has a method ", static_cast<int>(source.subsurface),
            " of subsurface scattering, which its model ", static_cast<int>(source.model), " does not know");
    const bool has_choice = source.model == Model::Glossy3 || source.model == Model::Glossy ||
                            source.model == Model::MetalF82 || source.model == Model::Conductor ||
                            source.model == Model::Glass3 || source.model == Model::Glass;
    require(source.distribution < FacetDistribution::Count &&
                (source.distribution == FacetDistribution::Ggx || (has_choice && !source.preserves_energy)),
            "material \"", material_name, "\" has a distribution ", static_cast<int>(source.distribution),
            " of facets, which its model ", static_cast<int>(source.model), " does not know");
    require(!source.film || can_have_film(source.model), "material \"", material_name,
            "\" has a thin film, which its model ", static_cast<int>(source.model), " does not know");
    require(source.bump_shadowing < BumpShadowing::Count, "material \"", material_name, "\" has a shadowing of bumps ",
            static_cast<int>(source.bump_shadowing), ", which this version does not know");
}

std::vector<std::uint16_t> registers_of(const LobeSource& source) {
    std::vector<std::uint16_t> all = source.registers;
    all.insert(all.end(), {source.diffuse_normal, source.facet_normal, source.coat_normal, source.tangent});
    std::erase(all, LobeSource::no_register);
    return all;
}
} // namespace tyndall
