// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/occluder_edits.hpp"
#include "core/parallel.hpp"
#include "light_shafts/flat_filters.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/wide_closing.hpp"
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <numeric>
#include <sstream>

namespace tyndall::light_shafts {
using namespace slope_rows;

static bool is_of_map(EditKind kind) { return kind == EditKind::Close || kind == EditKind::Holes; }
static bool is_made(const OccluderEdit& edit, OccluderEdits::Made made) {
    return made == OccluderEdits::Made::All || edit.kind == EditKind::Holes;
}

OccluderEdits::OccluderEdits(const SceneDescription& scene, const Light& light, const Occluders& occluders)
    : light_name_(light.name), is_sun_(light.kind == LightKind::Sun), largest_size_(2.0f),
      space_(light, light.position, 1.0f) {
    const Bounds3 of_all = bounds_of_occluders(scene);
    if (is_sun_)
        largest_size_ = of_all.diagonal_m();
    for (const OccluderEdit& edit : light.occluder_edits)
        if (edit_does_something(edit))
            edits_.emplace_back(edit, light, edit.affects_all ? of_all : bounds_of_occluders(scene, &edit));
    if (std::ranges::all_of(edits_, [](const PlacedEdit& edit) { return edit.what->affects_all; })) {
        if (occluders.is_empty())
            return;
        Group& all = groups_.emplace_back();
        all.occluders.instances = occluders.instances;
        all.occluders.triangle_count = occluders.triangle_count;
        all.occluders.partial_instances = occluders.partial_instances;
        all.occluders.traced = occluders.traced;
        all.occluders.kept = occluders.kept;
        all.edits.resize(edits_.size());
        std::iota(all.edits.begin(), all.edits.end(), std::size_t{0});
        return;
    }
    std::map<std::vector<bool>, Group> groups;
    const auto group_of = [&](std::uint32_t index) -> Group& {
        const std::uint32_t name_index = scene.name_index_of(index);
        std::vector<bool> is_meant;
        for (const PlacedEdit& edit : edits_)
            is_meant.push_back(edit_means(*edit.what, name_index));
        const auto [group, is_new] = groups.try_emplace(is_meant);
        for (std::size_t edit = 0; is_new && edit < edits_.size(); ++edit)
            if (is_meant[edit])
                group->second.edits.push_back(edit);
        return group->second;
    };
    for (const OccluderInstance& instance : occluders.instances)
        group_of(instance.index).occluders.add(instance.mesh, instance.scene_from_object, instance.index);
    for (const PartialOccluderInstance& instance : occluders.partial_instances)
        group_of(instance.index).occluders.partial_instances.push_back(instance);
    std::map<Group*, std::vector<std::uint32_t>> traced_of_group;
    for (const std::uint32_t placed : occluders.traced ? occluders.traced->placed() : std::span<const std::uint32_t>())
        traced_of_group[&group_of(static_cast<std::uint32_t>(scene.instances.size()) + placed)].push_back(placed);
    for (auto& [group, placed] : traced_of_group)
        group->occluders.traced = std::make_shared<const ShapeTracer>(scene, std::move(placed), Progress());
    for (auto& [is_meant, group] : groups) {
        if (occluders.kept)
            group.occluders.kept = occluders.kept->of(scene, group.occluders);
        groups_.push_back(std::move(group));
    }
}

bool OccluderEdits::is_empty() const {
    return std::ranges::all_of(groups_, [](const Group& group) { return group.edits.empty(); });
}

float OccluderEdits::reach_on_map(const OccluderEdit& edit) const {
    return 0.5f * std::min(is_sun_ ? edit.size_m : edit.size_m / edit.distance_m, largest_size_);
}

float OccluderEdits::length_on_rows(const OccluderEdit& edit) const { return 2.0f * reach_on_map(edit); }

bool OccluderEdits::has_edits_of_rows() const {
    return std::ranges::any_of(edits_, [](const PlacedEdit& edit) { return !is_of_map(edit.what->kind); });
}

float OccluderEdits::reach() const {
    float sum = 0.0f;
    for (const PlacedEdit& edit : edits_)
        if (edit.what->kind != EditKind::Holes)
            sum += 2.0f * reach_on_map(*edit.what);
    return sum;
}

float OccluderEdits::one_sided_reach() const {
    float longest = 0.0f;
    for (const PlacedEdit& edit : edits_)
        if (edit.what->kind == EditKind::EpipolarClose)
            longest = std::max(longest, length_on_rows(*edit.what));
    return longest;
}

void OccluderEdits::add_margins(LayoutConfig& layout) const {
    for (const PlacedEdit& edit : edits_) {
        if (is_of_map(edit.what->kind))
            continue;
        layout.margin_before += length_on_rows(*edit.what);
        if (edit.what->kind == EditKind::EpipolarClose)
            layout.margin_after += length_on_rows(*edit.what);
    }
}

/// Of a filter's reach, or of the noise's cells: what shows its form.
static constexpr float samples_per_reach = 2.0f;
/// Finer only where the error target asks for it: memory goes with the square, and a light has many strata.
static constexpr std::uint32_t most_lines_for_filters = 2048;

static std::uint32_t finer(float extent, float spacing, std::uint32_t now) {
    const float wanted = std::min(extent / spacing, static_cast<float>(most_lines_for_filters));
    return std::max(now, static_cast<std::uint32_t>(wanted));
}

std::uint32_t OccluderEdits::finer_lines(const Layout& layout, std::uint32_t lines) const {
    std::uint32_t result = lines;
    for (const PlacedEdit& edit : edits_)
        if (!is_of_map(edit.what->kind))
            result = std::max(result, finer(layout.line_step * static_cast<float>(lines),
                                            length_on_rows(*edit.what) / samples_per_reach, lines));
    return result;
}

/// What a texel must not exceed by far: the radius of a kernel, or the size of the noise's finest cells but one.
float OccluderEdits::detail_on_map(const OccluderEdit& edit) const {
    if (edit.kind == EditKind::Close)
        return reach_on_map(edit);
    const float cell_m = edit.noise.scale_m / static_cast<float>(1u << std::min(edit.noise.octaves - 1, 1u));
    return is_sun_ ? cell_m : cell_m / edit.distance_m;
}

std::uint32_t OccluderEdits::finer_resolution(const SunPlace& place, MapResolution resolution) const {
    if (resolution.map == EditedMap::AsAsked)
        return resolution.texels;
    const vec2 size = is_sun_ ? place.window.max - place.window.min : vec2(2.0f);
    const float extent = std::max(size.x, size.y) + 2.0f * map_margin();
    std::uint32_t result = resolution.texels;
    for (const PlacedEdit& edit : edits_)
        if (is_of_map(edit.what->kind))
            result = std::max(result, finer(extent, detail_on_map(*edit.what) / samples_per_reach, resolution.texels));
    return result;
}

void OccluderEdits::report_what_is_too_fine(const ShadowMap& map, const Layout* rows, const std::string& where,
                                            Statistics& statistics) const {
    for (const PlacedEdit& edit : edits_) {
        const bool of_map = is_of_map(edit.what->kind);
        if (!of_map && rows == nullptr)
            continue;
        const float step = of_map ? map.faces.front().texels->layout.line_step : rows->line_step;
        const float detail = of_map ? detail_on_map(*edit.what) : length_on_rows(*edit.what);
        if (detail >= step)
            continue;
        const float metres = (is_sun_ ? 1.0f : edit.what->distance_m) * step;
        std::ostringstream text;
        text << "Light \"" << light_name_ << "\": its edit \"" << edit.what->name << "\" is too fine to show" << where
             << ": a texel is " << std::setprecision(2) << metres
             << " m wide; raise the shafts' resolution, or take fewer light samples";
        statistics.report(text.str());
    }
}

void OccluderEdits::edit_face(const PlacedEdit& edit, DepthMap& face, const Progress& progress) const {
    const OccluderEdit& what = *edit.what;
    Rows& texels = *face.texels;
    const Layout& layout = texels.layout;
    const std::ptrdiff_t stride = layout.rows.front().end;
    std::vector<float> before;
    if (what.kind == EditKind::Close) {
        if (what.mask)
            before.assign(texels.slopes.get(), texels.slopes.get() + layout.sample_count);
        close_wide({texels.slopes.get(), layout.line_count, layout.slice_count(), stride}, what.shape,
                   reach_on_map(what) / layout.line_step, progress);
        if (!what.mask)
            return;
    }
    parallel_blocks(layout.rows.size(), 16, progress, [&](std::size_t begin, std::size_t end) {
        std::vector<float> x, y, z;
        std::vector<std::uint8_t> is_hole;
        for (std::size_t row = begin; row < end; ++row) {
            float* slopes = texels.slopes.get() + layout.rows[row].offset;
            edit.space.place_row(face, static_cast<std::int32_t>(row), x, y, z);
            is_hole.resize(x.size());
            if (edit.noise)
                edit.find_holes(x, y, z, is_hole);
            for (std::size_t column = 0; column < x.size(); ++column) {
                const auto is_masked = [&] {
                    return edit.is_masked_out({x[column], y[column], z.empty() ? 0.0f : z[column]});
                };
                if (edit.noise && is_hole[column] != 0 && !is_masked())
                    slopes[column] = no_occluder;
                else if (!edit.noise && is_masked())
                    slopes[column] = before[layout.rows[row].offset + column];
            }
        }
    });
}

void OccluderEdits::edit_rows(const PlacedEdit& edit, Rows& rows, const Progress& progress) const {
    const auto lines = static_cast<std::int32_t>(std::lround(length_on_rows(*edit.what) / rows.layout.line_step));
    parallel_blocks(rows.layout.rows.size(), 16, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slice = begin; slice < end; ++slice) {
            const RowExtent& extent = rows.layout.rows[slice];
            const std::span row(rows.slopes.get() + extent.offset, static_cast<std::size_t>(extent.end - extent.first));
            if (edit.what->kind == EditKind::EpipolarClose)
                flat_filters::close_row(row, lines + 1);
            else
                flat_filters::dilate_row_forward(row, lines);
        }
    });
}

/// The larger one of each sample, in `into`.
static void keep_larger(Rows& into, const Rows& from, const Progress& progress) {
    parallel_blocks(into.layout.sample_count, 1 << 16, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t sample = begin; sample < end; ++sample)
            into.slopes[sample] = std::max(into.slopes[sample], from.slopes[sample]);
    });
}

float OccluderEdits::map_margin() const {
    float margin = 0.0f;
    for (const PlacedEdit& edit : edits_)
        if (edit.what->kind == EditKind::Close)
            margin += 2.0f * reach_on_map(*edit.what); // grown, and shrunk again
    return is_sun_ ? margin : std::min(margin, 1.0f);
}

std::pair<vec3, vec3> OccluderEdits::axes_across(const LightSample& sample) const {
    return space_.across(sample.towards_light);
}

ShadowMap OccluderEdits::map_of(const Group& group, const SunPlace& place, const LightSample& sample,
                                MapResolution resolution, const PartialShading& partial, Made made,
                                const Progress& progress) const {
    PartialShading shading = partial;
    shading.instances = group.occluders.partial_instances;
    ShadowMap map = raster_filter_map(place, map_margin(), sample, finer_resolution(place, resolution), group.occluders,
                                      progress, shading);
    for (const std::size_t edit : group.edits)
        if (is_made(*edits_[edit].what, made) && is_of_map(edits_[edit].what->kind))
            for (DepthMap& face : map.faces)
                edit_face(edits_[edit], face, progress);
    return map;
}

/// The nearer one of each texel, in `into`; takes a map over as it is where there is none yet.
static void merge(ShadowMap& into, ShadowMap map, const Progress& progress) {
    if (into.faces.empty()) {
        into = std::move(map);
        return;
    }
    for (std::size_t face = 0; face < map.faces.size(); ++face)
        keep_larger(*into.faces[face].texels, *map.faces[face].texels, progress);
}

ShadowMap OccluderEdits::map(const SunPlace& place, const LightSample& sample, MapResolution resolution,
                             const PartialShading& partial, const Progress& progress, Made made) const {
    ShadowMap all;
    for (const Group& group : groups_)
        merge(all, map_of(group, place, sample, resolution, partial, made, progress), progress);
    return all;
}

ShadowMap OccluderEdits::fill(Rows& rows, const LightSample& sample, MapResolution resolution,
                              const PartialShading& partial, Statistics& statistics, const Progress& progress,
                              Made made) const {
    SunPlace place;
    if (is_sun_) {
        const auto [x_axis, y_axis] = axes_across(sample);
        place = sun_place(rows.layout, x_axis, y_axis);
    }
    ShadowMap all;
    std::optional<Rows> own;
    for (const Group& group : groups_) {
        const StageTimer timer(statistics, "occluder edits");
        const bool is_first = all.faces.empty();
        if (!is_first && !own)
            own.emplace(rows.layout);
        Rows& filled = is_first ? rows : *own;
        ShadowMap map = map_of(group, place, sample, resolution, partial, made, progress);
        rectify(map, filled, progress);
        for (const std::size_t edit : group.edits)
            if (is_made(*edits_[edit].what, made) && !is_of_map(edits_[edit].what->kind))
                edit_rows(edits_[edit], filled, progress);
        if (!is_first)
            keep_larger(rows, filled, progress);
        merge(all, std::move(map), progress);
    }
    parallel_blocks(rows.layout.rows.size(), 64, progress, [&](std::size_t begin, std::size_t end) {
        summarise_slices(rows, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
    });
    statistics.count("occluder edits: groups of objects", static_cast<double>(groups_.size()));
    report_what_is_too_fine(all, &rows.layout, "", statistics);
    return all;
}
} // namespace tyndall::light_shafts
