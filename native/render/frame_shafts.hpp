// SPDX-License-Identifier: GPL-3.0-or-later
// The light shafts of a frame, pass by pass: prepared for the rays of the first, asked band by band, with what squares of
// neighbouring pixels share.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/frame_air.hpp"
#include "render/ray_parameters.hpp"
#include "render/sent_air.hpp"
#include "render/surface_pass.hpp"
#include <algorithm>
#include <array>
#include <functional>
#include <optional>

namespace tyndall::render {
/// Rows [first_row, end_row) of the region.
struct Band {
    std::uint32_t first_row, end_row;
};

/// Whether neighbouring pixels share strata.
[[nodiscard]] inline bool shares_strata(const light_shafts::Config& shafts) {
    return shafts.shares_strata && shafts.method != light_shafts::Method::Exact;
}

class FrameShafts {
public:
    struct Config {
        light_shafts::Config shafts;
        std::uint32_t round_samples = 1; ///< The strata of lights with a size are dealt out to so many passes.
        bool wants_visibility = false, wants_lit_moments = false;
        /// Of the first pass of the full frame, which the lights are prepared for; nothing: those that wait.
        const WaitingParts* of_frame = nullptr;
        FrameAir* air = nullptr;                   ///< Whose texture the light gets; must outlive this. None: even air.
        std::uint32_t pixel_samples = 1, seed = 0; ///< As FrameConfig's.
        std::uint32_t taken_samples = 1;           ///< Of these.
        const MeshEmitters* emitters = nullptr;    ///< What glows; must outlive this. None: nothing does.
        const PilotSamples* pilot = nullptr;       ///< What samples are like, if it glows.
        KeptLightTrees* kept_light_trees = nullptr;
        bool may_draw = false; ///< See drawn_shafts.hpp; needs emitters.
    };
    /// For the parts of the first pass. The references must outlive this; `waiting` may change between passes. Throws
    /// InvalidInput and Cancelled.
    FrameShafts(const Scene& scene, const Media& media, const Camera& camera, const Region& region,
                const WaitingParts& waiting, const Config& config, Statistics& statistics, Progress& progress);

    [[nodiscard]] const light_shafts::Shafts& prepared() const { return shafts_; }
    /// No light scatters in any medium.
    [[nodiscard]] bool is_empty() const { return shafts_.is_empty() && !glow_ && !drawn_; }
    /// As light_shafts::Shafts::slots, with those of what glows and is drawn.
    [[nodiscard]] std::span<const std::uint8_t> slots() const { return slots_; }
    /// Something that glows lights media.
    [[nodiscard]] bool has_glow() const { return glow_.has_value(); }
    /// Before the bands of a pass, whose parts wait now.
    void begin_pass(std::uint32_t sample_index, const Progress& progress);
    /// Asks for the light that the media scatter into the parts of a band; returns how many.
    std::size_t scatter(const Band& band, const Progress& progress);
    /// Hands out that light with what the neighbours of each pixel have found, which may be pixels of the next band.
    /// `deliver` is called from any thread, once per pixel; where light groups are kept apart, with what of the light is
    /// in each of slots().
    using Deliver = std::function<void(std::size_t pixel, const SeenShafts& seen, std::span<const Rgb> by_slot)>;
    void sum(const Band& band, const Deliver& deliver, const Progress& progress);

private:
    struct OfSide {
        std::vector<Rgb> radiance;
        std::vector<float> visibility;
        std::vector<Rgb> patterned, patterned_unshadowed; ///< Of what is shared.
    };
    using OfSides = std::array<OfSide, light_shafts::shared_sides.size()>;
    /// Into slots().
    [[nodiscard]] std::size_t slot_of(std::uint8_t group) const {
        return slots_.size() == 1 ? 0 : static_cast<std::size_t>(std::ranges::find(slots_, group) - slots_.begin());
    }
    void add_slots_of(std::span<const std::uint8_t> groups);
    /// Adds what glows, and lights that are drawn, to the light of a band.
    void add_draws(const Band& band, const Progress& progress);
    void add_draws_of(std::size_t part, std::uint32_t number, std::uint32_t seed);
    /// The slots' light, together.
    void add_slots(const Band& band);
    /// Of the parts of a pixel.
    [[nodiscard]] Rgb sum_of_slot(std::size_t slot, std::size_t first, std::size_t count) const;
    /// Of the parts of a band, whose light is known.
    void find_heterogeneity(const Band& band, const Progress& progress);
    [[nodiscard]] std::uint32_t width() const { return region_.x1 - region_.x0; }
    [[nodiscard]] std::size_t pixel_count() const { return std::size_t{region_.y1 - region_.y0} * width(); }
    void deal_cells(std::uint32_t round, const Progress& progress);

    const Media& media_;
    const Camera& camera_;
    const WaitingParts& waiting_;
    Region region_;
    Config config_;
    light_shafts::Shafts shafts_;
    std::optional<FogGlow> glow_;  ///< Nothing: nothing that glows lights media.
    std::optional<SentAir> drawn_; ///< Nothing: all lights have rows.
    std::uint32_t sample_index_ = 0;
    std::vector<std::uint8_t> slots_;
    light_shafts::Turn turn_{};
    std::vector<OfSides> of_slot_;    ///< One for all light, or one per slot; kept from pass to pass for their memory.
    OfSide of_all_;                   ///< Where there are several slots: their sum.
    std::vector<std::uint8_t> cells_; ///< Of the parts' pixels; empty: nothing is shared.
    std::vector<light_shafts::Air> air_;                ///< Per part, where something is shared.
    std::vector<light_shafts::LitMoments> lit_moments_; ///< Per part, where they are wanted.
    std::vector<float> heterogeneity_;                  ///< Per part, what its light is multiplied by; empty: nothing.
};
} // namespace tyndall::render
