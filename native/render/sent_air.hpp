// SPDX-License-Identifier: GPL-3.0-or-later
// Light that media scatter into rays from mirrors and glass: a draw for lamps, suns, the world and what glows, each. Into
// those of the camera, too, where light shafts would take too long (drawn_shafts.hpp).
// Based on: next event estimation; Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating
//           Media, EGSR 2012: glow_distances.hpp for lamps, phase_directions.hpp for what is far. The world's image by
//           multiple importance sampling (Veach 1997, section 9.2) with the phase function.
// Differs:  from the light shafts that cameras see, which have no noise: their rows and maps are laid out for rays from
//           one place. Edits of occluders, transfer functions and the air's texture do not show here.
// Data flow: part of a ray -> its pieces in media, once (media_line.hpp) -> per draw: light, distance, place, one shadow
//           ray -> radiance, by light groups.
// Bound:    1 us a draw in a fog box, and its shadow ray. Nothing is made where no ray is sent on, or nothing scatters.
#pragma once
#include "render/fog_glow.hpp"
#include <optional>

namespace tyndall::render {
class SentAir {
public:
    struct Config {
        bool attenuates_light = true, world_scatters = true;     ///< As light_shafts::Config's.
        bool has_lamps = true, has_suns = true, has_glow = true; ///< Whose light is wanted.
    };
    /// The references must outlive this.
    SentAir(const Scene& scene, const Media& media, const MeshEmitters& emitters, const Config& config,
            KeptLightTrees* kept = nullptr);

    /// No light scatters in any medium.
    [[nodiscard]] bool is_empty() const { return lamps_.empty() && suns_.empty() && !has_world_ && !has_glow(); }
    /// Of the lamps, suns and the world that are drawn, each once.
    [[nodiscard]] std::vector<std::uint8_t> light_groups() const;
    /// Appends what the media scatter into a part of a ray, by one draw of each kind of light: right in the mean.
    void draw(const light_shafts::ViewRay& part, const FogGlow::Numbers& numbers,
              std::vector<FogGlow::Found>& found) const;
    /// The same of its pieces, which it has.
    void draw(const MediaLine& line, const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) const;

private:
    [[nodiscard]] bool has_glow() const { return glow_.has_value() && !glow_->is_empty(); }
    void draw_lamp(const MediaLine& line, const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) const;
    void draw_sun(const MediaLine& line, const PhaseDirections& along, const FogGlow::Numbers& numbers,
                  std::vector<FogGlow::Found>& found) const;
    void draw_world(const MediaLine& line, const PhaseDirections& along, const FogGlow::Numbers& numbers,
                    std::vector<FogGlow::Found>& found) const;
    /// A place on the line that was drawn with this density.
    struct Place {
        const MediaLine::Piece& piece;
        float at_m, density_per_m;
    };
    /// Of irradiance from a direction, which comes `far_m` without what lies between.
    [[nodiscard]] Rgb scattered(const MediaLine& line, const Place& place, const Light& light,
                                const vec3& towards_light, float far_m, const Rgb& irradiance) const;
    /// Of the world's light from a direction.
    [[nodiscard]] Rgb scattered_of_world(const MediaLine& line, const Place& place, const vec3& direction,
                                         const Rgb& radiance) const;

    const Scene& scene_;
    const Media& media_;
    Config config_;
    std::optional<FogGlow> glow_;             ///< Where it is wanted.
    std::vector<std::uint32_t> lamps_, suns_; ///< Into Scene::lights.
    std::shared_ptr<const LightTree> tree_;   ///< Of the lamps.
    std::vector<float> sun_shares_;           ///< Of each sun and those before it, of all their light.
    bool has_world_;
};
} // namespace tyndall::render
