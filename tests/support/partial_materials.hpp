// SPDX-License-Identifier: GPL-3.0-or-later
// Materials that let a part of the light pass: by an image's alpha, everywhere the same, or by the side they are seen from.
#pragma once
#include "shading/material.hpp"
#include "shading/op_images.hpp"
#include "shading/op_inputs.hpp"
#include "shading/op_math.hpp"
#include <numbers>

namespace tyndall::support {
/// Transparent where the image's alpha is 0.
inline Material alpha_of(Texture texture) {
    Material material{.name = texture.name};
    material.program = {{.code = SurfaceOp::Code::TextureAlpha, .out = 0},
                        {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(1.0f)},
                        {.code = SurfaceOp::Code::Subtract, .out = 2, .a = 1, .b = 0}};
    material.transparent_register = 2, material.diffuse_register = 0, material.emission_register = 3;
    material.textures = {std::make_shared<const Texture>(std::move(texture))};
    material.uv_map_names = {""};
    return material;
}
/// alpha(u, v) at the centres of size x size texels.
template <typename Alpha>
Texture alpha_image(std::string name, std::uint32_t size, const Alpha& alpha) {
    Texture texture{.name = std::move(name), .width = size, .height = size};
    std::vector<float> texels;
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) {
            const auto side = static_cast<float>(size);
            const float a = alpha((static_cast<float>(x) + 0.5f) / side, (static_cast<float>(y) + 0.5f) / side);
            texels.insert(texels.end(), {0.5f, 0.5f, 0.5f, a});
        }
    texture.floats = std::move(texels);
    texture.is_srgb = false, texture.has_alpha = true;
    return texture;
}
/// Fields of 1/3 by 1/5, so that u and v differ; unfiltered.
inline Material checkerboard_alpha() {
    Texture texture = alpha_image("checkerboard", 15, [](float u, float v) {
        return static_cast<float>((static_cast<int>(3 * u) + static_cast<int>(5 * v)) % 2);
    });
    texture.interpolation = TextureInterpolation::Closest;
    return alpha_of(std::move(texture));
}
/// An opaque disc aside of the middle, of 0 or 1 but for the filter between texels.
inline Material disc_alpha(TextureExtension extension = TextureExtension::Repeat) {
    Texture texture = alpha_image("disc", 256, [](float u, float v) {
        return (u - 0.35f) * (u - 0.35f) + 0.5f * (v - 0.6f) * (v - 0.6f) < 0.09f ? 1.0f : 0.0f;
    });
    texture.extension = extension;
    return alpha_of(std::move(texture));
}
/// Alpha that rises from 0 to 1 along u.
inline Material gradient_alpha() {
    Texture texture = alpha_image("gradient", 32, [](float u, float) { return u; });
    texture.extension = TextureExtension::Extend;
    return alpha_of(std::move(texture));
}
/// Transparent in stripes of the object's own space, 0.3 apart: of a surface without any image.
inline Material striped(const vec3& across = vec3(1.0f, 0.6f, 0.0f)) {
    Material material{.name = "striped"};
    const auto sine = static_cast<std::uint8_t>(MathOperation::Sine);
    const auto is_less = static_cast<std::uint8_t>(MathOperation::LessThan);
    const auto dot = static_cast<std::uint8_t>(VectorOperation::DotProduct);
    material.program = {
        {.code = SurfaceOp::Code::Input, .option = static_cast<std::uint8_t>(PointInput::ObjectPosition), .out = 0},
        {.code = SurfaceOp::Code::Constant, .out = 1, .value = (2.0f * std::numbers::pi_v<float> / 0.6f) * across},
        {.code = SurfaceOp::Code::VectorMath, .option = dot, .out = 2, .a = 0, .b = 1},
        {.code = SurfaceOp::Code::Math, .option = sine, .out = 3, .a = 2},
        {.code = SurfaceOp::Code::Constant, .out = 4, .value = Rgb(0.2f)},
        {.code = SurfaceOp::Code::Math, .option = is_less, .out = 5, .a = 3, .b = 4}};
    material.transparent_register = 5, material.diffuse_register = 6, material.emission_register = 6;
    return material;
}
/// An alpha image on the sides of a box around the object, by its normal.
inline Material boxed(Texture texture) {
    Material material = alpha_of(std::move(texture));
    material.program[0] = {.code = SurfaceOp::Code::ImageAlphaAt,
                           .option = static_cast<std::uint8_t>(ImageProjection::Box),
                           .out = 0,
                           .a = 3};
    material.program.insert(
        material.program.begin(),
        {.code = SurfaceOp::Code::Input, .option = static_cast<std::uint8_t>(PointInput::ObjectPosition), .out = 3});
    material.emission_register = 4;
    return material;
}
/// Transparent to rays that graze it.
inline Material transparent_at_edges() {
    Material material{.name = "edges"};
    material.program = {
        {.code = SurfaceOp::Code::Input, .option = static_cast<std::uint8_t>(PointInput::Normal), .out = 0},
        {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(0.5f)},
        {.code = SurfaceOp::Code::LayerWeight, .option = 1, .out = 2, .a = 1, .b = 0},
        {.code = SurfaceOp::Code::Math,
         .option = static_cast<std::uint8_t>(MathOperation::GreaterThan),
         .out = 2,
         .a = 2,
         .b = 1}};
    material.transparent_register = 2, material.diffuse_register = 3, material.emission_register = 3;
    return material;
}
inline Material pane(const Rgb& transparent) {
    Material material{.name = "pane"};
    material.constant.transparent = transparent;
    return material;
}
inline Material veil(float transparent) { return pane(Rgb(transparent)); }
/// Transparent from behind, opaque from the front.
inline Material one_way() {
    Material material{.name = "one way"};
    material.program = {{.code = SurfaceOp::Code::Backfacing, .out = 0}};
    material.transparent_register = 0, material.diffuse_register = 1, material.emission_register = 1;
    return material;
}
} // namespace tyndall::support
