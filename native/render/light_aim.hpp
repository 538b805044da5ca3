// SPDX-License-Identifier: GPL-3.0-or-later
// Where on a light the shadow rays of neighbouring points go, and what arrives if nothing stands between: 16 points at
// a time. The same strata as scene/light.hpp's sample_light_towards.
// Bound:    with AVX-512 6 ns per point, random numbers included (AVX2 9, SSE4 18); a light that reaches none of the
//           points 0.5 ns.
#pragma once
#include "scene/area_light.hpp"
#include "scene/spawn_offset.hpp"
#include <array>

namespace tyndall::render {
/// A number of each of up to 16 points.
inline constexpr std::size_t lane_count = 16;
struct alignas(64) Lanes : std::array<float, lane_count> {};
struct Lanes3 {
    Lanes x, y, z;
    void set(std::size_t lane, const vec3& value) { x[lane] = value.x, y[lane] = value.y, z[lane] = value.z; }
    [[nodiscard]] vec3 get(std::size_t lane) const { return {x[lane], y[lane], z[lane]}; }
};
/// A bit per lane.
using LaneSet = std::uint32_t;

struct LitPoints {
    Lanes3 position{}, shading_normal{};
    Lanes3 spawn_position{}, spawn_normal{};
    Lanes spawn_offset_m{};
    std::array<std::uint32_t, lane_count> pixel_seeds{}; ///< Of the pixels whose random numbers the points take.
    LaneSet present = 0;

    void set(std::size_t lane, const vec3& at, const vec3& normal, const SpawnPoint& spawn, std::uint32_t pixel_seed);
};

struct AimedRays {
    Lanes3 origin, direction;
    Lanes far_m;  ///< Infinite towards a sun.
    Lanes weight; ///< Irradiance per strength of the light: cosine at the surface, falloff; without a spot's cone.
};

/// A pair of random numbers of each point, PixelSamples'.
struct PairIndex {
    std::uint32_t sample_index, pair_index;
};

/// One light, made ready.
class LightAim {
public:
    explicit LightAim(const Light& light);
    [[nodiscard]] bool has_size() const { return has_size_; }

    /// Points at which light may arrive: not those before which the whole light stands below the horizon, or shines past.
    [[nodiscard]] LaneSet may_light(const LitPoints& points) const;
    /// A stratum for each point; returns those at which it may arrive. A light without a size takes no random numbers.
    [[nodiscard]] LaneSet aim(const LitPoints& points, const PairIndex& pair, AimedRays& rays) const;

    /// Directions towards the world, with a density of cosine / pi around the shading normals; weight: the cosine. Returns
    /// those above the horizon.
    [[nodiscard]] static LaneSet aim_at_world(const LitPoints& points, const PairIndex& pair, AimedRays& rays);

    struct Form {
        enum class Kind : std::uint8_t { SunCone, SunDisc, Sphere, FacingDisc, Area } kind;
        bool is_spot;
        vec3 position, towards_light;
        float radius_m;       ///< Local.
        float cone;           ///< Sun: 1 - cos of its half angle; its tangent, of a disc.
        float weight;         ///< Sun: that each stratum has.
        float margin;         ///< Sine of a sun's half angle, or the radius, with what rounding may add.
        mat3 cone_from_world; ///< Into a space where the spot's axis is -Z and its cone round.
        float cone_radius;    ///< Of the sphere around the light there.
        float cos_half, sin_half;
        mat3 area_axes;    ///< Area: along its sides, and against its beam.
        vec2 half_size_m;  ///< Area.
        float per_area_m2; ///< Area.
        AreaSpread spread; ///< Area.
        bool is_ellipse;   ///< Area.
    };
    [[nodiscard]] const Form& form() const { return form_; }

private:
    Form form_;
    bool has_size_;
};
} // namespace tyndall::render
