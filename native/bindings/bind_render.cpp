// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/memory_room.hpp"
#include "light_shafts/light_depth_picture.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/strata_counts.hpp"
#include "render/asked_rays.hpp"
#include "render/frame.hpp"
#include "render/kept_light_trees.hpp"
#include "render/kept_surfaces.hpp"
#include "render/matte_id.hpp"
#include "render/styled_shafts.hpp"
#include <pybind11/functional.h>
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static Camera make_camera(int kind, const py::array& world_from_camera, const std::array<float, 4>& window,
                          const std::array<float, 2>& clip_m, const std::array<std::uint32_t, 2>& size_px,
                          float lens_radius_m, float focus_m, std::uint32_t blades, float blades_rotation_rad,
                          float aperture_ratio, const std::optional<std::array<float, 2>>& air_u, int panorama_kind,
                          float rim, const std::array<float, 5>& angle_by_radius) {
    return {
        .kind = static_cast<CameraKind>(kind),
        .world_from_camera = to_matrix<mat4, 4>(world_from_camera, "world_from_camera"),
        .window_left = window[0],
        .window_right = window[1],
        .window_bottom = window[2],
        .window_top = window[3],
        .clip_near_m = clip_m[0],
        .clip_far_m = clip_m[1],
        .width_px = size_px[0],
        .height_px = size_px[1],
        .lens = {.radius_m = lens_radius_m,
                 .focus_m = focus_m,
                 .blades = blades,
                 .rotation_rad = blades_rotation_rad,
                 .inverse_ratio = 1.0f / aperture_ratio,
                 .air_u = air_u ? std::optional(vec2((*air_u)[0], (*air_u)[1])) : std::nullopt},
        .panorama = {.kind = static_cast<PanoramaKind>(panorama_kind), .rim = rim, .angle_by_radius = angle_by_radius}};
}

/// Origin and unit direction. Lists, whose types stubs can tell.
static std::optional<std::pair<std::vector<float>, std::vector<float>>> ray_through(const Camera& camera, float x_px,
                                                                                    float y_px) {
    require_usable(camera);
    const Ray ray = camera.ray(x_px, y_px);
    if (!ray.exists())
        return {};
    const vec3 origin = ray.origin + ray.near_m * ray.direction;
    return std::pair{std::vector{origin.x, origin.y, origin.z},
                     std::vector{ray.direction.x, ray.direction.y, ray.direction.z}};
}

static std::optional<std::pair<float, float>> raster_position(const Camera& camera, float x_m, float y_m, float z_m) {
    require_usable(camera);
    const std::optional<vec2> place_px = camera.raster_position({x_m, y_m, z_m});
    return place_px ? std::optional(std::pair{place_px->x, place_px->y}) : std::nullopt;
}

static light_shafts::Config make_shafts(int method, float error_target, std::uint32_t resolution,
                                        std::uint32_t light_samples, std::uint32_t world_samples, bool attenuates_light,
                                        bool adapts_strata, bool shares_strata, int grid_method,
                                        float grid_error_target, bool walks_maps, std::uint32_t seed,
                                        const std::array<std::uint32_t, 4>& part, bool part_has_own_view,
                                        const std::optional<std::shared_ptr<light_shafts::KeptStrata>>& kept_strata,
                                        const std::optional<std::shared_ptr<light_shafts::MapCache>>& kept_maps,
                                        std::optional<std::size_t> room_bytes) {
    return {.method = static_cast<light_shafts::Method>(method),
            .error_target = error_target,
            .resolution = resolution,
            .light_samples = light_samples,
            .world_samples = world_samples,
            .attenuates_light = attenuates_light,
            .adapts_strata = adapts_strata,
            .shares_strata = shares_strata,
            .visibility_light = {},
            .grid_method = static_cast<light_shafts::GridMethod>(grid_method),
            .grid_error_target = grid_error_target,
            .walks_maps = walks_maps,
            .seed = seed,
            .part = {.first = part[0],
                     .end = part[1],
                     .samples = part[2],
                     .pictures = part[3],
                     .has_own_view = part_has_own_view},
            .kept_strata = kept_strata.value_or(nullptr),
            .kept_maps = kept_maps.value_or(nullptr),
            .room = room_bytes ? std::make_shared<MemoryRoom>(*room_bytes) : nullptr};
}

static render::IndirectConfig make_indirect(bool ambient_occlusion, float ambient_distance_m,
                                            std::uint32_t ambient_samples, bool bounce, std::uint32_t bounce_samples,
                                            std::uint32_t mirror_depth, std::uint32_t refraction_depth) {
    return {.has_ambient_occlusion = ambient_occlusion,
            .ambient_distance_m = ambient_distance_m,
            .ambient_samples = ambient_samples,
            .has_bounce = bounce,
            .bounce_samples = bounce_samples,
            .mirror_depth = mirror_depth,
            .refraction_depth = refraction_depth};
}

/// Camera, matrices (n, 4, 4) by instance, and instances with the vertices (m, 3) of their meshes.
using NeighbourArguments = std::tuple<Camera, py::array, std::vector<std::pair<std::uint32_t, py::array>>>;

static render::NeighbourFrame make_neighbour(const NeighbourArguments& arguments) {
    const auto& [camera, matrices, deformed] = arguments;
    render::NeighbourFrame frame{.camera = camera};
    for (const auto& matrix : to_vector<std::array<float, 16>, float>(matrices, {-1, 4, 4}, "there_from_here"))
        frame.there_from_here.push_back(to_matrix<mat4, 4>(matrix.data()));
    for (const auto& [instance, vertices] : deformed)
        frame.vertices.emplace(instance, to_vector<vec3, float>(vertices, {-1, 3}, "vertices"));
    return frame;
}

static render::DataPassConfig
make_data(const std::vector<std::string>& passes, std::uint32_t matte_ranks,
          std::unordered_map<std::string, std::string> asset_of,
          std::unordered_map<std::string, std::string> material_alias,
          std::unordered_map<std::string, float> material_index, const std::array<float, 3>& mist,
          const std::vector<std::tuple<std::string, bool, std::unordered_map<std::uint32_t, std::uint32_t>>>& aovs,
          const std::optional<std::pair<NeighbourArguments, NeighbourArguments>>& neighbours) {
    render::DataPassConfig data{.bits = 0,
                                .matte_ranks = matte_ranks,
                                .asset_of = std::move(asset_of),
                                .material_alias = std::move(material_alias),
                                .material_index = std::move(material_index),
                                .mist = {.start_m = mist[0], .depth_m = mist[1], .exponent = mist[2]}};
    for (const auto& [name, is_colour, program_of] : aovs)
        data.aovs.push_back({name, is_colour, program_of});
    if (neighbours)
        data.neighbours = std::make_shared<const render::NeighbourFrames>(
            render::NeighbourFrames{make_neighbour(neighbours->first), make_neighbour(neighbours->second)});
    for (const std::string& name : passes)
        data.add(name);
    return data;
}

static render::FrameConfig
make_config(std::uint32_t pixel_samples, int pixel_filter, float filter_width_px, float noise_threshold,
            const std::optional<std::array<std::uint32_t, 4>>& region_px, float voxel_detail_px, bool film_transparent,
            const std::vector<std::string>& passes, float pass_alpha_threshold, render::DataPassConfig data,
            std::vector<std::string> light_groups, const light_shafts::Config& shafts,
            std::vector<transfer_functions::WeightedFunction> functions, std::optional<std::uint32_t> reference_light,
            std::optional<Heterogeneity> heterogeneity, const render::IndirectConfig& indirect,
            const std::optional<std::shared_ptr<render::KeptSurfaces>>& kept_surfaces,
            const std::shared_ptr<render::KeptLightTrees>& kept_light_trees, bool adapts_shadow_rays,
            bool lights_take_turns, bool keeps_unstyled, std::uint32_t seed, int thread_count, bool is_tile,
            std::uint32_t first_sample, std::uint32_t sample_count) {
    render::FrameConfig config{.pixel_samples = pixel_samples,
                               .first_sample = first_sample,
                               .sample_count = sample_count,
                               .pixel_filter = static_cast<render::PixelFilter>(pixel_filter),
                               .filter_width_px = filter_width_px,
                               .noise_threshold = noise_threshold,
                               .region = {},
                               .is_tile = is_tile,
                               .voxel_detail_px = voxel_detail_px,
                               .is_film_transparent = film_transparent,
                               .passes = {},
                               .pass_alpha_threshold = pass_alpha_threshold,
                               .data = std::move(data),
                               .light_groups = std::move(light_groups),
                               .shafts = shafts,
                               .transfer_functions = std::move(functions),
                               .reference_light = reference_light,
                               .heterogeneity = std::move(heterogeneity),
                               .indirect = indirect,
                               .kept_surfaces = kept_surfaces.value_or(nullptr),
                               .kept_light_trees = kept_light_trees,
                               .adapts_shadow_rays = adapts_shadow_rays,
                               .lights_take_turns = lights_take_turns,
                               .keeps_unstyled = keeps_unstyled,
                               .seed = seed,
                               .thread_count = thread_count};
    if (region_px)
        config.region = render::Region{(*region_px)[0], (*region_px)[1], (*region_px)[2], (*region_px)[3]};
    for (const std::string& name : passes)
        config.passes.add(render::pass_named(name));
    return config;
}

/// The planes by name, float32 (height, width, channels).
static py::dict to_planes(render::Film& film) {
    py::dict planes;
    for (render::Plane& plane : film.planes) {
        const render::PassLayout& layout = render::layout(plane.pass);
        planes[py::str(std::string(layout.name))] =
            to_numpy(std::move(plane.values), {film.height_px, film.width_px, layout.channel_count});
    }
    for (render::NamedPlane& plane : film.data_planes)
        planes[py::str(plane.name)] =
            to_numpy(std::move(plane.values), {film.height_px, film.width_px, plane.channel_count});
    return planes;
}

using Unstyled = std::shared_ptr<const render::UnstyledFilm>;

static std::tuple<py::dict, Statistics, Unstyled> render_film(const SceneWithMedia& built, const Camera& camera,
                                                              const render::FrameConfig& config, Progress& progress,
                                                              const std::optional<py::function>& on_update) {
    render::OnUpdate update;
    if (on_update)
        update = [&](render::Film film) {
            const py::gil_scoped_acquire acquired;
            (*on_update)(to_planes(film));
        };
    render::Film film =
        without_gil([&] { return render::render(*built.scene, *built.media, camera, config, progress, update); });
    return {to_planes(film), std::move(film.statistics), std::move(film.unstyled)};
}

static py::dict restyle(const Unstyled& unstyled, std::vector<transfer_functions::WeightedFunction> functions,
                        const Progress& progress) {
    render::Film film = without_gil([&] { return render::styled(*unstyled, std::move(functions), progress); });
    return to_planes(film);
}

static py::array find_ray_parameters(const SceneWithMedia& built, const Camera& camera,
                                     const render::FrameConfig& config, const py::array& places_px,
                                     Progress& progress) {
    const auto places = to_vector<vec2, float>(places_px, {-1, 2}, "places_px");
    const std::vector<vec2> found = without_gil(
        [&] { return render::ray_parameters(*built.scene, *built.media, camera, config, places, progress); });
    std::vector<float> numbers;
    for (const vec2& parameters : found)
        numbers.insert(numbers.end(), {parameters.x, parameters.y});
    return to_numpy(std::move(numbers), {static_cast<py::ssize_t>(found.size()), 2});
}

static std::pair<py::array, py::array> make_light_depth(const SceneWithMedia& built, std::size_t light,
                                                        std::uint32_t resolution, const Progress& progress) {
    light_shafts::LightDepthPicture picture =
        without_gil([&] { return light_shafts::light_depth_picture(*built.scene, light, resolution, progress); });
    return {to_numpy(std::move(picture.before), {picture.height, picture.width}),
            to_numpy(std::move(picture.after), {picture.height, picture.width})};
}

void bind_render(py::module_& native) {
    py::class_<Camera>(native, "Camera")
        .def(py::init(&make_camera), "kind"_a, "world_from_camera"_a, "window"_a, "clip_m"_a, "size_px"_a,
             "lens_radius_m"_a = 0.0f, "focus_m"_a = 1.0f, "blades"_a = 0, "blades_rotation_rad"_a = 0.0f,
             "aperture_ratio"_a = 1.0f, "air_u"_a = py::none(), "panorama_kind"_a = 0,
             "rim"_a = std::numeric_limits<float>::infinity(), "angle_by_radius"_a = std::array<float, 5>{},
             "world_from_camera: float32 (4, 4), relative to the scene's origin.")
        .def(
            "require_usable", [](const Camera& camera) { require_usable(camera); },
            "InvalidInput: it cannot be rendered with; which of its numbers, if any, is not finite.")
        .def("ray_through", &ray_through, "x_px"_a, "y_px"_a,
             "Origin, at the near clip, and unit direction; None: beside what the camera shows.")
        .def("raster_position", &raster_position, "x_m"_a, "y_m"_a, "z_m"_a,
             "Where it shows a point, in pixels from the left and bottom of its full frame; None: nowhere.");
    py::class_<light_shafts::MapCache, std::shared_ptr<light_shafts::MapCache>>(
        native, "MapCache",
        "What occluders cast, kept from frame to frame, in at most so many bytes. Safe from any thread.")
        .def(py::init<std::size_t>(), "capacity_bytes"_a)
        .def_property_readonly("bytes", &light_shafts::MapCache::bytes);
    py::class_<render::KeptSurfaces, std::shared_ptr<render::KeptSurfaces>>(
        native, "KeptSurfaces",
        "What camera rays met, kept from picture to picture, in at most so many bytes. For one thread at a time.")
        .def(py::init<std::size_t>(), "capacity_bytes"_a)
        .def_property_readonly("bytes", &render::KeptSurfaces::bytes);
    py::class_<render::KeptLightTrees, std::shared_ptr<render::KeptLightTrees>>(
        native, "KeptLightTrees",
        "Trees of lights, kept from picture to picture, in at most so many bytes. For one thread at a time.")
        .def(py::init<std::size_t>(), "capacity_bytes"_a);
    py::class_<light_shafts::KeptStrata, std::shared_ptr<light_shafts::KeptStrata>>(
        native, "KeptStrata", "How many strata lights have in a series of pictures. For one thread at a time.")
        .def(py::init<>());
    py::class_<light_shafts::Config>(native, "ShaftConfig")
        .def(py::init(&make_shafts), "method"_a, "error_target"_a, "resolution"_a, "light_samples"_a, "world_samples"_a,
             "attenuates_light"_a, "adapts_strata"_a, "shares_strata"_a, "grid_method"_a, "grid_error_target"_a,
             "walks_maps"_a, "seed"_a, "part"_a, "part_has_own_view"_a, "kept_strata"_a = py::none(),
             "kept_maps"_a = py::none(), "room_bytes"_a = py::none());
    py::class_<render::IndirectConfig>(native, "IndirectConfig")
        .def(py::init(&make_indirect), "ambient_occlusion"_a, "ambient_distance_m"_a, "ambient_samples"_a, "bounce"_a,
             "bounce_samples"_a, "mirror_depth"_a, "refraction_depth"_a);
    py::class_<render::DataPassConfig>(native, "DataPasses")
        .def(py::init(&make_data), "passes"_a, "matte_ranks"_a, "asset_of"_a, "material_alias"_a, "material_index"_a,
             "mist"_a, "aovs"_a, "neighbours"_a = py::none(),
             "mist: start and depth in metres, and exponent. aovs: name, whether it is a colour, and by material "
             "what has its values. InvalidInput: a name that is none.");
    native.def(
        "matte_hash", [](const std::string& name) { return render::matte_hash(name); }, "name"_a,
        "32 bits that Cryptomattes know a name by.");
    py::class_<render::FrameConfig>(native, "FrameConfig")
        .def(py::init(&make_config), "pixel_samples"_a, "pixel_filter"_a, "filter_width_px"_a, "noise_threshold"_a,
             "region_px"_a, "voxel_detail_px"_a, "film_transparent"_a, "passes"_a, "pass_alpha_threshold"_a, "data"_a,
             "light_groups"_a, "shafts"_a, "transfer_functions"_a, "reference_light"_a, "heterogeneity"_a, "indirect"_a,
             "kept_surfaces"_a, "kept_light_trees"_a, "adapts_shadow_rays"_a, "lights_take_turns"_a, "keeps_unstyled"_a,
             "seed"_a, "thread_count"_a, "is_tile"_a, "first_sample"_a = 0, "sample_count"_a = 0);
    py::class_<render::UnstyledFilm, std::shared_ptr<render::UnstyledFilm>>(native, "UnstyledFilm");
    native.def(
        "render", &render_film, "scene"_a, "camera"_a, "config"_a, "progress"_a, "on_update"_a = py::none(),
        R"(Planes by name, float32 (height, width, channels), rows bottom to top; statistics; and what restyle takes, or None.

on_update is called with the planes so far about twice a second. Releases the GIL. InvalidInput; Cancelled.)");
    native.def("restyle", &restyle, "unstyled"_a, "transfer_functions"_a, "progress"_a,
               R"(The planes of a frame under changed layers of its transfer functions; their axes are the frame's.

A constraint with a point that the frame had not keeps its position. Releases the GIL. InvalidInput; Cancelled.)");
    native.def("ray_parameters", &find_ray_parameters, "scene"_a, "camera"_a, "config"_a, "places_px"_a, "progress"_a,
               R"(Where the rays through raster positions, float32 (n, 2), are in the first transfer function: (n, 2).

Releases the GIL. InvalidInput; Cancelled.)");
    native.def("light_depth_picture", &make_light_depth, "scene"_a, "light"_a, "resolution"_a, "progress"_a,
               R"(A light's depth map before and after its occluder edits, float32 (height, width), rows bottom to top.

0 is nearest to the light, 1 farthest or nothing; a point light's faces lie three by two. Edits along the view do not
show. light: into the scene's lights. Releases the GIL. InvalidInput; Cancelled.)");
}
} // namespace tyndall::bindings
