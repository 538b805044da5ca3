// SPDX-License-Identifier: GPL-3.0-or-later
#include "transfer_functions/layer_colours.hpp"
#include <algorithm>

namespace tyndall::transfer_functions {
namespace {
vec4 gradient_at(const Layer& layer, vec2 place) {
    const vec2 way = layer.to - layer.from, gone = place - layer.from;
    const float length2 = glm::dot(way, way);
    float share = 1.0f;
    if (length2 > 0.0f)
        share = layer.shape == GradientShape::Linear ? glm::dot(gone, way) / length2
                                                     : std::sqrt(glm::dot(gone, gone) / length2);
    const float position = glm::clamp(share, 0.0f, 1.0f) * static_cast<float>(layer.ramp.size() - 1);
    const auto lower = std::min(static_cast<std::size_t>(position), layer.ramp.size() - 2);
    return glm::mix(layer.ramp[lower], layer.ramp[lower + 1], position - static_cast<float>(lower));
}

} // namespace

bool has_say(const Layer& layer) {
    const auto is_seen = [](const vec4& colour) { return colour.w > 0.0f; };
    if (layer.opacity <= 0.0f)
        return false;
    switch (layer.kind) {
    case LayerKind::Solid:
        return is_seen(layer.colour);
    case LayerKind::Gradient:
        return std::ranges::any_of(layer.ramp, is_seen);
    case LayerKind::Diffusion:
        return std::ranges::any_of(layer.constraints, is_seen, &Constraint::colour);
    case LayerKind::Image:
        return true;
    }
    return false;
}

LayerColours::LayerColours(const Layer& layer, std::uint32_t size, const Progress& progress)
    : layer_(layer), size_(size) {
    if (layer.kind == LayerKind::Diffusion)
        diffusion_.emplace(layer.constraints, layer.smoothness, size, progress);
    if (layer.kind == LayerKind::Image)
        image_.emplace(*layer.image, size);
}

void LayerColours::row(std::uint32_t row, std::span<vec4> colours) const {
    switch (layer_.kind) {
    case LayerKind::Solid:
        std::ranges::fill(colours, layer_.colour);
        break;
    case LayerKind::Gradient:
        for (std::uint32_t column = 0; column < size_; ++column)
            colours[column] = gradient_at(layer_, (vec2(static_cast<float>(column), static_cast<float>(row)) + 0.5f) /
                                                      static_cast<float>(size_));
        break;
    case LayerKind::Diffusion:
        diffusion_->row(row, colours);
        break;
    case LayerKind::Image:
        image_->row(row, colours);
        break;
    }
}
} // namespace tyndall::transfer_functions
