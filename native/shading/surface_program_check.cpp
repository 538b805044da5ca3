// SPDX-License-Identifier: GPL-3.0-or-later
// What of a surface program would read beyond what it has, or is no number: refused before it runs.
#include "core/errors.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/op_photometry.hpp"
#include "shading/surface_program.hpp"
#include <cmath>
#include <limits>

namespace tyndall {
static bool is_finite(const Rgb& value) {
    return std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z);
}

void validate(const Material& material) {
    const auto check_register = [&](std::uint16_t index) {
        require(index < surface_register_count, "material \"", material.name, "\" uses register ", index, " of ",
                surface_register_count);
    };
    for (const std::uint16_t index : {material.diffuse_register, material.transparent_register,
                                      material.emission_register, material.held_out_register.value_or(0)})
        check_register(index);
    const SurfaceClosures& constant = material.constant;
    require(is_finite(constant.diffuse_albedo) && is_finite(constant.transparent) && is_finite(constant.emission) &&
                std::isfinite(constant.held_out),
            "material \"", material.name, "\" has a colour that is not finite");
    if (material.gloss) {
        const GlossLayers& gloss = *material.gloss;
        for (const std::uint16_t index :
             {gloss.facing_register, gloss.edge_register, gloss.coat_register, gloss.coated_register})
            check_register(index);
        const Gloss& fixed = gloss.constant;
        require(is_finite(fixed.facing) && is_finite(fixed.edge) && is_finite(fixed.coat) && is_finite(fixed.coated),
                "material \"", material.name, "\" has a colour that is not finite");
        require(gloss.mirror_ior == 0.0f || (gloss.mirror_ior >= 1.0f && gloss.mirror_ior <= 1e3f), "material \"",
                material.name, "\" has a mirror_ior of ", gloss.mirror_ior, ", neither 0 nor in [1, 1000]");
        require_in(gloss.coat_ior, 1.0f, 1e3f, "coat_ior");
    }
    for (const LobeSource& source : material.lobe_sources) {
        validate(source, material.name);
        for (const std::uint16_t index : registers_of(source)) {
            check_register(index);
            require(!material.program.empty(), "material \"", material.name, "\" has no program for its lobes");
        }
    }
    for (const SurfaceOp& op : material.program) {
        const std::optional<OpFacts> facts = facts_of(op);
        require(facts.has_value(), "material \"", material.name, "\" has an operation ", static_cast<int>(op.code),
                ", which this version does not know");
        for (const std::uint16_t index : {op.out, op.a, op.b, op.c, op.d, op.e, op.f})
            check_register(index);
        require(is_finite(op.value), "material \"", material.name, "\" has a value that is not finite");
        require((facts->reads & OpReads::image) == 0 ||
                    (op.texture < material.textures.size() && material.textures[op.texture] != nullptr),
                "material \"", material.name, "\" reads texture ", op.texture, " of ", material.textures.size());
        require((facts->reads & OpReads::uv_map) == 0 || op.texture_uv < material.uv_map_names.size(), "material \"",
                material.name, "\" reads UV map ", op.texture_uv, " of ", material.uv_map_names.size());
        require((facts->reads & OpReads::table) == 0 ||
                    (op.table < material.tables.size() && !material.tables[op.table].values.empty()),
                "material \"", material.name, "\" reads table ", op.table, " of ", material.tables.size());
        require(op.code != SurfaceOp::Code::Photometry || is_photometry(material.tables[op.table].values),
                "material \"", material.name, "\" reads table ", op.table, " as a luminaire's, which it is not");
        if ((facts->reads & OpReads::table) != 0 && (facts->reads & OpReads::image) != 0)
            for (const vec4& tile : material.tables[op.table].values)
                require(tile.z >= 0.0f && tile.z < static_cast<float>(material.textures.size()) &&
                            material.textures[static_cast<std::size_t>(tile.z)] != nullptr,
                        "material \"", material.name, "\" reads texture ", tile.z, " of ", material.textures.size(),
                        " in a tile");
    }
    require(material.program.size() <= std::numeric_limits<std::uint16_t>::max(), "material \"", material.name,
            "\" has ", material.program.size(), " operations");
    for (const ColorTable& table : material.tables)
        for (const vec4& value : table.values)
            require(is_finite(vec3(value)) && std::isfinite(value.w), "material \"", material.name,
                    "\" has a table that is not finite");
}
} // namespace tyndall
