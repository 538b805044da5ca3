// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility from slope rows, however they were filled; the few rays that rows cannot answer go to the exact strip, or
// to the map that they came from where its occluders are edited.
#pragma once
#include "light_shafts/coarse_rows.hpp"
#include "light_shafts/exact_strip.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/slope_rows.hpp"
#include <atomic>
#include <mutex>

namespace tyndall::light_shafts {
struct Preparation {
    const Scene& scene;
    const Occluders& occluders;
    const View& view;
    const LightSample& light;
    std::span<const RaySpan> outline;
    std::shared_ptr<const StripOnDemand> strip; ///< For rays that rows cannot answer.
    Progress& progress;
};

class RowsVisibility final : public Visibility {
public:
    /// `scene` must outlive this. Rays that rows cannot answer go to `instead`; without it, to the exact strip, which is
    /// built when the first of them comes.
    RowsVisibility(const Preparation& preparation, std::shared_ptr<const slope_rows::Rows> rows, Statistics statistics,
                   std::shared_ptr<const Visibility> instead = nullptr);
    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override;
    void add_scattered(std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                       std::span<float> lit_length_m) const override;
    void find_lit_shares(std::span<const ViewRay> rays, const StepRows& steps, std::span<float> shares) const override;
    [[nodiscard]] std::vector<std::uint32_t> coherent_order(std::span<const ViewRay> rays,
                                                            const Progress& progress) const override;
    void make_coherent(std::span<const ViewRay> rays, std::vector<std::uint32_t>& asked,
                       const Progress& progress) const override;
    [[nodiscard]] const CoarseRows* coarse_rows() const override;
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }
    [[nodiscard]] const slope_rows::Rows& rows() const { return *rows_; }
    /// Rays that rows could not answer so far: too close to the epipole, or beyond the prepared rows.
    [[nodiscard]] std::size_t near_epipole_count() const { return near_epipole_count_; }
    [[nodiscard]] std::size_t outside_count() const { return outside_count_; }

private:
    const Visibility& other() const;

    const Scene& scene_;
    LightSample light_;
    std::shared_ptr<const StripOnDemand> strip_;
    std::shared_ptr<const slope_rows::Rows> rows_;
    Statistics statistics_;
    mutable std::once_flag other_once_, coarse_once_;
    mutable std::unique_ptr<const CoarseRows> coarse_;
    mutable std::shared_ptr<const Visibility> other_;
    mutable std::atomic<std::size_t> near_epipole_count_ = 0, outside_count_ = 0;
};

/// One light sample of a scene that nothing has been gathered of yet.
[[nodiscard]] std::unique_ptr<Visibility> make_alone(MakeBeamVisibility& make, const Scene& scene, const View& view,
                                                     const LightSample& light, std::span<const ViewRay> rays,
                                                     const Config& config, Progress& progress);

/// What both methods on slope rows begin with.
struct PreparedRows {
    std::unique_ptr<Visibility> instead;    ///< No rows are needed, or none are possible: this answers.
    std::unique_ptr<slope_rows::Rows> rows; ///< Laid out, not filled.
    Statistics statistics;
};
/// `method` is for reports. Throws Cancelled.
[[nodiscard]] PreparedRows prepare_rows(const Preparation& preparation, const slope_rows::LayoutConfig& layout,
                                        const std::string& method);
} // namespace tyndall::light_shafts
