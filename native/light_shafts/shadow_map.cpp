// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/shadow_map.hpp"
#include "core/parallel.hpp"
#include "light_shafts/coloured_rows.hpp"
#include "light_shafts/edited_resolution.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/map_visibility.hpp"
#include "light_shafts/occluder_edits.hpp"
#include "light_shafts/slope_rows_visibility.hpp"
#include "light_shafts/sun_map.hpp"
#include <algorithm>
#include <numbers>

namespace tyndall::light_shafts {
using namespace slope_rows;

/// Where the rows' light lines pierce the plane across a sun.
static MapWindow sun_window(const Layout& layout, const MapAxes& axes) {
    const Frame& frame = layout.frame;
    const RowsOnMap on_map(frame, axes);
    MapWindow window{vec2(std::numeric_limits<float>::infinity()), vec2(-std::numeric_limits<float>::infinity())};
    for (std::size_t s = 0; s < layout.rows.size(); ++s) {
        const RowExtent& row = layout.rows[s];
        const float across = frame.is_parallel ? layout.first_slice + static_cast<float>(s) * layout.slice_step : 0.0f;
        for (const std::int32_t line : {row.first, row.end}) {
            if (row.first == row.end)
                continue;
            const float r = layout.first_line + static_cast<float>(line) * layout.line_step;
            const vec2 point = on_map.at(r * layout.slice_directions[s] + vec2(0.0f, across));
            window.min = glm::min(window.min, point);
            window.max = glm::max(window.max, point);
        }
    }
    const vec2 margin = 0.001f * (window.max - window.min);
    return {window.min - margin, window.max + margin};
}

RowsOnMap::RowsOnMap(const Frame& frame, const MapAxes& map)
    : offset(map.axes_of(frame.origin - map.origin)), along_u(map.axes_of(frame.u)), along_v(map.axes_of(frame.v)) {}

/// The window's texels as squares of a grid that only their own size decides.
static glm::uvec2 snap(MapWindow& window, std::uint32_t resolution) {
    const float texel = snapped_texel(window, resolution);
    const vec2 first = glm::floor(window.min / texel), last = glm::ceil(window.max / texel);
    window = {first * texel, last * texel};
    return glm::uvec2(glm::max(last - first, vec2(1.0f)));
}

/// A cone that one perspective face can hold, with Cycles' transform of directions doing nothing but turn.
static bool is_narrow_spot(const LightSample& light) {
    if (light.spot == nullptr || light.spot->kind != LightKind::Spot ||
        light.spot->spot_half_angle_rad >= 0.24f * std::numbers::pi_v<float>)
        return false;
    const mat3& turn = light.spot->light_from_world_directions;
    const mat3 product = glm::transpose(turn) * turn;
    float deviation = 0.0f;
    for (int c = 0; c < 3; ++c)
        deviation = std::max(deviation, glm::length(product[c] - mat3(1.0f)[c]));
    return deviation < 1e-3f;
}

static float spot_side(const LightSample& light) { return 1.02f * std::tan(light.spot->spot_half_angle_rad); }

static DepthMap make_face(const vec3& origin, const vec3& z_axis) {
    DepthMap face;
    face.is_perspective = true;
    face.origin = origin;
    face.z_axis = z_axis;
    std::tie(face.x_axis, face.y_axis) = orthonormal_basis(z_axis);
    return face;
}

FacePoint face_point(const ShadowMap& map, const vec3& from_light) {
    FacePoint best;
    for (const DepthMap& face : map.faces) {
        const float z = glm::dot(face.z_axis, from_light);
        if (z > best.z)
            best = {&face, glm::dot(face.x_axis, from_light) / z, glm::dot(face.y_axis, from_light) / z, z};
    }
    return best;
}

/// `raster_face(face, window)` fills a face.
template <typename RasterFace>
static ShadowMap raster_faces(const SunPlace& sun, const LightSample& light, const RasterFace& raster_face) {
    ShadowMap map;
    if (light.is_directional) {
        DepthMap& face = map.faces.emplace_back();
        static_cast<MapAxes&>(face) = sun.axes;
        raster_face(face, sun.window);
        return map;
    }
    if (is_narrow_spot(light)) {
        DepthMap& face = map.faces.emplace_back(make_face(light.position, light.spot->spot_axis));
        const float side = spot_side(light);
        raster_face(face, {vec2(-side), vec2(side)});
        return map;
    }
    map.is_cube = true;
    for (const vec3& axis :
         {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1)})
        raster_face(map.faces.emplace_back(make_face(light.position, axis)), {vec2(-1.0f), vec2(1.0f)});
    return map;
}

ShadowMap raster_shadow_map(const Layout& layout, const LightSample& light, std::uint32_t resolution,
                            const Occluders& occluders, const Progress& progress, const PartialShading* partial) {
    const Frame& frame = layout.frame;
    SunPlace sun{.axes = {frame.origin, frame.u, frame.v, frame.axis}};
    if (light.is_directional)
        sun.window = sun_window(layout, sun.axes);
    return raster_faces(sun, light, [&](DepthMap& face, const MapWindow& window) {
        lay_out_texels(face, window, glm::uvec2(resolution));
        face.texels->layout.room = layout.room;
        face.texels->take_room();
        raster_depth(face, window, occluders, progress);
        if (partial != nullptr)
            raster_partial_depth(face, window, *partial, progress);
    });
}

/// Of raster_shadow_map's: in metres of a sun's, per metre of a lamp's.
static float texel_of_map(const Layout& layout, const LightSample& light, std::uint32_t resolution) {
    vec2 size(2.0f * (is_narrow_spot(light) ? spot_side(light) : 1.0f));
    if (light.is_directional) {
        const Frame& frame = layout.frame;
        const MapWindow window = sun_window(layout, {frame.origin, frame.u, frame.v, frame.axis});
        size = window.max - window.min;
    }
    return std::max(size.x, size.y) / static_cast<float>(resolution);
}

/// Of rows with the same layout: what depth maps read.
static void copy(const Rows& from, Rows& to, const Progress& progress) {
    parallel_blocks(from.layout.sample_count, 1 << 16, progress, [&](std::size_t begin, std::size_t end) {
        std::copy(from.slopes.get() + begin, from.slopes.get() + end, to.slopes.get() + begin);
    });
}

SunPlace sun_place(const Layout& layout, const vec3& x_axis, const vec3& y_axis) {
    // From the scene's origin, which stays.
    const MapAxes axes{vec3(0.0f), x_axis, y_axis, layout.frame.axis};
    return {.axes = axes, .window = sun_window(layout, axes), .room = layout.room};
}

ShadowMap raster_filter_map(const SunPlace& place, float margin, const LightSample& light, std::uint32_t resolution,
                            const Occluders& occluders, const Progress& progress, const PartialShading& partial) {
    return raster_faces(place, light, [&](DepthMap& face, MapWindow window) {
        const float around = light.is_directional || margin == 0.0f ? margin : rounded_up(margin);
        window = {window.min - around, window.max + around};
        if (light.is_directional) {
            const float texel = snapped_texel(window, resolution);
            if (const std::optional<TexelRange> range = texels_in(window, texel)) {
                face = raster_sun_map(place.axes, texel, *range, occluders, partial, progress, place.room);
                return;
            }
        }
        const glm::uvec2 texels = snap(window, resolution);
        lay_out_texels(face, window, texels);
        std::optional<MapCache::Key> key;
        if (occluders.kept) {
            const slope_rows::Layout& layout = face.texels->layout;
            key = light.is_directional
                      ? occluders.kept->key(CastKind::ParallelMap, partial, layout, in_map(layout))
                      : occluders.kept->key(CastKind::PerspectiveMap, partial, layout, in_face(face, window));
            if (const std::shared_ptr<const Rows> kept = occluders.kept->cache().find(*key)) {
                copy(*kept, *face.texels, progress);
                return;
            }
        }
        raster_depth(face, window, occluders, progress);
        raster_partial_depth(face, window, partial, progress);
        if (key) {
            auto kept = std::make_shared<Rows>(face.texels->layout); // filters work in place
            copy(*face.texels, *kept, progress);
            occluders.kept->cache().keep(*key, std::move(kept));
        }
    });
}

/// As many lines as texels, and a slice per line: the rows then add little to the error of the map.
static slope_rows::LayoutConfig map_layout_of(const Config& config) {
    const float texels =
        config.resolution > 0 ? static_cast<float>(config.resolution) : texels_of_map(config.error_target);
    return {.lines = static_cast<std::uint32_t>(texels), .slices_per_line = 1.0f, .room = config.room};
}

std::unique_ptr<Visibility> make_shadow_map(const Scene& scene, const View& view, const LightSample& light,
                                            std::span<const ViewRay> rays, const Config& config, Progress& progress) {
    return make_alone(make_shadow_map_beam, scene, view, light, rays, config, progress);
}

std::unique_ptr<Visibility> make_shadow_map_beam(const Scene& scene, const Occluders& occluders, const View& view,
                                                 const LightSample& light, std::span<const RaySpan> outline,
                                                 std::shared_ptr<const StripOnDemand> strip, const Config& config,
                                                 Progress& progress) {
    const Preparation preparation{scene, occluders, view, light, outline, std::move(strip), progress};
    const slope_rows::LayoutConfig layout = sharing_memory(map_layout_of(config), occluders);
    PreparedRows prepared = prepare_rows(preparation, layout, "SHADOW_MAP");
    if (prepared.instead)
        return std::move(prepared.instead);
    const Layout& made = prepared.rows->layout;
    // While the camera moves, rows are laid out anew for each picture; a map of texels that stay where they are serves many.
    // Its texels are square, not turned with the rows, and rounded up: with half as many again it is as good.
    std::optional<SunPlace> place;
    const std::uint32_t texels = layout.lines + layout.lines / 2;
    float texel;
    if (config.walks_maps && light.is_directional) {
        const auto [x_axis, y_axis] = orthonormal_basis(light.towards_light);
        place = sun_place(made, x_axis, y_axis);
        texel = snapped_texel(place->window, texels);
    } else {
        texel = texel_of_map(made, light, layout.lines);
    }
    KeepAs keep_as{CastKind::ShadowMapRows, in_rows_of_map(made, light, texel), layout.lines};
    if (config.walks_maps) {
        keep_as.kind = CastKind::WalkedMapRows;
        const std::size_t faces = light.is_directional || is_narrow_spot(light) ? 1 : 6;
        const std::size_t side = place ? texels : layout.lines;
        keep_as.instead_bytes = faces * side * side * sizeof(float);
    }
    return fill_rows(
        preparation, std::move(prepared), config.seed, std::move(keep_as),
        [&](Rows& rows, const PartialShading& partial, Statistics& statistics) -> std::shared_ptr<const Visibility> {
            ShadowMap map;
            {
                const StageTimer timer(statistics, "shadow map: raster");
                map = place ? raster_filter_map(*place, 0.0f, light, texels, occluders, progress, partial)
                            : raster_shadow_map(rows.layout, light, layout.lines, occluders, progress, &partial);
            }
            {
                const StageTimer timer(statistics, "shadow map: rectify");
                rectify(map, rows, progress);
            }
            statistics.count("shadow map: faces", static_cast<double>(map.faces.size()));
            return config.walks_maps ? std::make_shared<const MapVisibility>(std::move(map)) : nullptr;
        });
}

std::unique_ptr<Visibility> make_edited_beam(const Scene& scene, const OccluderEdits& edits, const Occluders& occluders,
                                             const View& view, const LightSample& light,
                                             std::span<const RaySpan> outline,
                                             std::shared_ptr<const StripOnDemand> strip, const Config& config,
                                             Progress& progress, EditedMap map) {
    const Preparation preparation{scene, occluders, view, light, outline, std::move(strip), progress};
    slope_rows::LayoutConfig layout = sharing_memory(map_layout_of(config), occluders);
    edits.add_margins(layout);
    PreparedRows prepared = prepare_rows(preparation, layout, "edited occluders");
    if (prepared.instead)
        return std::move(prepared.instead);
    // A resolution that the artist sets is kept.
    if (const std::uint32_t lines = edits.finer_lines(prepared.rows->layout, layout.lines);
        config.resolution == 0 && lines > layout.lines) {
        layout.lines = lines;
        prepared = prepare_rows(preparation, layout, "edited occluders");
    }
    return fill_rows(
        preparation, std::move(prepared), config.seed, std::nullopt,
        [&](Rows& rows, const PartialShading& partial, Statistics& statistics) -> std::shared_ptr<const Visibility> {
            return std::make_shared<const MapVisibility>(
                edits.fill(rows, light, {layout.lines, map}, partial, statistics, progress));
        });
}
} // namespace tyndall::light_shafts
