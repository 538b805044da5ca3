// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "scene/light_texture.hpp"
#include "shading/emitter_program.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static std::shared_ptr<FilteredTexture> make_filtered(const std::shared_ptr<Texture>& texture) {
    return without_gil([&] { return std::make_shared<FilteredTexture>(texture); });
}

static std::shared_ptr<LightTexture>
make_light_texture(const std::shared_ptr<FilteredTexture>& image, int projection, float width_m,
                   const std::array<float, 2>& centre_m, bool follows_normal,
                   const std::array<float, 9>& axes_from_world, const std::array<float, 12>& place_from_axes,
                   const std::array<float, 9>& uv_from_projected, const Triple& offset,
                   const std::array<float, 9>& gain, std::uint8_t distance_power, float smooth_m2) {
    const vec2 size = image->size();
    const std::array<float, 12>& rows = place_from_axes;
    auto texture = std::make_shared<LightTexture>(
        LightTexture{.image = image,
                     .projection = static_cast<LightProjection>(projection),
                     .size_m = {width_m, width_m * size.y / size.x},
                     .centre_m = {centre_m[0], centre_m[1]},
                     .follows_normal = follows_normal,
                     .axes_from_world = to_matrix<mat3, 3>(axes_from_world.data()),
                     .place_from_axes = {vec3(rows[0], rows[4], rows[8]), vec3(rows[1], rows[5], rows[9]),
                                         vec3(rows[2], rows[6], rows[10]), vec3(rows[3], rows[7], rows[11])},
                     .uv_from_projected = to_matrix<mat3, 3>(uv_from_projected.data()),
                     .offset = to_vec3(offset),
                     .gain = to_matrix<mat3, 3>(gain.data()),
                     .distance_power = distance_power,
                     .smooth_m2 = smooth_m2});
    require_usable(*texture);
    return texture;
}

/// Colour with alpha, pass index, random number.
static EmitterObject to_object(const std::array<float, 6>& numbers) {
    const auto& [red, green, blue, alpha, index, random] = numbers;
    return {.info = {.color = {red, green, blue, alpha}, .pass_index = index}, .random = random};
}

static py::array_t<float> emitter_image(const EmitterProgram& program, const std::array<float, 16>& world_from_object,
                                        const std::array<float, 2>& size, bool is_object,
                                        const std::array<float, 6>& object, std::uint32_t width, std::uint32_t height,
                                        const Progress& progress) {
    constexpr std::uint32_t largest = 1u << 14;
    require(width > 0 && height > 0 && width <= largest && height <= largest, "a picture of ", width, " x ", height,
            " texels");
    const FlatEmitter emitter{.world_from_object = to_matrix<mat4, 4>(world_from_object.data()),
                              .size = {size[0], size[1]},
                              .is_object = is_object,
                              .object = to_object(object)};
    const std::vector<Rgb> pixels = without_gil([&] { return program.image(emitter, width, height, progress); });
    const auto* floats = reinterpret_cast<const float*>(pixels.data());
    return to_numpy(std::vector<float>(floats, floats + 3 * pixels.size()),
                    {static_cast<py::ssize_t>(height), static_cast<py::ssize_t>(width), 3});
}

static py::array_t<float> leaving_lamp(const EmitterProgram& program, const std::array<float, 16>& world_from_object,
                                       const Triple& middle, float radius_m, const std::array<float, 6>& object,
                                       const py::array& points, const Progress& progress) {
    static_assert(sizeof(EmitterPoint) == 7 * sizeof(float));
    const std::vector<EmitterPoint> read = to_vector<EmitterPoint, float>(points, {-1, 7}, "points");
    const LocalEmitter lamp{.world_from_object = to_matrix<mat4, 4>(world_from_object.data()),
                            .middle = to_vec3(middle),
                            .radius_m = radius_m,
                            .object = to_object(object)};
    const std::vector<Rgb> colours = without_gil([&] { return program.leaving(lamp, read, progress); });
    const auto* floats = reinterpret_cast<const float*>(colours.data());
    return to_numpy(std::vector<float>(floats, floats + 3 * colours.size()),
                    {static_cast<py::ssize_t>(colours.size()), 3});
}

static void bind_emitter_program(py::module_& native) {
    py::class_<EmitterProgram, std::shared_ptr<EmitterProgram>>(native, "EmitterProgram",
                                                                "A material's emission over a light.")
        .def(py::init<Material>(), "material"_a)
        .def("image", &emitter_image, "world_from_object"_a, "size"_a, "is_object"_a, "object"_a, "width"_a, "height"_a,
             "progress"_a,
             "float32 (height, width, 3), rows along the light's +Y; world_from_object: 4x4, row by row. Releases the "
             "GIL. Cancelled.")
        .def("leaving", &leaving_lamp, "world_from_object"_a, "middle"_a, "radius_m"_a, "object"_a, "points"_a,
             "progress"_a,
             "float32 (n, 3) of a lamp; points: float32 (n, 7), each a unit direction in the world, a place on UV maps "
             "and "
             "barycentrics. Releases the GIL. Cancelled.");
}

void bind_light_textures(py::module_& native) {
    bind_emitter_program(native);
    py::class_<FilteredTexture, std::shared_ptr<FilteredTexture>>(native, "FilteredTexture")
        .def(py::init(&make_filtered), "texture"_a, "With its means over squares. Releases the GIL.");
    py::class_<LightTexture, std::shared_ptr<LightTexture>>(native, "LightTexture")
        .def(py::init(&make_light_texture), "image"_a, "projection"_a, "width_m"_a, "centre_m"_a, "follows_normal"_a,
             "axes_from_world"_a, "place_from_axes"_a, "uv_from_projected"_a, "offset"_a, "gain"_a, "distance_power"_a,
             "smooth_m2"_a,
             "axes_from_world, uv_from_projected and gain: 3x3, place_from_axes: 3x4, row by row. InvalidInput names "
             "what is "
             "out of its range.");
}
} // namespace tyndall::bindings
