// SPDX-License-Identifier: GPL-3.0-or-later
// The edits of one light's occluders: holes closed and made in its depth map, silhouettes drawn out in its slope rows.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1, eq. 5.3 to 5.5.
// Differs:  eq. 5.3 is a flat filter on slope rows: along a view ray the slope is the same, so that no sample is weighted,
//           and none lies beyond the epipole; under a lamp, too. Objects that the same edits mean share a depth map, whose
//           texels in holes hold nothing: that discards exactly. The maps' and the rows' maxima are what casts shadows.
//           Edits of the map come before those of rows.
// Bound:    per group of objects one map, its filters and one set of rows.
#pragma once
#include "light_shafts/occluders.hpp"
#include "light_shafts/placed_edit.hpp"
#include "light_shafts/shadow_map.hpp"
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts {
/// Texels along the longer side of a map, as asked for.
struct MapResolution {
    std::uint32_t texels = 2048;
    EditedMap map = EditedMap::ShowsEdits;
};

class OccluderEdits {
public:
    /// Which of the edits are made.
    enum class Made : std::uint8_t { All, HolesAlone };

    /// `scene`, `light` and `occluders` must outlive this.
    OccluderEdits(const SceneDescription& scene, const Light& light, const Occluders& occluders);
    /// No edit changes anything.
    [[nodiscard]] bool is_empty() const;

    /// Room that the filters along the rows need.
    void add_margins(slope_rows::LayoutConfig& layout) const;
    /// Lines that a layout of `lines` should have instead, for the filters along its rows to show: at most 2048, or as
    /// many as it has.
    [[nodiscard]] std::uint32_t finer_lines(const slope_rows::Layout& layout, std::uint32_t lines) const;
    /// Of the occluders of all groups, with the edits of maps. Its texels are where they are whatever is made. Throws
    /// Cancelled.
    [[nodiscard]] ShadowMap map(const SunPlace& place, const LightSample& sample, MapResolution resolution,
                                const PartialShading& partial, const Progress& progress, Made made = Made::All) const;
    /// What the filters of maps need around what is asked: metres of a sun, tangents of a lamp's face.
    [[nodiscard]] float map_margin() const;
    /// Axes of a sun's map, as upright as the light.
    [[nodiscard]] std::pair<vec3, vec3> axes_across(const LightSample& sample) const;
    /// Fills the rows and summarises their blocks; returns the map that they came from, with the edits of maps. `partial`
    /// says how surfaces let a part of the light pass. Throws Cancelled.
    ShadowMap fill(slope_rows::Rows& rows, const LightSample& sample, MapResolution resolution,
                   const PartialShading& partial, Statistics& statistics, const Progress& progress,
                   Made made = Made::All) const;
    /// Some edit is of rows, which need a camera.
    [[nodiscard]] bool has_edits_of_rows() const;
    /// How far from where something stands edits may put something: all of their sizes together; metres of a sun,
    /// tangents of a lamp's angles.
    [[nodiscard]] float reach() const;
    /// How far from the axis of half-planes rows are closed by what lies on one side of it alone: metres of a sun, radians.
    [[nodiscard]] float one_sided_reach() const;
    /// Edits of which a texel, or a light line of `rows`, is larger than what they do. Nothing: edits of rows do not count.
    void report_what_is_too_fine(const ShadowMap& map, const slope_rows::Layout* rows, const std::string& where,
                                 Statistics& statistics) const;

private:
    /// Objects that the same edits mean.
    struct Group {
        Occluders occluders;
        std::vector<std::size_t> edits; ///< Into edits_.
    };
    [[nodiscard]] ShadowMap map_of(const Group& group, const SunPlace& place, const LightSample& sample,
                                   MapResolution resolution, const PartialShading& partial, Made made,
                                   const Progress& progress) const;
    [[nodiscard]] std::uint32_t finer_resolution(const SunPlace& place, MapResolution resolution) const;
    [[nodiscard]] float reach_on_map(const OccluderEdit& edit) const;
    [[nodiscard]] float detail_on_map(const OccluderEdit& edit) const;
    [[nodiscard]] float length_on_rows(const OccluderEdit& edit) const;
    void edit_face(const PlacedEdit& edit, DepthMap& face, const Progress& progress) const;
    void edit_rows(const PlacedEdit& edit, slope_rows::Rows& rows, const Progress& progress) const;

    std::string light_name_;
    bool is_sun_;
    float largest_size_; ///< Of a filter: all occluders of a sun, metres; 45 degrees on either side of a lamp.
    LightSpace space_;
    std::vector<PlacedEdit> edits_;
    std::vector<Group> groups_;
};
} // namespace tyndall::light_shafts
