// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/surface_shadows.hpp"
#include "core/parallel.hpp"
#include "light_shafts/occluder_edits.hpp"
#include "light_shafts/scattering_lights.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
using namespace slope_rows;

bool SurfaceShadows::are_cast_by(const Light& light) {
    return light.casts_shadow && std::ranges::any_of(light.occluder_edits, [](const OccluderEdit& edit) {
               return edit.affects_surfaces && edit.kind != EditKind::Holes && edit_does_something(edit);
           });
}

SurfaceShadows::Config SurfaceShadows::config_of(const Camera& camera, const light_shafts::Config& config) {
    const std::uint32_t by_pixels = std::clamp(2 * std::max(camera.width_px, camera.height_px), 512u, 4096u);
    return {.lines = config.resolution > 0 ? config.resolution : by_pixels,
            .strata = std::clamp(config.light_samples, 1u, 64u),
            .seed = config.seed};
}

namespace {
constexpr std::size_t grid_cells = 48;

/// How far away a ray sees surfaces.
struct Seen {
    float near_m = std::numeric_limits<float>::infinity(), far_m = -near_m;
    void grow(const Seen& other) {
        near_m = std::min(near_m, other.near_m);
        far_m = std::max(far_m, other.far_m);
    }
};

/// Up to the first surface that hides what is behind it.
Seen seen_along(const Scene& scene, Ray ray) {
    Seen seen;
    for (int surface = 0; surface < 16; ++surface) {
        const Hit hit = scene.closest_hit(ray);
        if (!hit.is_hit())
            break;
        seen.grow({hit.distance_m, hit.distance_m});
        if (scene.transparency(ray, hit) == Rgb(0.0f))
            break;
        ray.near_m = hit.distance_m * 1.0001f;
    }
    return seen;
}
} // namespace

std::vector<RaySpan> SurfaceShadows::outline_of(const Scene& scene, const Camera& camera, const Progress& progress) {
    constexpr std::size_t side = grid_cells + 1;
    constexpr float margin = 0.01f; // of the frame: filters reach beyond it
    std::vector<Ray> rays(side * side);
    std::vector<Seen> seen(rays.size());
    parallel_for(
        rays.size(), progress,
        [&](std::size_t index) {
            const auto place = [&](std::size_t step, std::uint32_t size_px) {
                const float share = static_cast<float>(step) / grid_cells;
                return ((1.0f + 2.0f * margin) * share - margin) * static_cast<float>(size_px);
            };
            rays[index] =
                camera.ray_or_rim(place(index % side, camera.width_px), place(index / side, camera.height_px));
            seen[index] = seen_along(scene, rays[index]);
        },
        16);
    const auto view_ray = [&](std::size_t index) {
        Seen around; // what lies between two rays is about as far as what their neighbours see
        for (std::size_t y = index / side - (index / side > 0); y <= std::min(index / side + 1, side - 1); ++y)
            for (std::size_t x = index % side - (index % side > 0); x <= std::min(index % side + 1, side - 1); ++x)
                around.grow(seen[y * side + x]);
        return ViewRay{rays[index].origin, rays[index].direction, 0.95f * around.near_m, 1.05f * around.far_m};
    };
    std::vector<RaySpan> spans;
    const auto add = [&](ViewRay first, ViewRay last) {
        first.near_m = last.near_m = std::min(first.near_m, last.near_m);
        first.far_m = last.far_m = std::max(first.far_m, last.far_m);
        if (first.near_m < first.far_m)
            spans.push_back({first, last});
    };
    // The sides of the grid's cells: no slice passes between them.
    for (std::size_t y = 0; y < side; ++y)
        for (std::size_t x = 0; x < side; ++x) {
            const std::size_t index = y * side + x;
            if (x < grid_cells)
                add(view_ray(index), view_ray(index + 1));
            if (y < grid_cells)
                add(view_ray(index), view_ray(index + side));
        }
    return spans;
}

/// Around the outline, as a sun sees it.
static SunPlace sun_place_of(const OccluderEdits& edits, const LightSample& sample, std::span<const RaySpan> outline) {
    const auto [x_axis, y_axis] = edits.axes_across(sample);
    SunPlace place{.axes = {vec3(0.0f), x_axis, y_axis, sample.towards_light}};
    place.window = {vec2(std::numeric_limits<float>::infinity()), vec2(-std::numeric_limits<float>::infinity())};
    for (const RaySpan& span : outline)
        for (const ViewRay& ray : {span.first, span.last})
            for (const float distance_m : {ray.near_m, ray.far_m}) {
                const vec2 at(place.axes.axes_of(ray.origin + distance_m * ray.direction));
                place.window.min = glm::min(place.window.min, at);
                place.window.max = glm::max(place.window.max, at);
            }
    return place;
}

/// Leaves what is nearer to the light than before.
static void keep_changes(Rows& edited, const Rows& before, const Progress& progress) {
    parallel_blocks(edited.layout.sample_count, 1 << 16, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t sample = begin; sample < end; ++sample)
            if (!(edited.slopes[sample] > before.slopes[sample]))
                edited.slopes[sample] = no_occluder;
    });
}
static void keep_changes(ShadowMap& edited, const ShadowMap& before, const Progress& progress) {
    for (std::size_t face = 0; face < edited.faces.size(); ++face)
        keep_changes(*edited.faces[face].texels, *before.faces[face].texels, progress);
}

/// Rows with what edits have put there; nothing where view and light span no planes.
static std::unique_ptr<Rows> make_rows(const OccluderEdits& edits, const View& view, const LightSample& sample,
                                       std::span<const RaySpan> outline, LayoutConfig layout,
                                       const PartialShading& partial, Statistics& statistics,
                                       const Progress& progress) {
    const std::optional<Frame> frame = make_frame(view, sample);
    if (!frame)
        return nullptr;
    edits.add_margins(layout);
    Layout made = make_layout(*frame, outline, layout, progress);
    if (const std::uint32_t lines = edits.finer_lines(made, layout.lines); lines > layout.lines) {
        layout.lines = lines;
        made = make_layout(*frame, outline, layout, progress);
    }
    Rows before(made);
    auto rows = std::make_unique<Rows>(std::move(made));
    edits.fill(*rows, sample, {layout.lines}, partial, statistics, progress);
    Statistics ignored;
    edits.fill(before, sample, {layout.lines}, partial, ignored, progress, OccluderEdits::Made::HolesAlone);
    keep_changes(*rows, before, progress);
    return rows;
}

SurfaceShadows::SurfaceShadows(const Scene& scene, const Occluders& occluders, std::uint32_t light_index,
                               const View& view, std::span<const RaySpan> outline, const Config& config,
                               Statistics& statistics, const Progress& progress)
    : is_sun_(scene.lights()[light_index].kind == LightKind::Sun) {
    if (occluders.is_empty() || outline.empty())
        return;
    Light light = scene.lights()[light_index];
    std::erase_if(light.occluder_edits, [](const OccluderEdit& edit) { return !edit.affects_surfaces; });
    const OccluderEdits edits(scene.description(), light, occluders);
    if (edits.is_empty())
        return;
    reach_ = edits.reach();
    one_sided_reach_ = edits.one_sided_reach();
    const std::uint32_t count = has_size(light) ? config.strata : 1;
    const LayoutConfig layout{
        .lines = std::max(16u, static_cast<std::uint32_t>(static_cast<float>(config.lines) / std::sqrt(count))),
        .memory_limit_bytes = LayoutConfig{}.memory_limit_bytes / count};
    strata_.resize(count);
    std::vector<Statistics> of_stratum(count);
    parallel_for(
        count, progress,
        [&](std::size_t index) {
            const LightSample sample =
                stratum_of(light, light_index, static_cast<std::uint32_t>(index), count, config.seed);
            const PartialShading partial(occluders.partial_instances, sample, config.seed);
            const SunPlace place = is_sun_ ? sun_place_of(edits, sample, outline) : SunPlace{};
            Stratum& stratum = strata_[index];
            stratum.place = is_sun_ ? sample.towards_light : sample.position;
            stratum.map = edits.map(place, sample, {layout.lines}, partial, progress);
            keep_changes(stratum.map,
                         edits.map(place, sample, {layout.lines}, partial, progress, OccluderEdits::Made::HolesAlone),
                         progress);
            if (edits.has_edits_of_rows())
                stratum.rows = make_rows(edits, view, sample, outline, layout, partial, of_stratum[index], progress);
        },
        1);
    const Stratum& first = strata_.front();
    edits.report_what_is_too_fine(first.map, first.rows ? &first.rows->layout : nullptr, " on surfaces", statistics);
    if (edits.has_edits_of_rows() && !first.rows)
        statistics.report("Light \"" + light.name + "\": its edits along the view shadow no surface, because " +
                          (is_sun_ ? "it shines along the view" : "it stands in the camera"));
}

const SurfaceShadows::Stratum& SurfaceShadows::nearest_stratum(const Ray& to_light) const {
    const vec3 place = is_sun_ ? to_light.direction : to_light.origin + to_light.far_m * to_light.direction;
    return *std::ranges::min_element(strata_, {}, [&](const Stratum& stratum) {
        const vec3 way = stratum.place - place;
        return glm::dot(way, way);
    });
}

static constexpr float nothing = -std::numeric_limits<float>::infinity();

/// By how much, along its light, something stands before a point.
static float height_on_map(const ShadowMap& map, bool is_sun, const vec3& place, const vec3& point) {
    if (is_sun) {
        const DepthMap& face = map.faces.front();
        const vec3 at = face.axes_of(point - face.origin);
        return face.depth_at(at.x, at.y) - at.z;
    }
    const vec3 from_light = point - place;
    const FacePoint at = face_point(map, from_light);
    const float inverse_z = at.face == nullptr ? no_occluder : at.face->depth_at(at.x, at.y);
    return inverse_z > 0.0f ? (at.z - 1.0f / inverse_z) * glm::length(from_light) / at.z : nothing;
}

/// The same; nothing where the rows do not reach.
static std::optional<float> height_on_rows(const Rows& rows, float one_sided_reach, const vec3& point) {
    const Layout& layout = rows.layout;
    const Frame& frame = layout.frame;
    const vec3 from = point - frame.origin;
    const float axial = glm::dot(from, frame.axis);
    const vec2 across(glm::dot(from, frame.u), glm::dot(from, frame.v));
    const float radial = frame.is_parallel ? across.x : glm::length(across);
    if (!frame.is_parallel && (frame.is_orthographic ? radial : radial / glm::length(from)) < layout.smallest_radius)
        return std::nullopt;
    const std::int32_t slice = nearest_slice(layout, frame.is_parallel ? across.y : std::atan2(across.y, across.x));
    if (slice < 0 || slice >= layout.slice_count())
        return std::nullopt;
    const float x = frame.x.at(axial, radial), w = frame.w.at(axial, radial);
    const float line = frame.is_angular ? std::atan2(frame.angle_scale * radial, x) : radial;
    if (!frame.is_parallel && line < one_sided_reach)
        return std::nullopt;
    const RowView row = rows.row(slice);
    const float index = std::floor((line - layout.first_line) / layout.line_step);
    if (!(index >= static_cast<float>(row.first) && index < static_cast<float>(row.end)))
        return std::nullopt;
    const float slope = row.slopes[static_cast<std::int32_t>(index) - row.first];
    if (!(slope > frame.y.at(axial, radial) / w))
        return nothing;
    // Where the point's light line reaches that slope: x - X w = 0 and y - Y w = 0.
    const auto equation = [&](const Linear& of, float value) {
        return vec3(of.per_axial - value * frame.w.per_axial, of.per_radial - value * frame.w.per_radial,
                    value * frame.w.at_origin - of.at_origin);
    };
    const vec3 on_line = equation(frame.x, x / w), on_slope = equation(frame.y, slope);
    const vec3 solution = glm::cross(on_line, on_slope);
    const vec2 place = -vec2(solution) / solution.z;
    return glm::length(place - vec2(axial, radial));
}

/// Of what edits do not fill on surfaces, relative to their size.
static constexpr float deepest_pit = 0.25f;

bool SurfaceShadows::is_dark(const vec3& point, const vec3& normal, const Ray& to_light) const {
    if (strata_.empty())
        return false;
    const Stratum& stratum = nearest_stratum(to_light);
    const std::optional<float> on_rows =
        stratum.rows ? height_on_rows(*stratum.rows, one_sided_reach_, point) : std::nullopt;
    const float height_m = on_rows ? *on_rows : height_on_map(stratum.map, is_sun_, stratum.place, point);
    if (!(height_m > 0.0f))
        return false;
    const vec3 way = is_sun_ ? stratum.place : stratum.place - point;
    const float distance_m = glm::length(way);
    const float cosine = std::max(std::abs(glm::dot(normal, way)) / distance_m, 1e-3f);
    const float tangent = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)) / cosine;
    const float texel = stratum.map.faces.front().texels->layout.line_step;
    const float scale = is_sun_ ? 1.0f : distance_m - height_m; // a lamp's edits are as large as where they are put
    return height_m > scale * (reach_ * (deepest_pit + tangent) + texel * (1.0f + tangent));
}
} // namespace tyndall::light_shafts
