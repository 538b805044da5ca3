// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_strokes.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace light_shafts;

static StrokePicture make_picture(std::string name, const py::array& texels) {
    StrokePicture picture{.name = std::move(name), .texels = to_vector<vec4, float>(texels, {-1, -1, 4}, "texels")};
    picture.height = static_cast<std::uint32_t>(texels.shape(0));
    picture.width = static_cast<std::uint32_t>(texels.shape(1));
    return picture;
}

static LightMap make_map(const py::array& texels, float size_m, const std::array<float, 2>& centre_m) {
    LightMap map{.place = {.size_m = size_m, .centre_m = {centre_m[0], centre_m[1]}},
                 .texels = to_vector<Rgb, float>(texels, {-1, -1, 3}, "texels")};
    require(texels.shape(0) == texels.shape(1), "a light map is square, not ", texels.shape(1), " x ", texels.shape(0));
    map.place.resolution = static_cast<std::uint32_t>(texels.shape(0));
    return map;
}

/// A fit with the scene that its strokes are in, and its own number of threads.
struct BoundFit {
    std::unique_ptr<LightMapFit> fit;
    int thread_count;
};

static std::unique_ptr<BoundFit> make_fit(const SceneWithMedia& built,
                                          const std::vector<std::pair<Camera, StrokePicture*>>& views,
                                          const LightMap& current, std::size_t light, std::uint32_t resolution,
                                          float regularisation, std::size_t most_pixels, const Config& shafts,
                                          int thread_count, Progress& progress) {
    return without_gil([&] {
        return with_threads(thread_count, [&] {
            std::vector<Strokes> strokes;
            for (const auto& [camera, picture] : views)
                strokes.push_back(find_strokes(*built.scene, camera, *picture, most_pixels, progress));
            const LightMapFitConfig config{
                .light = light, .resolution = resolution, .regularisation = regularisation, .shafts = shafts};
            return std::make_unique<BoundFit>(
                BoundFit{std::make_unique<LightMapFit>(*built.scene, *built.media, strokes, current, config, progress),
                         thread_count});
        });
    });
}

static py::array map_texels(const BoundFit& bound) {
    const LightMap map = bound.fit->map();
    std::vector<float> texels(3 * map.texels.size());
    if (!texels.empty())
        std::memcpy(texels.data(), map.texels.data(), texels.size() * sizeof(float));
    return to_numpy(std::move(texels), {map.place.resolution, map.place.resolution, 3});
}

static py::array history(const BoundFit& bound) {
    std::vector<double> rows;
    for (const FitStep& step : bound.fit->history()) {
        rows.push_back(step.residual);
        rows.insert(rows.end(), step.objective.begin(), step.objective.end());
    }
    const auto count = static_cast<py::ssize_t>(rows.size() / 4);
    return to_numpy(std::move(rows), {count, 4});
}

void bind_light_map_fit(py::module_& native) {
    py::class_<StrokePicture>(native, "StrokePicture")
        .def(py::init(&make_picture), "name"_a, "texels"_a,
             "texels: float32 (height, width, 4), rows bottom to top, not multiplied with alpha; keeps a copy.");
    py::class_<LightMap>(native, "LightMap")
        .def(py::init<>(), "White.")
        .def(py::init(&make_map), "texels"_a, "size_m"_a, "centre_m"_a,
             "texels: float32 (n, n, 3), rows bottom to top; keeps a copy.");
    py::class_<BoundFit>(native, "LightMapFit")
        .def(py::init(&make_fit), "scene"_a, "views"_a, "current"_a, "light"_a, "resolution"_a, "regularisation"_a,
             "most_pixels"_a, "shafts"_a, "thread_count"_a, "progress"_a,
             "views: pairs of a camera and its strokes. Releases the GIL. InvalidInput; Cancelled.")
        .def(
            "iterate",
            [](BoundFit& bound, std::uint32_t step_count, Progress& progress) {
                return without_gil([&] {
                    return with_threads(bound.thread_count, [&] { return bound.fit->iterate(step_count, progress); });
                });
            },
            "step_count"_a, "progress"_a, "False: it is as good as it gets. Releases the GIL. Cancelled.")
        .def_property_readonly("texels", &map_texels, "float32 (n, n, 3), rows bottom to top.")
        .def_property_readonly("size_m", [](const BoundFit& bound) { return bound.fit->place().size_m; })
        .def_property_readonly("centre_m",
                               [](const BoundFit& bound) {
                                   const vec2 centre_m = bound.fit->place().centre_m;
                                   return std::pair{centre_m.x, centre_m.y};
                               })
        .def_property_readonly("history", &history,
                               "float64 (steps + 1, 4): residual, and the objective of each channel.")
        .def_property_readonly("statistics", [](const BoundFit& bound) { return bound.fit->statistics(); });
}
} // namespace tyndall::bindings
