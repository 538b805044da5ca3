// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface does with light, at one point: the interface that the node compiler of later work fills.
#pragma once
#include "core/math.hpp"
#include "image/texture.hpp"
#include "shading/light_links.hpp"
#include "shading/lobes/lobe_source.hpp"
#include "shading/surface_op.hpp"
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tyndall {
/// What an object is by itself: what a node program may ask, and how light meets it.
struct ObjectInfo {
    vec4 color{1.0f};
    float pass_index = 0.0f;
    std::uint8_t light_group = no_light_group;      ///< Of what it emits.
    std::uint8_t receiver_set = 0, blocker_set = 0; ///< See LightLinks.
    LightLinks links = {};                          ///< Of what it emits.
    bool operator==(const ObjectInfo&) const = default;
};

/// Where a shading point lies: what light on it asks. Programs read more, see program_point.hpp.
struct ShadingPoint {
    vec3 position{0.0f};
    vec3 geometric_normal{0, 0, 1};
    vec3 shading_normal{0, 0, 1}; ///< On the side of the ray.
    std::uint32_t mesh_index = 0, triangle = 0;
    vec2 barycentrics{0.0f};
    bool is_backface = false;
    bool is_smooth = false;   ///< Of a mesh whose corners have normals.
    float view_cosine = 1.0f; ///< Between the shading normal and the way back along the ray, [0, 1].
    Rgb tint{1.0f};           ///< Multiplies colours: those of voxels.
};

/// Closures of one point, its lobes aside. Weights already carry mix factors; diffuse + transparent need not add up to 1.
struct SurfaceClosures {
    Rgb diffuse_albedo{0.0f};
    Rgb transparent{0.0f}; ///< Share that passes straight through.
    Rgb emission{0.0f};    ///< Radiance.
    Rgb mirrored{0.0f};    ///< Share of what comes along the mirrored ray, at the point's view_cosine.
    Rgb translucent{0.0f}; ///< Diffuse albedo for light on the other side.
    float held_out = 0.0f; ///< Share that is cut out of what cameras see: neither light nor cover.
};

/// What mirrors, beside the rest of a surface. Weights already carry mix factors.
struct Gloss {
    Rgb facing{0.0f}, edge{0.0f}; ///< Share that is mirrored where the surface is seen straight, and grazing.
    Rgb coat{0.0f};               ///< Weight of a clear layer, which mirrors by Fresnel's equations.
    Rgb coated{0.0f};             ///< Diffuse albedo below that layer, in the light that it lets in.
    bool operator==(const Gloss&) const = default;
};
struct GlossLayers {
    Gloss constant = {}; ///< Of a material without a program.
    std::uint16_t facing_register = 0, edge_register = 0, coat_register = 0, coated_register = 0;
    float mirror_ior = 0.0f; ///< By which `facing` rises to `edge`: 0, or at least 1, see fresnel_rise.
    float coat_ior = 1.5f;   ///< Of the clear layer, at least 1.
    bool operator==(const GlossLayers&) const = default;
};

struct Material {
    std::string name;
    std::vector<SurfaceOp> program = {}; ///< Empty: the three results below are constants of `constant`.
    std::uint16_t diffuse_register = 0, transparent_register = 0, emission_register = 0;
    std::optional<std::uint16_t> held_out_register = {}; ///< Of a program; nothing: it holds out nothing.
    SurfaceClosures constant{.diffuse_albedo = Rgb(0.8f), .transparent = Rgb(0.0f), .emission = Rgb(0.0f)};
    std::vector<std::shared_ptr<const Texture>> textures = {};
    std::vector<std::string> uv_map_names = {}; ///< An empty name: the active one.
    std::vector<ColorTable> tables = {};
    std::optional<GlossLayers> gloss = {};     ///< Nothing: it mirrors nothing.
    std::vector<LobeSource> lobe_sources = {}; ///< What it does beside the results above.
    std::int32_t medium_index = -1; ///< Into SceneDescription::media: the medium inside the closed mesh; -1: none.
    bool has_surface = true;        ///< False: no surface shader; light and view pass (a fog box).

    [[nodiscard]] bool is_constant() const { return program.empty(); }
};
} // namespace tyndall
