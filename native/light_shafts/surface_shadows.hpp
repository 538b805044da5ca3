// SPDX-License-Identifier: GPL-3.0-or-later
// Shadows that the edits of a light's occluders cast on surfaces, too: of holes that are filled, of silhouettes that are
// drawn out. Floor and air then agree.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1, where surfaces look up the edited shadow map.
// Differs:  the map only tells where an edit has put something nearer to the light than what stood there. All else is for
//           shadow rays, and so an edit that changes nothing changes no bit, and no texel shows where nothing was edited.
//           No surface shadows itself: a point is dark where it lies behind what was put there by more than
//           size (1/4 + tan(angle of incidence)). By size times tan a plane that is drawn out rises above itself, and a
//           crease of two planes is filled above either; shallow pits stay lit. Of a light with a size, a ray goes by the
//           stratum that is nearest to where it ends.
// Bound:    per stratum of the light one map, and rows if an edit needs the camera; one look-up per point.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/shadow_map.hpp"
#include <memory>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
struct Occluders;
struct RaySpan;

class SurfaceShadows {
public:
    struct Config {
        std::uint32_t lines = 2048; ///< Texels of a whole light's map along its longer side, and lines of its rows.
        std::uint32_t strata = 16;  ///< Of a light with a size: [1, 64].
        std::uint32_t seed = 0;
        bool operator==(const Config&) const = default;
    };
    /// Of a frame: as fine as its pixels where the artist does not say how fine maps are.
    [[nodiscard]] static Config config_of(const Camera& camera, const light_shafts::Config& config);
    /// Whether an edit of the light puts something before surfaces.
    [[nodiscard]] static bool are_cast_by(const Light& light);
    /// What the frame shows of surfaces, in rays along a grid: maps and rows are laid out for them.
    [[nodiscard]] static std::vector<RaySpan> outline_of(const Scene& scene, const Camera& camera,
                                                         const Progress& progress);

    /// For a light that casts shadows. Reports which edits show nothing, and why. Throws Cancelled.
    SurfaceShadows(const Scene& scene, const Occluders& occluders, std::uint32_t light_index, const View& view,
                   std::span<const RaySpan> outline, const Config& config, Statistics& statistics,
                   const Progress& progress);

    /// Whether an edit stands between a point and the place of the light that a ray from it goes to. `normal`: the
    /// surface's own, of either side.
    [[nodiscard]] bool is_dark(const vec3& point, const vec3& normal, const Ray& to_light) const;

private:
    struct Stratum {
        vec3 place{0.0f};                       ///< Unit vector towards a sun; where a lamp stands.
        ShadowMap map;                          ///< What edits have put there; no_occluder elsewhere.
        std::unique_ptr<slope_rows::Rows> rows; ///< The same; nothing: no edit needs the camera.
    };
    [[nodiscard]] const Stratum& nearest_stratum(const Ray& to_light) const;

    bool is_sun_;
    float reach_ = 0.0f, one_sided_reach_ = 0.0f; ///< See OccluderEdits.
    std::vector<Stratum> strata_;
};
} // namespace tyndall::light_shafts
