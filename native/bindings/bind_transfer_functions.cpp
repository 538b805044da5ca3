// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "core/errors.hpp"
#include "transfer_functions/compose.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
namespace tf = transfer_functions;

using Pair = std::array<float, 2>;
using Quadruple = std::array<float, 4>;
static vec2 to_vec2(const Pair& pair) { return {pair[0], pair[1]}; }
static vec4 to_vec4(const Quadruple& quadruple) { return {quadruple[0], quadruple[1], quadruple[2], quadruple[3]}; }

static tf::ParameterAxis make_axis(int axis, const Pair& range_m, float full_visibility,
                                   const std::optional<std::shared_ptr<Texture>>& mask) {
    return {.axis = static_cast<tf::Axis>(axis),
            .low_m = range_m[0],
            .high_m = range_m[1],
            .full_visibility = full_visibility,
            .mask = mask.value_or(nullptr)};
}

static tf::Constraint make_constraint(const Pair& position, const Quadruple& colour,
                                      const std::optional<Triple>& point) {
    tf::Constraint constraint{.position = to_vec2(position), .colour = to_vec4(colour), .point = {}};
    if (point)
        constraint.point = to_vec3(*point);
    return constraint;
}

static tf::Layer make_layer(std::string name, int kind, int mode, float opacity, const Quadruple& colour,
                            const std::vector<Quadruple>& ramp, int shape, const Pair& start, const Pair& end,
                            std::vector<tf::Constraint> constraints, float smoothness,
                            const std::optional<std::shared_ptr<Texture>>& image) {
    tf::Layer layer{.name = std::move(name),
                    .kind = static_cast<tf::LayerKind>(kind),
                    .mode = static_cast<tf::BlendMode>(mode),
                    .opacity = opacity,
                    .colour = to_vec4(colour),
                    .ramp = {},
                    .shape = static_cast<tf::GradientShape>(shape),
                    .from = to_vec2(start),
                    .to = to_vec2(end),
                    .constraints = std::move(constraints),
                    .smoothness = smoothness,
                    .image = image.value_or(nullptr)};
    for (const Quadruple& of_ramp : ramp)
        layer.ramp.push_back(to_vec4(of_ramp));
    require_usable(layer);
    return layer;
}

static tf::TransferFunction make_function(std::string name, const tf::ParameterAxis& x, const tf::ParameterAxis& y,
                                          int use, float strength, std::vector<tf::Layer> layers) {
    tf::TransferFunction function{.name = std::move(name),
                                  .x = x,
                                  .y = y,
                                  .use = static_cast<tf::Use>(use),
                                  .strength = strength,
                                  .layers = std::move(layers)};
    require_usable(function);
    return function;
}

static tf::WeightedFunction make_weighted(tf::TransferFunction function, float weight) {
    require_in(weight, 0.0f, 1.0f, "weight");
    return {.function = std::move(function), .weight = weight};
}

static py::array_t<float> compose_picture(const tf::TransferFunction& function, std::uint32_t size,
                                          const Progress& progress) {
    const tf::ComposedFunction composed = without_gil([&] { return tf::compose(function, size, progress); });
    std::vector<float> values(std::size_t{4} * size * size, 0.0f);
    if (!composed.is_neutral())
        std::memcpy(values.data(), composed.texels.data(), values.size() * sizeof(float));
    const auto side = static_cast<py::ssize_t>(size);
    return to_numpy(std::move(values), {side, side, 4});
}

void bind_transfer_functions(py::module_& native) {
    py::class_<tf::ParameterAxis>(native, "ParameterAxis")
        .def(py::init(&make_axis), "axis"_a, "range_m"_a, "full_visibility"_a, "mask"_a);
    py::class_<tf::Constraint>(native, "Constraint")
        .def(py::init(&make_constraint), "position"_a, "colour"_a, "point"_a,
             "point: relative to the scene's origin, or None.");
    py::class_<tf::Layer>(native, "TransferLayer")
        .def(py::init(&make_layer), "name"_a, "kind"_a, "mode"_a, "opacity"_a, "colour"_a, "ramp"_a, "shape"_a,
             "start"_a, "end"_a, "constraints"_a, "smoothness"_a, "image"_a,
             "InvalidInput names the layer and what is out of its range.");
    py::class_<tf::TransferFunction>(native, "TransferFunction")
        .def(py::init(&make_function), "name"_a, "x"_a, "y"_a, "use"_a, "strength"_a, "layers"_a,
             "InvalidInput names what is out of its range.");
    py::class_<tf::WeightedFunction>(native, "WeightedFunction")
        .def(py::init(&make_weighted), "function"_a, "weight"_a, "weight: [0, 1].");
    native.def("compose_transfer_function", &compose_picture, "function"_a, "size"_a, "progress"_a,
               R"(The layers as one picture, float32 (size, size, 4): RGB multiplied with alpha, rows bottom to top.

Texel [j, i] holds the function at ((i + 1/2) / size, (j + 1/2) / size). 0 everywhere where no layer has a say. Releases
the GIL. Raises InvalidInput and Cancelled.)");
}
} // namespace tyndall::bindings
