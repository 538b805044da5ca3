// SPDX-License-Identifier: GPL-3.0-or-later
// What Shafts keeps of a frame: its light samples, each with what casts their shadows; and how a block of rays asks them.
#pragma once
#include "light_shafts/lamp_inside.hpp"
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/media_ray.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "light_shafts/texture_rows.hpp"
#include "light_shafts/visibility.hpp"
#include <optional>

namespace tyndall::light_shafts {
/// One light sample, ready for rays.
struct Beam {
    LightSample sample;
    const DiscCell* cell = nullptr; ///< Of a lamp with something inside it.
    std::size_t share = 0;          ///< Into LightShares.
    std::unique_ptr<const Visibility> visibility;
    std::optional<DirectionalScatter> directional; ///< Or `local`: one of the two.
    std::optional<LocalScatter> local;

    void dim_by_grids(const GridLoss& loss) {
        if (directional)
            directional->dim_by_grids(loss);
        else
            local->dim_by_grids(loss);
    }
    [[nodiscard]] bool is_dimmed_by_grids(const ViewRay& ray) const {
        return directional ? directional->is_dimmed_by_grids(ray) : local->is_dimmed_by_grids(ray);
    }
    [[nodiscard]] ColumnBytes column_bytes() const {
        return directional ? directional->column_bytes() : local->column_bytes();
    }
};
struct LightBeams {
    std::size_t light; ///< Into Scene::lights; the world follows after the last one.
    std::vector<Beam> beams;
    std::size_t slot = 0;                                 ///< Into PreparedLights::slots.
    vec3 lamp_position{0.0f};                             ///< Of its middle, if it is one.
    std::shared_ptr<const TextureRows> texture_rows = {}; ///< Of a sun with a picture across it.
    std::vector<UnlitMedium> unlit_media = {};            ///< Of the light.
    std::optional<LampInside> inside = {};                ///< Of a lamp of several strata.
    /// Pixels that share its strata would blur edges or a picture that they have in common; of a lamp that is several
    /// pixels wide each stratum has its own, aside from the others'.
    bool has_pattern = false;
    std::size_t parts = 1;    ///< Consecutive beams that make a stratum: they light different points.
    float dealt_share = 1.0f; ///< As of ScatteringLight.
    [[nodiscard]] std::size_t stratum_count() const { return beams.size() / parts; }
};

/// The rays of a block with their media: found once, used by every light.
struct Block {
    std::vector<ViewRay> rays;         ///< Those that meet a medium, clipped to it.
    std::vector<std::uint32_t> target; ///< Their index in the caller's span.
    std::vector<float> length_m;
    std::vector<std::uint32_t> first_segment;
    std::vector<MediumSegment> segments, lit_segments; ///< The latter: while a light is asked that some are dark for.
    std::vector<Rgb> radiance, unshadowed; ///< Of one light; unshadowed: where those with a pattern are kept apart.
    std::vector<Rgb> all_radiance;         ///< Of all so far.
    std::vector<Rgb> patterned, all_unshadowed; ///< Of all with a pattern so far, where they are kept apart.
    std::vector<float> lit_length_m, visibility;
    PieceRows pieces;
    MediumSteps steps; ///< Where there are density grids.
    /// The rays among them that meet grids, or whose light may, asked about apart; and what that finds.
    struct InGrids {
        std::vector<ViewRay> rays;
        std::vector<std::uint32_t> row, first_segment;
        std::vector<MediumSegment> segments;
        LocalRays local;
        LitRows lit;
        std::vector<Rgb> radiance, unshadowed, radiance_of_all, unshadowed_of_all;
    } in_grids;
    LocalRays local; ///< The same for lights at points; empty until one asks.
    bool wants_visibility = false, keeps_patterned_apart = false;

    [[nodiscard]] std::span<const MediumSegment> segments_of(std::size_t ray) const {
        return std::span(segments).subspan(first_segment[ray], first_segment[ray + 1] - first_segment[ray]);
    }
};
struct PreparedLights {
    const Media& media;
    std::vector<LightBeams> lights;
    StepLimits step_limits = {};            ///< Among density grids.
    std::optional<GridLoss> grid_loss = {}; ///< Given with step_limits, or found with them where there are grids.
    bool tracks_ratios = false;             ///< See GridMethod.
    std::uint32_t seed = 0;
    std::vector<std::vector<DiscCell>> disc_cells = {}; ///< What samples point to.
    std::optional<std::uint32_t> visibility_light = {}; ///< See Config.
    const Visibility* finest = nullptr; ///< Of the sample that carries most light, and so has the largest rows.
    std::vector<std::uint8_t> slots = {no_light_group}; ///< See Shafts::slots.
    Statistics statistics;

    /// Makes the beams of `lights` for rays that are clipped to the media. Throws Cancelled.
    void prepare(const Scene& scene, const View& view, std::span<const ViewRay> clipped,
                 std::vector<ScatteringLight> lights_to_prepare, const Config& config, Progress& progress);
    /// How much the visibility of a light counts.
    [[nodiscard]] float visibility_share(const LightBeams& light) const {
        return visibility_light ? (light.light == *visibility_light ? 1.0f : 0.0f)
                                : 1.0f / static_cast<float>(lights.size());
    }
    void gather(std::span<const ViewRay> rays, std::span<const std::uint32_t> order, Block& block) const;
    void add(const LightBeams& light, std::size_t stratum, Block& block) const;
    void add(const LightBeams& light, const Turn& turn, Block& block) const;
    /// Of what LampInside says.
    void add_inside(const LightBeams& light, Block& block, std::span<Rgb> radiance, float share = 1.0f) const;
    /// Where there are density grids.
    void add_in_grids(const LightBeams& light, const Beam& beam, std::span<float> lit_length_m, Block& block) const;
    void gather_in_grids(const Beam& beam, Block& block) const;
    void track_in_grids(const Beam& beam, std::span<float> lit_length_m, Block& block) const;
    /// What the block's pieces scatter, of a directional light.
    static void add_pieces(const LightBeams& light, const Beam& beam, std::span<float> lit_length_m, Block& block);
    /// Of the lights that squares of shared_sides[side] pixels share; one result for all, or one per slot.
    void scatter_side(std::span<const ViewRay> rays, std::span<const std::uint8_t> cells,
                      std::span<const std::uint32_t> order, std::size_t side, std::span<const ScatteredBySide> by_slot,
                      const Progress& progress, const Turn& turn) const;
    /// What the segments of a block are to a light that some media are dark for; done again, they are as before.
    static void swap_unlit(std::span<const UnlitMedium> unlit, Block& block);
    /// Sums of no light yet.
    static void begin_sums(Block& block);
};

} // namespace tyndall::light_shafts
