// SPDX-License-Identifier: GPL-3.0-or-later
// A transfer function: layers of colour over two parameters of a view ray, and how that colour meets the light that the
// ray's media scatter.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.2; Barla, Thollot, Markosian, X-Toon, NPAR 2006.
// Differs:  the paper's axes are average visibility and depth; here any two of seven. Where its alpha is 0 the light stays
//           what it is, so that a function without layers is the physical picture.
#pragma once
#include "core/math.hpp"
#include "image/texture.hpp"
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tyndall::transfer_functions {
/// A parameter of a view ray, brought to [0, 1].
enum class Axis : std::uint8_t {
    AverageVisibility = 0, ///< Lit share of its length in media, over full_visibility.
    Depth = 1,             ///< Of its first surface, along the camera's axis, over the range; the sky is 1.
    MeanLitPosition = 2,   ///< Mean distance of its lit points, over the range; 0 where nothing is lit.
    LightAngle = 3,        ///< Between the ray and the way to the light, over pi: 0 looks into the light.
    OpticalDepth = 4,      ///< 1 - exp(-optical depth) up to its first surface, mean over the channels.
    Height = 5,            ///< World Z of its first surface over the range; the sky is 1.
    Mask = 6,              ///< A picture over the camera's frame.
};
struct ParameterAxis {
    Axis axis = Axis::AverageVisibility;
    /// Depth, MeanLitPosition, Height: what is 0 and what is 1. Where high_m <= low_m, fitted to what the frame shows.
    float low_m = 0.0f, high_m = 0.0f;
    float full_visibility = 0.0f; ///< AverageVisibility: what is 1, [0, 1]. 0: fitted to what the frame shows.
    std::shared_ptr<const Texture> mask = {}; ///< Mask: its luminance.
    [[nodiscard]] bool is_fitted() const {
        return axis == Axis::AverageVisibility ? full_visibility == 0.0f : high_m <= low_m;
    }
};

/// How the function's colour C meets the radiance L.
enum class Use : std::uint8_t {
    Replace = 0,  ///< strength * C
    Multiply = 1, ///< L * C
    Tint = 2,     ///< luminance(L) * C
};

/// Of a layer's colour with what lies below it, as Blender's Mix node names them.
enum class BlendMode : std::uint8_t {
    Mix = 0,
    Darken = 1,
    Multiply = 2,
    ColourBurn = 3,
    Lighten = 4,
    Screen = 5,
    ColourDodge = 6,
    Add = 7,
    Overlay = 8,
    SoftLight = 9,
    LinearLight = 10,
    Difference = 11,
    Exclusion = 12,
    Subtract = 13,
    Divide = 14,
    Hue = 15,
    Saturation = 16,
    Colour = 17,
    Value = 18,
};

enum class LayerKind : std::uint8_t { Solid = 0, Gradient = 1, Diffusion = 2, Image = 3 };
enum class GradientShape : std::uint8_t { Linear = 0, Radial = 1 };

/// What a diffusion layer has at a place.
struct Constraint {
    vec2 position{0.5f};            ///< In [0, 1]^2: of the function's x and y axis.
    vec4 colour{1.0f};              ///< Scene-linear, with alpha in [0, 1].
    std::optional<vec3> point = {}; ///< A point of the scene: its view ray's parameters are the position, then.
};

struct Layer {
    std::string name; ///< For reports.
    LayerKind kind = LayerKind::Solid;
    BlendMode mode = BlendMode::Mix;
    float opacity = 1.0f; ///< [0, 1].
    vec4 colour{1.0f};    ///< Solid: scene-linear, with alpha.
    /// Gradient: evenly spaced over [0, 1], both ends included; scene-linear with alpha, at least two.
    std::vector<vec4> ramp = {};
    GradientShape shape = GradientShape::Linear;
    /// Gradient: where the ramp begins and ends. Radial: its middle and its rim. At one place: the ramp's end everywhere.
    vec2 from{0.0f, 0.5f}, to{1.0f, 0.5f};
    std::vector<Constraint> constraints = {}; ///< Diffusion; at most 256. None: transparent.
    /// Diffusion, [0, 1]: 0 solves Laplace's equation, which has peaks at single constraints; larger ones bend like a
    /// plate over this length, in units of the function's sides.
    float smoothness = 0.25f;
    std::shared_ptr<const Texture> image = {}; ///< Image: over [0, 1]^2.
};

struct TransferFunction {
    std::string name; ///< For reports.
    ParameterAxis x{.axis = Axis::AverageVisibility};
    ParameterAxis y{.axis = Axis::Depth};
    Use use = Use::Replace;
    float strength = 1.0f;     ///< Replace: the radiance of colour 1, W/(m^2 sr); [0, 1e6].
    std::vector<Layer> layers; ///< Bottom to top.
};
/// A share of a function in what a frame shows: between two keys, two functions have one each. Shares are >= 0; where
/// their sum is less than 1, the rest is the physical picture.
struct WeightedFunction {
    TransferFunction function;
    float weight = 1.0f;
};

/// Throws InvalidInput that names layer and number.
void require_usable(const Layer& layer);
void require_usable(const TransferFunction& function);
} // namespace tyndall::transfer_functions
