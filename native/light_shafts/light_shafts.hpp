// SPDX-License-Identifier: GPL-3.0-or-later
// Single-scattered radiance along view rays: every light in every medium, over the lit intervals of each ray.
// Based on: Kol, dissertation, TU Delft 2018, chapter 5, section 5.3, eq. 5.1 (TVCG 23(7), 2017).
// Differs:  light is attenuated on its way to the scattering point (switchable: the paper leaves it out); visibility is
//           integrated exactly instead of factored out (5.2 is off by up to 3.2x at optical depth 3); rays that leave to
//           the sky are clipped to the medium.
#pragma once
#include "core/progress.hpp"
#include "core/statistics.hpp"
#include "light_shafts/rows_limit.hpp"
#include "scene/camera.hpp"
#include "scene/media.hpp"
#include "scene/scene.hpp"
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tyndall {
class AirTexture; // volume/air_texture.hpp
class MemoryRoom; // core/memory_room.hpp
} // namespace tyndall

namespace tyndall::light_shafts {
/// A part of a view ray in front of its surface. Rays of one call share the camera's position or its direction.
struct ViewRay {
    vec3 origin;         ///< Scene space, metres.
    vec3 direction;      ///< Unit.
    float near_m, far_m; ///< far may be infinite; clipped to the media.
};
/// What all view rays of a call have in common.
struct View {
    bool is_orthographic = false;
    vec3 position{0.0f};      ///< Perspective: all rays leave from here.
    vec3 direction{0, 0, -1}; ///< Orthographic: all rays go this way.
    float spacing = 0.0f;     ///< Between neighbouring pixels of a picture: radians, or metres of parallel rays.
};
[[nodiscard]] inline View view_of(const Camera& camera) {
    return {.is_orthographic = camera.kind == CameraKind::Orthographic,
            .position = camera.position(),
            .direction = camera.forward()};
}

class MapCache;   // map_cache.hpp
class KeptStrata; // strata_counts.hpp

enum class Method : std::uint8_t { Exact = 0, Epipolar = 1, ShadowMap = 2 };
/// How rays that meet density grids, or whose light passes through some, are integrated.
enum class GridMethod : std::uint8_t {
    March = 0,         ///< Steps and light-side depths as fine as the error target asks for.
    RatioTracking = 1, ///< Without bias, with noise.
};

/// Which of several pictures whose mean is shown this is: the strata of lights are dealt out to them, see dealt_strata.hpp.
struct SeriesPart {
    std::uint32_t first = 0, end = 1, samples = 1; ///< It has the samples from `first` to before `end` of all of them.
    std::uint32_t pictures = 1;                    ///< How many there are; fewer if some are taken together.
    /// Seen from a place where no other is seen from: the errors of their rows average out, as those of strata do.
    bool has_own_view = false;
    [[nodiscard]] bool is_whole() const { return end - first == samples; }
};

struct Config {
    Method method = Method::Epipolar;
    float error_target =
        0.002f; ///< Relative RMS error of the frame that EPIPOLAR picks its resolution by, [1e-5, 0.1].
    std::uint32_t resolution = 0; ///< Rows' and map's texels per side, [16, 16384]; 0: from error_target.
    /// Strata of a light with a size, [1, 65536]; one without has one. The errors of n strata average out: each is
    /// prepared with sqrt(n) times the error target, or the resolution divided by sqrt(n), which keeps the sum of all
    /// rows as small as those of one light.
    std::uint32_t light_samples = 16;
    std::uint32_t world_samples = 64; ///< Directions of the world's light, [0, 65536]; 0: it does not scatter.
    bool attenuates_light = true;     ///< False: eq. 5.1 as printed, no loss between light and scattering point.
    /// light_samples and world_samples are the most: each light takes as many as the error target asks for, see
    /// strata_counts.hpp.
    bool adapts_strata = false;
    /// Neighbouring pixels share the strata of lights that have more of them than a pixel has samples; never with EXACT.
    bool shares_strata = true;
    /// Into Scene::lights: the visibility that is told is this light's; none: the mean over all lights.
    std::optional<std::uint32_t> visibility_light = {};
    GridMethod grid_method = GridMethod::March;
    float grid_error_target = 0.005f; ///< Relative RMS error of what grids scatter, over the frame, [1e-4, 0.3].
    /// Rays too close to a light's direction for rows are walked along the map that SHADOW_MAP's rows come from, instead of
    /// asked of hierarchies for cuts, which take 0.5 us per triangle to build: for a coarse picture that is to come at once.
    /// A sun's map then stays where it is in the scene, and serves pictures of a camera that moves, see kept_maps.
    bool walks_maps = false;
    /// Lights whose rows would take longer are left to somebody else, who draws them at random: see Shafts::left().
    RowsLimit rows_limit = {};
    bool keeps_groups_apart = false; ///< Light groups have slots of their own, see Shafts::slots.
    std::uint32_t seed = 0;
    SeriesPart part = {};
    /// What the first picture of a series has found for all, and holds for the others; nothing: each finds its own.
    std::shared_ptr<KeptStrata> kept_strata = {};
    std::shared_ptr<MapCache> kept_maps = {}; ///< Maps and rows of other frames; nothing: none are kept.
    std::shared_ptr<MemoryRoom> room = {};    ///< For maps and rows; nothing: they take what they need.
};

struct Result {
    std::vector<Rgb> radiance;             ///< Per ray, W/(m^2 sr): in-scattered, attenuated to the camera.
    std::vector<float> average_visibility; ///< Per ray, [0, 1]: lit share of its length in media.
    Statistics statistics;
};

/// Which of several passes over the same pixels this is. The strata of a light with a size are dealt out to the passes,
/// so that the mean over all of them has every stratum, at the price of one pass: rays of a pixel differ little.
struct Turn {
    std::uint32_t index = 0, count = 1;
};

/// Where scatter() puts its results, per ray; no visibility where that span is empty.
struct Scattered {
    std::span<Rgb> radiance; ///< As in Result.
    std::span<float> average_visibility;
    /// What lamps with a cone or a picture scatter, apart from `radiance`, and what they would if nothing cast a shadow; both
    /// empty: it is in `radiance`. Not of lamps whose size spreads them, see LightBeams::has_pattern.
    std::span<Rgb> patterned, patterned_unshadowed;
};
struct ConstScattered {
    std::span<const Rgb> radiance;
    std::span<const float> average_visibility;
    std::span<const Rgb> patterned, patterned_unshadowed;
};
/// The media along a ray: where they begin and end, and how much of what lies behind they hide, 1 - exp(-optical depth),
/// mean over the channels; 0 where there are none.
struct Air {
    float near_m, far_m, opacity;
};
/// Sides of the squares of pixels that share the strata of a light, see shared_strata.hpp; 1: each pixel for itself.
inline constexpr std::array<std::uint32_t, 3> shared_sides{1, 2, 4};
using ScatteredBySide = std::array<Scattered, shared_sides.size()>;

/// Where a ray is lit: the length of its lit parts in media, weighted by the shadows' transmittance, and the integral of
/// the distance over them; sums over the lights.
struct LitMoments {
    float length_m = 0.0f, moment_m2 = 0.0f;
};

/// Of a ray whose air has a texture that nothing shows.
inline constexpr float dark_air = -1.0f;

struct PreparedLights;
class PictureAir; // picture_air.hpp

/// One frame's light shafts, prepared once and asked band by band, pass by pass: what a light needs (its hierarchy or
/// its slope rows) is built by the constructor. Immutable after that; safe from any thread.
class Shafts {
public:
    /// `rays`: those of the first pass; EPIPOLAR and SHADOW_MAP lay their rows out for them, and answer others of the
    /// same view by EXACT where the rows do not reach. `scene` and `media` must outlive this. Throws InvalidInput and
    /// Cancelled.
    Shafts(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays,
           const Config& config, Progress& progress);
    Shafts(const Shafts&) = delete;
    Shafts& operator=(const Shafts&) = delete;
    ~Shafts();

    /// By Config::rows_limit.
    [[nodiscard]] const LeftLights& left() const { return left_; }
    /// No light scatters in any medium: scatter() would answer 0, and need not be called.
    [[nodiscard]] bool is_empty() const;
    /// Overwrites, per ray, the radiance (as in Result) and the average visibility, unless its span is empty.
    void scatter(std::span<const ViewRay> rays, std::span<Rgb> radiance, std::span<float> average_visibility,
                 const Progress& progress, Turn turn = {}) const;
    /// The same where neighbouring pixels share strata: `cells` has the cell_of_pixel of each ray, or alone_cell, and
    /// out[i] gets the light that squares of shared_sides[i] pixels share, still to be averaged by add_shared.
    void scatter(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells, const ScatteredBySide& out,
                 const Progress& progress, Turn turn) const;
    /// The same with the light of each slot by itself: one result per slot.
    void scatter(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                 std::span<const ScatteredBySide> by_slot, const Progress& progress, Turn turn) const;
    /// Light groups whose lights scatter, each once, no_light_group for the others; one entry where none is kept apart.
    [[nodiscard]] std::span<const std::uint8_t> slots() const;
    /// One per ray, of the strata of this turn.
    [[nodiscard]] std::vector<LitMoments> find_lit_moments(std::span<const ViewRay> rays, const Progress& progress,
                                                           Turn turn = {}) const;
    /// The texture of the air along each ray: what its light is to be multiplied by, or dark_air where no light, or none of
    /// this turn's strata, reaches it. By up to a few of a light's strata.
    [[nodiscard]] std::vector<float> find_heterogeneity(std::span<const ViewRay> rays, const AirTexture& air,
                                                        const Progress& progress, Turn turn = {}) const;
    /// The same, of those rays that have dark_air; the others keep what they have. `picture`: of their camera, if there is
    /// one. Returns how many are dark still.
    std::size_t find_heterogeneity(std::span<const ViewRay> rays, const AirTexture& air, std::span<float> heterogeneity,
                                   const Progress& progress, Turn turn, const PictureAir* picture = nullptr) const;
    /// How the rays of a picture are best asked together in a turn; nothing where they are better asked one by one. All
    /// must outlive the result.
    [[nodiscard]] std::shared_ptr<const PictureAir> picture_air(const Camera& camera, const AirTexture& air,
                                                                Turn turn) const;
    /// One per ray.
    [[nodiscard]] std::vector<Air> find_air(std::span<const ViewRay> rays, const Progress& progress) const;
    /// Gives alone_cell to the rays that pass a lamp whose strata are shared at less than a few times the view's spacing:
    /// its light changes from one to the next.
    void set_alone(std::span<const ViewRay> rays, const View& view, std::uint32_t turn_count,
                   std::span<std::uint8_t> cells, const Progress& progress) const;
    /// Whether out[i] of shared_sides gets any light when a picture has turn_count passes.
    [[nodiscard]] std::array<bool, shared_sides.size()> sides_used(std::uint32_t turn_count) const;
    /// Of the preparation: what was built, which lights were skipped and why.
    [[nodiscard]] const Statistics& statistics() const;

private:
    std::unique_ptr<PreparedLights> prepared_;
    LeftLights left_;
};

/// Prepares and scatters in one call. Throws InvalidInput and Cancelled. The result's bits do not depend on the number
/// of threads.
[[nodiscard]] Result run(const Scene& scene, const View& view, std::span<const ViewRay> rays, const Config& config,
                         Progress& progress);
} // namespace tyndall::light_shafts
