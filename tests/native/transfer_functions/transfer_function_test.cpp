// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "transfer_functions/transfer_function.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace transfer_function_test {
using namespace tyndall;
using namespace tyndall::transfer_functions;

namespace {
const float no_number = std::nanf("");

void require_layer_usable(const Layer& layer) {
    transfer_functions::require_usable(TransferFunction{.name = "f", .layers = {{.name = "fine"}, layer}});
}
Layer spreading(Constraint constraint) {
    return {.name = "l", .kind = LayerKind::Diffusion, .constraints = {{}, constraint}};
}
} // namespace

TEST_CASE("layers that cannot be used are named, with the number that is wrong") {
    const auto is_refused = [](const Layer& layer, const char* message) {
        CHECK_THROWS_WITH_AS(require_layer_usable(layer), message, InvalidInput);
    };
    is_refused({.name = "l", .opacity = 1.5f}, "layer \"l\": opacity is 1.5, outside [0, 1]");
    is_refused({.name = "l", .colour = {0, no_number, 0, 1}}, "layer \"l\": colour is nan, outside [0, 1e+06]");
    is_refused({.name = "l", .colour = {0, 0, 0, 2}}, "layer \"l\": colour's alpha is 2, outside [0, 1]");
    is_refused({.name = "l", .mode = static_cast<BlendMode>(19)}, "layer \"l\": blend mode 19 is unknown");
    is_refused({.name = "l", .kind = static_cast<LayerKind>(4)}, "layer \"l\": kind 4 is unknown");
    is_refused({.name = "l", .kind = LayerKind::Gradient, .ramp = {vec4(1.0f)}},
               "layer \"l\": its ramp has 1 colours, not 2 or more");
    is_refused({.name = "l", .kind = LayerKind::Gradient, .ramp = {vec4(1.0f), {-1, 0, 0, 1}}},
               "layer \"l\": ramp colour 1 is -1, outside [0, 1e+06]");
    is_refused({.name = "l", .kind = LayerKind::Gradient, .ramp = {vec4(1.0f), vec4(1.0f)}, .to = {0, no_number}},
               "layer \"l\": end's y is nan, outside [-1000, 1000]");
    is_refused(spreading({.position = {1.25f, 0.5f}}), "layer \"l\": constraint 1's x is 1.25, outside [0, 1]");
    is_refused(spreading({.colour = {no_number, 0, 0, 1}}),
               "layer \"l\": constraint 1's colour is nan, outside [0, 1e+06]");
    Layer crowded = spreading({});
    crowded.constraints.resize(257);
    is_refused(crowded, "layer \"l\": it has 257 constraints, more than 256");
    is_refused({.name = "l", .kind = LayerKind::Image}, "layer \"l\": image is missing");
    is_refused({.name = "l", .kind = LayerKind::Image, .image = std::make_shared<Texture>(Texture{.name = "empty"})},
               "layer \"l\": image \"empty\" has no pixels");
}

TEST_CASE("numbers that a layer's kind does not read may be anything") {
    CHECK_NOTHROW(
        require_layer_usable({.name = "l", .ramp = {vec4(no_number)}, .constraints = {{.colour = vec4(no_number)}}}));
    CHECK_NOTHROW(require_layer_usable({.name = "l", .kind = LayerKind::Diffusion, .colour = vec4(no_number)}));
}

TEST_CASE("a function's own numbers are named, too") {
    const auto is_refused = [](const TransferFunction& function, const char* message) {
        CHECK_THROWS_WITH_AS(transfer_functions::require_usable(function), message, InvalidInput);
    };
    is_refused({.name = "f", .strength = -1.0f, .layers = {}}, "strength is -1, outside [0, 1e+06]");
    is_refused({.name = "f", .use = static_cast<Use>(3), .layers = {}}, "use 3 is unknown");
    is_refused({.name = "f", .x = {.axis = static_cast<Axis>(7)}, .layers = {}}, "x axis 7 is unknown");
    is_refused({.name = "f", .y = {.axis = Axis::Mask}, .layers = {}}, "y axis's mask is missing");
    is_refused({.name = "f", .x = {.low_m = no_number}, .layers = {}}, "x axis's range is not finite");
}
} // namespace transfer_function_test
