// SPDX-License-Identifier: GPL-3.0-or-later
// The surfaces of a frame, pass by pass: what camera rays meet, lit by the scene's lights; or what is kept of it.
#pragma once
#include "render/frame.hpp"
#include "render/kept_surfaces.hpp"
#include "render/moved_view.hpp"
#include "render/sent_air.hpp"
#include <optional>

namespace tyndall::render {
class FrameSurfaces {
public:
    /// The references must outlive this; reports to `statistics` what cannot light anything. Throws Cancelled.
    FrameSurfaces(const Scene& scene, const Media& media, const Camera& camera, const Region& region,
                  const FrameConfig& config, Statistics& statistics, Progress& progress);

    /// How far neighbours share the world's light; 0: they do not.
    [[nodiscard]] std::uint32_t world_reach_px() const { return world_reach_px_; }
    [[nodiscard]] ViewPath view_path(bool collects_parts = true) const;

    /// What glows.
    [[nodiscard]] const MeshEmitters& emitters() const { return light_.emitters(); }
    /// What samples are like; no pixel where shadow rays do not adapt, and where there was nothing to choose.
    [[nodiscard]] const PilotSamples& pilot() const { return pilot_; }
    /// Samples after which each light has been asked as often as it is worth.
    [[nodiscard]] std::uint32_t turn_samples() const { return turn_samples_; }

    [[nodiscard]] const FilterSampler& filter() const { return filter_; }
    [[nodiscard]] SurfacePass::Config pass_config() const { return {config_.pixel_samples, config_.seed}; }

    /// Before the bands of a pass. `may_keep`: every pixel is active. Throws Cancelled.
    void begin_pass(std::uint32_t sample_index, bool collects_parts, bool may_keep);
    /// The next band, from below; see SurfacePass::trace.
    void trace(std::uint32_t first_row, std::uint32_t end_row, std::span<const std::uint8_t> is_active,
               const SurfacePass::Deliver& deliver, WaitingParts& waiting, const Progress& progress);
    /// After the last one.
    void end_pass();
    /// How much of the passes was kept.
    void count(Statistics& statistics) const;

private:
    /// What of a pass is kept: points only where nothing but the lights decides how they are lit.
    [[nodiscard]] SurfaceForm form_for_pass() const;
    /// Whether there is a mirror to follow; says what the picture will lack.
    [[nodiscard]] bool find_mirrors() const;
    [[nodiscard]] SurfaceKey key(std::uint32_t sample_index, bool collects_parts) const;
    [[nodiscard]] std::vector<KeptLight> lights_now() const;
    void set_shadow_rays();
    /// Of the pass that begins.
    void choose_what_is_kept(std::uint32_t sample_index, bool collects_parts, bool may_keep);
    /// How those of the lights that cast such shadows do it.
    [[nodiscard]] std::optional<light_shafts::SurfaceShadows::Config>
    edited_shadows(std::span<const Light> lights) const;
    /// What moved since a pass was kept. Where it is nothing, nothing did.
    [[nodiscard]] std::optional<MovedView> moved_since(const KeptPass& kept) const;
    void count_blocks();
    [[nodiscard]] std::size_t pixel_count() const {
        return std::size_t{region_.x1 - region_.x0} * (region_.y1 - region_.y0);
    }

    const Scene& scene_;
    const Media& media_;
    const Camera& camera_;
    Region region_;
    const FrameConfig& config_;
    Statistics& statistics_;
    Progress& progress_;
    FilterSampler filter_;
    DirectLight light_;
    IndirectLight indirect_;
    bool follows_mirrors_ = false;
    std::optional<SentAir> sent_air_; ///< Nothing: no ray is sent on, or no light scatters.
    bool has_lobes_ = false;
    std::uint32_t world_reach_px_ = 0;
    std::uint32_t turn_samples_ = 1;
    PilotSamples pilot_;
    bool has_detail_ = false; ///< Cubes of voxels are met.

    std::uint32_t sample_index_ = 0; ///< Of the pass at work, as is all that follows.
    bool collects_parts_ = false;
    std::shared_ptr<KeptPass> pass_; ///< Nothing: nothing is kept of it.
    bool is_new_ = false;            ///< Its rays are walked.
    std::size_t band_ = 0;
    std::vector<std::uint8_t> is_asked_; ///< Per light.
    std::optional<MovedView> moved_;     ///< What moved since the pass was kept; nothing: nothing did.

    std::size_t pass_count_ = 0, kept_pass_count_ = 0, asked_light_count_ = 0, kept_light_count_ = 0;
    /// Of passes since which something moved.
    std::size_t kept_block_count_ = 0, walked_block_count_ = 0, lit_again_count_ = 0, kept_lit_count_ = 0;
};
} // namespace tyndall::render
