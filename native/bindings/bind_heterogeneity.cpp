// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "volume/air_noise.hpp"
#include "volume/baked_air.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static PaintedVolume to_volume(const std::optional<py::array>& values, const char* name) {
    PaintedVolume volume;
    if (!values)
        return volume;
    volume.values = to_vector<float, float>(*values, {-1, -1, -1}, name);
    for (std::size_t axis = 0; axis < 3; ++axis)
        volume.size[axis] = static_cast<std::uint32_t>(values->shape(static_cast<py::ssize_t>(2 - axis)));
    return volume;
}

/// Python's integers have a sign.
static std::uint32_t natural(std::int64_t number, const char* name) {
    require(0 <= number && number <= std::numeric_limits<std::uint32_t>::max(), name, " is ", number);
    return static_cast<std::uint32_t>(number);
}

static std::shared_ptr<PaintedAir> make_painted(const std::optional<py::array>& amount,
                                                const std::optional<py::array>& level,
                                                const std::optional<py::array>& intensity) {
    return std::make_shared<PaintedAir>(to_volume(amount, "amount"), to_volume(level, "level"),
                                        to_volume(intensity, "intensity"));
}

static Heterogeneity make_heterogeneity(float scale_m, std::int64_t octaves, float persistence, float contrast,
                                        std::int64_t resolution, std::int64_t seed,
                                        const std::array<double, 3>& moved_m, float amount, float level,
                                        float intensity, int weighting, std::int64_t step_count,
                                        std::int64_t upsampling, const py::array& unit_from_scene,
                                        const std::optional<std::shared_ptr<PaintedAir>>& painted,
                                        const std::optional<std::shared_ptr<AirNoiseCache>>& kept_noise) {
    const Heterogeneity heterogeneity{.noise = {.scale_m = scale_m,
                                                .octaves = natural(octaves, "octaves of the air's noise"),
                                                .persistence = persistence,
                                                .contrast = contrast,
                                                .resolution = natural(resolution, "resolution of the air's noise"),
                                                .seed = natural(seed, "seed of the air's noise")},
                                      .moved_m = {moved_m[0], moved_m[1], moved_m[2]},
                                      .amount = amount,
                                      .level = level,
                                      .intensity = intensity,
                                      .weighting = static_cast<Heterogeneity::Weighting>(weighting),
                                      .step_count = natural(step_count, "step_count of heterogeneity"),
                                      .upsampling = natural(upsampling, "upsampling of heterogeneity"),
                                      .unit_from_scene = to_matrix<mat4, 4>(unit_from_scene, "unit_from_scene"),
                                      .painted = painted.value_or(nullptr),
                                      .kept_noise = kept_noise.value_or(nullptr)};
    require_usable(heterogeneity);
    return heterogeneity;
}

static py::array_t<float> baked(const Heterogeneity& heterogeneity, const std::array<std::int64_t, 3>& resolution,
                                const Progress& progress) {
    std::array<std::uint32_t, 3> size;
    for (std::size_t axis = 0; axis < 3; ++axis)
        size[axis] = natural(resolution[axis], "resolution of baked air");
    std::vector<float> values =
        without_gil([&] { return bake_air(AirTexture(heterogeneity, progress), size, progress); });
    return to_numpy(std::move(values), {resolution[2], resolution[1], resolution[0]});
}

void bind_heterogeneity(py::module_& native) {
    py::class_<AirNoiseCache, std::shared_ptr<AirNoiseCache>>(
        native, "AirNoiseCache", "The air's last noise volumes, kept from frame to frame. Safe from any thread.")
        .def(py::init<>());
    py::class_<PaintedAir, std::shared_ptr<PaintedAir>>(native, "PaintedAir")
        .def(py::init(&make_painted), "amount"_a, "level"_a, "intensity"_a,
             "float32 (nz, ny, nx) each, or None. InvalidInput names the first voxel that is out of its range.");
    py::class_<Heterogeneity>(native, "Heterogeneity")
        .def(py::init(&make_heterogeneity), "scale_m"_a, "octaves"_a, "persistence"_a, "contrast"_a, "resolution"_a,
             "seed"_a, "moved_m"_a, "amount"_a, "level"_a, "intensity"_a, "weighting"_a, "step_count"_a, "upsampling"_a,
             "unit_from_scene"_a, "painted"_a, "kept_noise"_a,
             "moved_m, unit_from_scene: in the scene's space. InvalidInput names what is out of its range.")
        .def("baked", &baked, "resolution"_a, "progress"_a,
             "What it is at the voxels' centres of the painted box, float32 (nz, ny, nx). Releases the GIL.");
}
} // namespace tyndall::bindings
