// SPDX-License-Identifier: GPL-3.0-or-later
#include "transfer_functions/transfer_function.hpp"
#include "core/errors.hpp"

namespace tyndall::transfer_functions {
namespace {
constexpr float largest_colour = 1e6f;
constexpr float largest_position = 1e3f; ///< Of a gradient, in sides of the function.
constexpr std::size_t most_constraints = 256;

template <typename Enum>
void require_known(Enum value, Enum last, const std::string& name) {
    require(value <= last, name, " ", static_cast<int>(value), " is unknown");
}

void require_colour(const vec4& colour, const std::string& name) {
    for (int channel = 0; channel < 3; ++channel)
        require_in(colour[channel], 0.0f, largest_colour, name);
    require_in(colour.w, 0.0f, 1.0f, name + "'s alpha");
}

void require_place(vec2 place, float lowest, float highest, const std::string& name) {
    require_in(place.x, lowest, highest, name + "'s x");
    require_in(place.y, lowest, highest, name + "'s y");
}

void require_pixels(const Texture* image, const std::string& name) {
    require(image != nullptr, name, " is missing");
    require(image->width > 0 && image->height > 0, name, " \"", image->name, "\" has no pixels");
}

void require_axis(const ParameterAxis& axis, const std::string& name) {
    require_known(axis.axis, Axis::Mask, name);
    require(std::isfinite(axis.low_m) && std::isfinite(axis.high_m), name, "'s range is not finite");
    require_in(axis.full_visibility, 0.0f, 1.0f, name + "'s full_visibility");
    if (axis.axis == Axis::Mask)
        require_pixels(axis.mask.get(), name + "'s mask");
}
} // namespace

void require_usable(const Layer& layer) {
    const std::string name = "layer \"" + layer.name + "\": ";
    require_known(layer.kind, LayerKind::Image, name + "kind");
    require_known(layer.mode, BlendMode::Value, name + "blend mode");
    require_in(layer.opacity, 0.0f, 1.0f, name + "opacity");
    switch (layer.kind) {
    case LayerKind::Solid:
        require_colour(layer.colour, name + "colour");
        break;
    case LayerKind::Gradient:
        require_known(layer.shape, GradientShape::Radial, name + "shape");
        require(layer.ramp.size() >= 2, name, "its ramp has ", layer.ramp.size(), " colours, not 2 or more");
        for (std::size_t i = 0; i < layer.ramp.size(); ++i)
            require_colour(layer.ramp[i], name + "ramp colour " + std::to_string(i));
        require_place(layer.from, -largest_position, largest_position, name + "start");
        require_place(layer.to, -largest_position, largest_position, name + "end");
        break;
    case LayerKind::Diffusion:
        require_in(layer.smoothness, 0.0f, 1.0f, name + "smoothness");
        require(layer.constraints.size() <= most_constraints, name, "it has ", layer.constraints.size(),
                " constraints, more than ", most_constraints);
        for (std::size_t i = 0; i < layer.constraints.size(); ++i) {
            const std::string constraint = name + "constraint " + std::to_string(i);
            require_place(layer.constraints[i].position, 0.0f, 1.0f, constraint);
            require_colour(layer.constraints[i].colour, constraint + "'s colour");
        }
        break;
    case LayerKind::Image:
        require_pixels(layer.image.get(), name + "image");
        break;
    }
}

void require_usable(const TransferFunction& function) {
    require_axis(function.x, "x axis");
    require_axis(function.y, "y axis");
    require_known(function.use, Use::Tint, "use");
    require_in(function.strength, 0.0f, 1e6f, "strength");
    for (const Layer& layer : function.layers)
        require_usable(layer);
}
} // namespace tyndall::transfer_functions
