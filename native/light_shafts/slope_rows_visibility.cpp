// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_visibility.hpp"
#include "light_shafts/row_query_air.hpp"
#include "light_shafts/row_query_scatter.hpp"
#include "light_shafts/row_query_shares.hpp"
#include <tbb/task_arena.h>

namespace tyndall::light_shafts {
namespace {
class Unshadowed final : public Visibility {
public:
    explicit Unshadowed(Statistics statistics) : statistics_(std::move(statistics)) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override {
        for (const ViewRay& ray : rays) {
            if (ray.near_m < ray.far_m)
                lit.intervals.push_back({.near_m = ray.near_m, .far_m = ray.far_m});
            lit.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    Statistics statistics_;
};

class ExactInstead final : public Visibility {
public:
    ExactInstead(std::unique_ptr<Visibility> exact, const std::string& why) : exact_(std::move(exact)) {
        statistics_ = exact_->statistics();
        statistics_.report(why);
    }
    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override { exact_->lit_intervals(rays, lit); }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    std::unique_ptr<Visibility> exact_;
    Statistics statistics_;
};
} // namespace

std::unique_ptr<Visibility> make_alone(MakeBeamVisibility& make, const Scene& scene, const View& view,
                                       const LightSample& light, std::span<const ViewRay> rays, const Config& config,
                                       Progress& progress) {
    return make(scene, gather_occluders(scene.description(), progress), view, light,
                outline(view.is_orthographic, rays, progress), std::make_shared<const StripOnDemand>(scene), config,
                progress);
}

PreparedRows prepare_rows(const Preparation& preparation, const slope_rows::LayoutConfig& layout,
                          const std::string& method) {
    PreparedRows prepared;
    const LightSample& light = preparation.light;
    const Occluders& occluders = preparation.occluders;
    const bool has_occluder = !occluders.is_empty();
    if (!light.casts_shadow || !has_occluder) {
        prepared.statistics.skip("slope rows", has_occluder ? "the light casts no shadow" : "no occluder");
        prepared.instead = std::make_unique<Unshadowed>(std::move(prepared.statistics));
        return prepared;
    }
    std::string why;
    const auto frame = slope_rows::make_frame(preparation.view, light);
    if (!frame)
        why = light.is_directional ? "the sun shines along the orthographic view" : "the light stands in the camera";
    if (!why.empty()) {
        prepared.instead = std::make_unique<ExactInstead>(
            make_exact_strip(preparation.scene, light, preparation.strip->get()), why + ": EXACT instead of " + method);
        return prepared;
    }
    const StageTimer timer(prepared.statistics, "slope rows: layout");
    prepared.rows = std::make_unique<slope_rows::Rows>(
        slope_rows::make_layout(*frame, preparation.outline, layout, preparation.progress));
    const slope_rows::Layout& made = prepared.rows->layout;
    prepared.statistics.count("slope rows: slices", made.slice_count());
    prepared.statistics.count("slope rows: lines", made.line_count);
    prepared.statistics.count("slope rows: bytes", static_cast<double>(prepared.rows->bytes()));
    if (made.line_count < static_cast<std::int32_t>(layout.lines) && made.slice_count() > 0 && !made.frame.is_angular)
        prepared.statistics.report("slope rows would exceed " + std::to_string(layout.memory_limit_bytes >> 20) +
                                   " MiB: " + std::to_string(made.line_count) + " lines instead of " +
                                   std::to_string(layout.lines));
    return prepared;
}

RowsVisibility::RowsVisibility(const Preparation& preparation, std::shared_ptr<const slope_rows::Rows> rows,
                               Statistics statistics, std::shared_ptr<const Visibility> instead)
    : scene_(preparation.scene), light_(preparation.light), strip_(preparation.strip), rows_(std::move(rows)),
      statistics_(std::move(statistics)), other_(std::move(instead)) {}

const Visibility& RowsVisibility::other() const {
    std::call_once(other_once_, [this] {
        if (other_ == nullptr)
            other_ = make_exact_strip(scene_, light_, strip_->get());
    });
    return *other_;
}

void RowsVisibility::lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const {
    thread_local row_query::Uncovered uncovered;
    uncovered.near_epipole.clear();
    uncovered.outside.clear();
    const std::size_t first_row = lit.first.size() - 1, first_interval = lit.intervals.size();
    row_query::lit_intervals(*rows_, rays, lit, uncovered);
    near_epipole_count_ += uncovered.near_epipole.size();
    outside_count_ += uncovered.outside.size();
    if (uncovered.near_epipole.empty() && uncovered.outside.empty())
        return;
    // Rebuild the rows of this call with the other answers between; such calls are rare.
    std::vector<ViewRay> other_rays;
    std::vector<std::int32_t> other_row(rays.size(), -1);
    for (const auto* indices : {&uncovered.near_epipole, &uncovered.outside})
        for (const std::uint32_t ray : *indices) {
            other_row[ray] = static_cast<std::int32_t>(other_rays.size());
            other_rays.push_back(rays[ray]);
        }
    LitRows other_lit;
    other().lit_intervals(other_rays, other_lit);
    const std::vector<LitInterval> from_rows(lit.intervals.begin() + static_cast<std::ptrdiff_t>(first_interval),
                                             lit.intervals.end());
    const std::vector<std::uint32_t> offsets(lit.first.begin() + static_cast<std::ptrdiff_t>(first_row),
                                             lit.first.end());
    lit.intervals.resize(first_interval);
    lit.first.resize(first_row + 1);
    const auto append = [&](const std::vector<LitInterval>& from, std::size_t begin, std::size_t end) {
        lit.intervals.insert(lit.intervals.end(), from.begin() + static_cast<std::ptrdiff_t>(begin),
                             from.begin() + static_cast<std::ptrdiff_t>(end));
    };
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        if (other_row[ray] >= 0) {
            const auto row = static_cast<std::size_t>(other_row[ray]);
            append(other_lit.intervals, other_lit.first[row], other_lit.first[row + 1]);
        } else
            append(from_rows, offsets[ray] - first_interval, offsets[ray + 1] - first_interval);
        lit.end_ray();
    }
}

/// Adds what `visibility` says about some rays of a call.
static void add_some(const Visibility& visibility, std::span<const std::uint32_t> indices,
                     std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                     std::span<float> lit_length_m, bool by_intervals) {
    std::vector<ViewRay> some_rays;
    PieceRows some_pieces;
    for (const std::uint32_t ray : indices) {
        some_rays.push_back(rays[ray]);
        some_pieces.pieces.insert(some_pieces.pieces.end(), pieces.pieces.begin() + pieces.first[ray],
                                  pieces.pieces.begin() + pieces.first[ray + 1]);
        some_pieces.end_ray();
    }
    std::vector<Rgb> some_radiance(indices.size(), Rgb(0.0f));
    std::vector<float> some_lengths(indices.size(), 0.0f);
    if (by_intervals)
        visibility.Visibility::add_scattered(some_rays, some_pieces, some_radiance, some_lengths);
    else
        visibility.add_scattered(some_rays, some_pieces, some_radiance, some_lengths);
    for (std::size_t i = 0; i < indices.size(); ++i) {
        radiance[indices[i]] += some_radiance[i];
        if (!lit_length_m.empty())
            lit_length_m[indices[i]] += some_lengths[i];
    }
}

std::vector<std::uint32_t> RowsVisibility::coherent_order(std::span<const ViewRay> rays,
                                                          const Progress& progress) const {
    return row_query::by_wedge(rows_->layout, rays, progress);
}

void RowsVisibility::make_coherent(std::span<const ViewRay> rays, std::vector<std::uint32_t>& asked,
                                   const Progress& progress) const {
    if (!rows_->layout.rows.empty() && !asked.empty())
        asked = row_query::by_wedge(rows_->layout, rays, progress, 1, asked);
}

const CoarseRows* RowsVisibility::coarse_rows() const {
    if (rows_->layout.frame.is_angular || rows_->layout.rows.empty())
        return nullptr;
    std::call_once(coarse_once_, [this] {
        // A thread that waits for the others here must not begin what waits for these rows, too.
        tbb::this_task_arena::isolate([this] {
            coarse_ = std::make_unique<const CoarseRows>(make_coarse_rows(*rows_, row_query::most_air_lines));
        });
    });
    return coarse_.get();
}

void RowsVisibility::find_lit_shares(std::span<const ViewRay> rays, const StepRows& steps,
                                     std::span<float> shares) const {
    if (rows_->layout.frame.is_angular) {
        Visibility::find_lit_shares(rays, steps, shares);
        return;
    }
    thread_local row_query::Uncovered uncovered;
    uncovered.near_epipole.clear();
    uncovered.outside.clear();
    row_query::find_lit_shares(*rows_, rays, steps, shares, uncovered);
    near_epipole_count_ += uncovered.near_epipole.size();
    outside_count_ += uncovered.outside.size();
    for (const auto* indices : {&uncovered.near_epipole, &uncovered.outside})
        for (const std::uint32_t ray : *indices) // such rays are rare
            other().find_lit_shares(rays.subspan(ray, 1),
                                    {steps.begin_m.subspan(ray, 1), steps.step_m.subspan(ray, 1), steps.step_count},
                                    shares.subspan(std::size_t{ray} * steps.step_count, steps.step_count));
}

void RowsVisibility::add_scattered(std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                                   std::span<float> lit_length_m) const {
    if (rows_->layout.frame.is_angular) {
        Visibility::add_scattered(rays, pieces, radiance, lit_length_m);
        return;
    }
    thread_local row_query::Unanswered unanswered;
    unanswered.near_epipole.clear();
    unanswered.outside.clear();
    unanswered.steep.clear();
    row_query::add_scattered(*rows_, rays, pieces, radiance, lit_length_m, unanswered);
    near_epipole_count_ += unanswered.near_epipole.size();
    outside_count_ += unanswered.outside.size();
    for (const auto* indices : {&unanswered.near_epipole, &unanswered.outside})
        if (!indices->empty())
            add_some(other(), *indices, rays, pieces, radiance, lit_length_m, false);
    if (!unanswered.steep.empty())
        add_some(*this, unanswered.steep, rays, pieces, radiance, lit_length_m, true);
}
} // namespace tyndall::light_shafts
