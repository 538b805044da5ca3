// SPDX-License-Identifier: GPL-3.0-or-later
// Bound: an image costs up to 64 look-ups per texel, where it has 8 times as many pixels per side as the picture.
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

/// Mean over a texel: of one look-up at its middle, or of as many as the image has pixels there.
vec4 image_at(const Texture& image, vec2 corner, float texel_size) {
    const auto look_ups = [&](std::uint32_t pixels) {
        return std::clamp(static_cast<int>(std::lround(static_cast<float>(pixels) * texel_size)), 1, 8);
    };
    const int columns = look_ups(image.width), rows = look_ups(image.height);
    if (columns == 1 && rows == 1)
        return image.lookup(corner + 0.5f * texel_size);
    vec4 sum(0.0f); // of colours multiplied with alpha: what is transparent has no colour to give
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const vec2 share((static_cast<float>(x) + 0.5f) / static_cast<float>(columns),
                             (static_cast<float>(y) + 0.5f) / static_cast<float>(rows));
            const vec4 colour = image.lookup(corner + texel_size * share);
            sum += vec4(vec3(colour) * colour.w, colour.w);
        }
    return sum.w > 0.0f ? vec4(vec3(sum) / sum.w, sum.w / static_cast<float>(columns * rows)) : vec4(0.0f);
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
}

void LayerColours::row(std::uint32_t row, std::span<vec4> colours) const {
    const float texel_size = 1.0f / static_cast<float>(size_);
    if (layer_.kind == LayerKind::Diffusion)
        diffusion_->row(row, colours);
    else
        for (std::uint32_t column = 0; column < size_; ++column) {
            const vec2 corner(static_cast<float>(column) * texel_size, static_cast<float>(row) * texel_size);
            colours[column] = layer_.kind == LayerKind::Solid      ? layer_.colour
                              : layer_.kind == LayerKind::Gradient ? gradient_at(layer_, corner + 0.5f * texel_size)
                                                                   : image_at(*layer_.image, corner, texel_size);
        }
}
} // namespace tyndall::transfer_functions
