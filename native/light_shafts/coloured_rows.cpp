// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/coloured_rows.hpp"
#include <algorithm>
#include <array>

namespace tyndall::light_shafts {
namespace {
using Channels = std::array<std::unique_ptr<RowsVisibility>, 3>;

/// Lit intervals of three channels as one list.
void append_merged(const std::array<LitRows, 3>& channels, std::size_t ray, std::vector<float>& ends, LitRows& lit) {
    ends.clear();
    std::array<std::span<const LitInterval>, 3> left;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t first = channels[c].first[ray], last = channels[c].first[ray + 1];
        left[c] = std::span(channels[c].intervals).subspan(first, last - first);
        for (const LitInterval& interval : left[c]) {
            ends.push_back(interval.near_m);
            ends.push_back(interval.far_m);
        }
    }
    std::ranges::sort(ends);
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    for (std::size_t end = 1; end < ends.size(); ++end) {
        LitInterval merged{.near_m = ends[end - 1], .far_m = ends[end], .transmittance = Rgb(0.0f)};
        for (std::size_t c = 0; c < 3; ++c) {
            while (!left[c].empty() && left[c].front().far_m <= merged.near_m)
                left[c] = left[c].subspan(1);
            if (!left[c].empty() && left[c].front().near_m <= merged.near_m)
                merged.transmittance[static_cast<int>(c)] = left[c].front().transmittance[static_cast<int>(c)];
        }
        if (merged.transmittance != Rgb(0.0f))
            lit.intervals.push_back(merged);
    }
}

/// A light of which surfaces let different parts pass per channel.
class ColouredRows final : public Visibility {
public:
    ColouredRows(Channels channels, Statistics statistics)
        : channels_(std::move(channels)), statistics_(std::move(statistics)) {}

    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override {
        thread_local std::array<LitRows, 3> of_channel;
        thread_local std::vector<float> ends;
        for (std::size_t c = 0; c < 3; ++c) {
            of_channel[c].clear();
            channels_[c]->lit_intervals(rays, of_channel[c]);
        }
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
            append_merged(of_channel, ray, ends, lit);
            lit.end_ray();
        }
    }
    [[nodiscard]] std::vector<std::uint32_t> coherent_order(std::span<const ViewRay> rays,
                                                            const Progress& progress) const override {
        return channels_[0]->coherent_order(rays, progress);
    }
    void make_coherent(std::span<const ViewRay> rays, std::vector<std::uint32_t>& asked,
                       const Progress& progress) const override {
        channels_[0]->make_coherent(rays, asked, progress);
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    Channels channels_;
    Statistics statistics_;
};
} // namespace

static bool is_coloured(const PartialOccluderInstance& instance) { return instance.mesh->is_coloured; }

slope_rows::LayoutConfig sharing_memory(slope_rows::LayoutConfig layout, const Occluders& occluders) {
    if (std::ranges::any_of(occluders.partial_instances, is_coloured))
        layout.memory_limit_bytes /= 3;
    return layout;
}

std::unique_ptr<Visibility> fill_rows(const Preparation& preparation, PreparedRows prepared, std::uint32_t seed,
                                      const std::optional<KeepAs>& keep_as, const FillRows& fill) {
    const std::shared_ptr<const KeptCasts> kept = keep_as ? preparation.occluders.kept : nullptr;
    /// The answer to rays, from rows that `own` only lays out so far.
    const auto answer = [&](std::shared_ptr<slope_rows::Rows> own, const PartialShading& partial,
                            Statistics& statistics, Statistics& to_keep) {
        std::optional<MapCache::Key> key;
        if (kept) {
            key = kept->key(keep_as->kind, partial, own->layout, keep_as->may_show, keep_as->resolution);
            if (MapCache::Kept found = kept->cache().find_all(*key); found.rows)
                return std::make_unique<RowsVisibility>(preparation, std::move(found.rows), std::move(to_keep),
                                                        std::move(found.instead));
        }
        own->take_room();
        std::shared_ptr<const Visibility> instead = fill(*own, partial, statistics);
        if (key)
            kept->cache().keep_all(*key, {own, instead}, keep_as->instead_bytes);
        return std::make_unique<RowsVisibility>(preparation, std::move(own), std::move(to_keep), std::move(instead));
    };
    const slope_rows::Layout& layout = prepared.rows->layout;
    const std::vector<PartialOccluderInstance> instances =
        slope_rows::that_may_shade(layout, preparation.occluders.partial_instances);
    PartialShading partial(instances, preparation.light, seed);
    if (std::ranges::none_of(instances, is_coloured))
        return answer(std::move(prepared.rows), partial, prepared.statistics, prepared.statistics);
    Channels channels;
    for (std::size_t c = 0; c < 3; ++c) {
        partial.channel = static_cast<int>(c);
        Statistics ignored, none; // three times the same
        channels[c] =
            answer(std::make_shared<slope_rows::Rows>(layout), partial, c == 0 ? prepared.statistics : ignored, none);
    }
    prepared.statistics.count("slope rows: sets for coloured surfaces", 3.0);
    return std::make_unique<ColouredRows>(std::move(channels), std::move(prepared.statistics));
}
} // namespace tyndall::light_shafts
