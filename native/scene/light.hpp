// SPDX-License-Identifier: GPL-3.0-or-later
// Lights with Blender's units, already converted to radiometric ones by the sync; positions are in the scene's space.
#pragma once
#include "core/math.hpp"
#include "scene/lit_kinds.hpp"
#include "scene/occluder_edit.hpp"
#include "shading/light_links.hpp"
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tyndall {
struct LightTexture;
enum class LightKind : std::uint8_t { Sun = 0, Point = 1, Spot = 2, Area = 3 };

/// How a spot fades between its inner and outer cone: the running Blender's Cycles decides.
enum class SpotFalloff : std::uint8_t {
    Blender3 = 0, ///< Up to 3.x, see light.cpp.
    Blender4 = 1, ///< From 4.0 on.
};
/// How a light with a size emits. Point and spot: as a sphere, or as a disc that faces each receiver (3.x; "Soft Falloff"
/// from 4.2 on, which is the default there). Sun: evenly over its cone, or over a flat disc at unit distance (3.x).
enum class LightBody : std::uint8_t { FacingDisc = 0, Sphere = 1 };

/// Of a light.
struct UnlitMedium {
    std::uint16_t medium = 0; ///< Into SceneDescription::media.
    std::uint16_t dark = 0;   ///< Likewise: takes away as much light on its way, and scatters none.
    bool operator==(const UnlitMedium&) const = default;
};

struct Light {
    std::string name;
    LightKind kind = LightKind::Sun;
    /// Sun: irradiance on a plane that faces its centre, W/m^2: Blender's strength from 4.0 on, and up to 3.x
    /// 2 cos / (1 + cos) of it. Point, spot: radiant intensity, W/sr: Blender's watts / (4 pi). Area: intensity along
    /// its axis of one that spreads over 180 degrees, W/sr: its radiance times its area, a pi-th of what it sends.
    Rgb strength{1.0f};
    vec3 position{0.0f};              ///< Point, spot, area: its middle.
    vec3 towards_light{0, 0, 1};      ///< Sun: unit vector to its centre.
    vec3 spot_axis{0, 0, -1};         ///< Spot, area: unit vector along which it shines.
    float half_angle_rad = 0.0f;      ///< Sun: angular radius, [0, pi/2].
    float radius_m = 0.0f;            ///< Point, spot: [0, 1e6].
    float spot_half_angle_rad = 0.7f; ///< Spot: half of Blender's cone angle. Area: half of its spread, [0, pi/2].
    float spot_blend = 0.0f;          ///< Spot: [0, 1].
    SpotFalloff spot_falloff = SpotFalloff::Blender4;
    LightBody body = LightBody::Sphere;
    vec2 half_size_m{0.0f};  ///< Area: along the first two of its light_axes, [0, 1e6]; > 0 in is_usable lights.
    bool is_ellipse = false; ///< Area: an ellipse with these half axes, else a rectangle.
    mat3 light_from_world_directions{1.0f}; ///< Spot: rotation and scale that Cycles 4 applies before the cone test.
    bool casts_shadow = true;
    LitKinds lights_surfaces = {};
    bool lights_catchers = true; ///< It shines on shadow catchers without all that stands on them, too.
    bool scatters_in_media = true;
    std::vector<OccluderEdit> occluder_edits = {};    ///< In the order in which they are made.
    std::shared_ptr<const LightTexture> texture = {}; ///< Colours its beam; nothing: white.
    LightLinks links = {};
    /// Media in which it scatters nothing; not those of density grids.
    std::vector<UnlitMedium> unlit_media = {};
    std::uint8_t light_group = no_light_group;
    bool is_camera_visible = false; ///< Cycles 4 draws lights with a size where the artist enables camera rays.

    /// To Cycles, fog is a shadow as well.
    [[nodiscard]] bool is_dimmed_by_media() const { return casts_shadow; }
};

/// Whether two lights give surfaces the same light: names, media, and edits that surfaces do not see do not count.
[[nodiscard]] bool lights_surfaces_alike(const Light& a, const Light& b);

/// Points whose direction from the apex lies between planes through it.
struct DirectionCell {
    vec3 apex{0.0f};
    std::array<vec3, 4> inwards{}; ///< Normals of the planes; those that are zero do not count.
};

/// A light without a size: one stratum of a Light. The mean over the strata of one light is the light.
struct LightSample {
    bool is_directional = true;
    vec3 towards_light{0, 0, 1}; ///< Directional: unit vector to the light.
    vec3 position{0.0f};         ///< Local: where it stands.
    Rgb strength{1.0f};          ///< Irradiance, W/m^2, or intensity, W/sr, before shaping; its share of the light.
    vec3 emission_normal{0.0f};  ///< Local: intensity falls with max(0, cos) around it; zero vector: isotropic.
    /// Local: from position to where the inverse square is measured from, and what is added to the squared distance. Of
    /// a patch of an area light also to the square of how far a point lies before it: see view_local.
    vec3 falloff_offset{0.0f};
    float softening_m2 = 0.0f;
    float sphere_radius_m = 0.0f; ///< Local: of the sphere of which it is a softened patch; 0: it is none.
    /// Local: a patch of a disc that turns to each point. Inverse square times the cosine at the patch:
    /// D / (D^2 + softening)^1.5 for a point at distance D from position + falloff_offset.
    bool faces_receivers = false;
    const DirectionCell* cell = nullptr; ///< Local: other points it does not light; must outlive the sample.
    /// Local: shaped by this spot's cone, or by this area light's lobe, of which emission_normal is the axis. The light
    /// must outlive the sample.
    const Light* spot = nullptr;
    const Light* textured = nullptr; ///< Its texture colours this light, too; the light must outlive the sample.
    std::uint32_t light_index = 0;   ///< Into Scene::lights; lights of the world follow after the last one.
    bool casts_shadow = true;
    bool is_dimmed_by_media = true; ///< On its way to where it is scattered.
};

/// Spot attenuation towards a unit direction that leaves the light, [0, 1]; 1 for other kinds. Follows light.spot_falloff.
[[nodiscard]] float spot_attenuation(const Light& light, const vec3& from_light);
/// Intensity of a local sample towards a unit direction that leaves it, W/sr: strength, cosine lobe, spot and spread
/// together.
[[nodiscard]] Rgb intensity_w_per_sr(const LightSample& sample, const vec3& from_light);
/// Irradiance per intensity, 1/m^2, that a local sample gives a point that faces it: the inverse square of its distance
/// to position + falloff_offset, softened. Its cell is for those who ask to know.
[[nodiscard]] float irradiance_per_intensity(const LightSample& sample, const vec3& point);
/// The stratum of `light` at `u` in [0, 1)^3; its strength is that of the whole light. A light of size 0 ignores u; the
/// third number is the depth of a stratum of a facing disc: strata that tie it to the others lean to one side.
[[nodiscard]] LightSample sample_light(const Light& light, std::uint32_t light_index, const vec3& u);
/// The same for one receiver: exact at any distance, and without strata that face away. Outside a sphere only; a
/// receiver inside it gets a sample of the centre. One to which an area light cannot shine gets a strength of 0.
[[nodiscard]] LightSample sample_light_towards(const Light& light, std::uint32_t light_index, vec2 u,
                                               const vec3& receiver);
} // namespace tyndall
