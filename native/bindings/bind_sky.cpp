// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "shading/direction_program.hpp"
#include "shading/sky/sky_model.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static sky::Air make_air(float altitude_m, float molecules, float aerosols, float ozone) {
    return {.altitude_m = altitude_m, .molecules = molecules, .aerosols = aerosols, .ozone = ozone};
}

static py::array_t<float> to_image(const std::vector<vec3>& pixels, std::uint32_t width, std::uint32_t height) {
    const auto* floats = reinterpret_cast<const float*>(pixels.data());
    return to_numpy(std::vector<float>(floats, floats + 3 * pixels.size()),
                    {static_cast<py::ssize_t>(height), static_cast<py::ssize_t>(width), 3});
}

static RayKind to_ray_kind(int kind) {
    require(kind >= 0 && kind <= static_cast<int>(RayKind::Transmission), "there is no ray of kind ", kind);
    return static_cast<RayKind>(kind);
}

void bind_sky(py::module_& native) {
    native.def(
        "sky_picture",
        [](int model, float altitude_m, float molecules, float aerosols, float ozone, float sun_elevation_rad,
           const Progress& progress) {
            const auto pixels = without_gil([&] {
                return sky::picture(static_cast<sky::Model>(model), make_air(altitude_m, molecules, aerosols, ozone),
                                    sun_elevation_rad, progress);
            });
            return to_image(pixels, sky::picture_width, sky::picture_height);
        },
        "model"_a, "altitude_m"_a, "molecules"_a, "aerosols"_a, "ozone"_a, "sun_elevation_rad"_a, "progress"_a,
        "CIE XYZ radiance, float32 (256, 512, 3), as shading/sky/sky_model.hpp lays it out. Releases the GIL. "
        "Cancelled.");
    native.def(
        "sun_irradiance_xyz",
        [](int model, float altitude_m, float molecules, float aerosols, float ozone, float elevation_rad) {
            const vec3 xyz = sky::sun_irradiance_xyz(static_cast<sky::Model>(model),
                                                     make_air(altitude_m, molecules, aerosols, ozone), elevation_rad);
            return to_numpy(std::vector<float>{xyz.x, xyz.y, xyz.z}, {3});
        },
        "model"_a, "altitude_m"_a, "molecules"_a, "aerosols"_a, "ozone"_a, "elevation_rad"_a,
        "CIE XYZ, W/m^2, of a sun seen at this height through the air.");
    py::class_<DirectionProgram, std::shared_ptr<DirectionProgram>>(native, "DirectionProgram",
                                                                    "A material's emission, by direction.")
        .def(py::init<Material>(), "material"_a)
        .def(
            "radiance",
            [](const DirectionProgram& program, const py::array& directions, int kind, const Progress& progress) {
                const auto points = to_vector<vec3, float>(directions, {-1, 3}, "directions");
                std::vector<float> values(3 * points.size());
                const std::span<Rgb> colours(reinterpret_cast<Rgb*>(values.data()), points.size());
                without_gil([&] { program.radiance(points, to_ray_kind(kind), colours, progress); });
                return to_numpy(std::move(values), {static_cast<py::ssize_t>(points.size()), 3});
            },
            "unit_directions"_a, "ray_kind"_a, "progress"_a, "Of float32 (n, 3): float32 (n, 3). Releases the GIL.")
        .def(
            "image",
            [](const DirectionProgram& program, std::uint32_t width, std::uint32_t height, int kind,
               const Progress& progress) {
                return to_image(without_gil([&] { return program.image(width, height, to_ray_kind(kind), progress); }),
                                width, height);
            },
            "width"_a, "height"_a, "ray_kind"_a, "progress"_a,
            "Equirectangular, float32 (height, width, 3), rows bottom to top. Releases the GIL. Cancelled.");
}
} // namespace tyndall::bindings
