// SPDX-License-Identifier: GPL-3.0-or-later
// Transfer functions: what a frame costs that is coloured by one, and what a change of its layers costs.
//   apply_*          to 1920 x 1080 view rays of a smooth picture (parameters vary slowly) and of a noisy one
//   plain_apply      the same in one thread, without SIMD: a look-up as one writes it down
//   compose_layers   five layers: image, gradient, solid, diffusion of 20 constraints, radial gradient; four blend modes
//   diffuse          a diffusion layer alone, of 1, 20, 50 and 200 constraints: what dragging one of them costs
// Counters: max_error against double precision, of the change (radiance 1).
#include "support/machine.hpp"
#include "transfer_functions/apply.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <random>

namespace tyndall::bench {
using namespace transfer_functions;
namespace {
constexpr std::size_t width = 1920, height = 1080;

Layer diffusion_layer(std::size_t constraint_count) {
    static const bool has_machine = (add_machine_to_context(), true);
    std::mt19937 random(has_machine ? 1 : 0);
    std::uniform_real_distribution<float> uniform;
    Layer layer{.name = "diffusion", .kind = LayerKind::Diffusion, .mode = BlendMode::Screen};
    for (std::size_t i = 0; i < constraint_count; ++i)
        layer.constraints.push_back({.position = {uniform(random), uniform(random)},
                                     .colour = {uniform(random), uniform(random), uniform(random), 1.0f}});
    return layer;
}

TransferFunction five_layers() {
    std::mt19937 random(2);
    Texture image{.name = "image", .width = 512, .height = 512};
    std::vector<std::uint8_t> texels;
    for (std::size_t i = 0; i < std::size_t{4} * 512 * 512; ++i)
        texels.push_back(static_cast<std::uint8_t>(random()));
    image.bytes = std::move(texels);
    const std::vector<vec4> ramp{{0.0f, 0.1f, 0.4f, 1.0f}, {0.9f, 0.4f, 0.1f, 0.6f}, {1.0f, 0.9f, 0.6f, 1.0f}};
    return {
        .name = "five layers",
        .layers = {{.name = "image", .kind = LayerKind::Image, .image = std::make_shared<Texture>(std::move(image))},
                   {.name = "gradient", .kind = LayerKind::Gradient, .mode = BlendMode::Overlay, .ramp = ramp},
                   {.name = "solid", .mode = BlendMode::Hue, .opacity = 0.5f, .colour = {0.9f, 0.5f, 0.2f, 1.0f}},
                   diffusion_layer(20),
                   {.name = "radial",
                    .kind = LayerKind::Gradient,
                    .opacity = 0.3f,
                    .ramp = ramp,
                    .shape = GradientShape::Radial,
                    .from = {0.5f, 0.5f},
                    .to = {1.0f, 1.0f}}}};
}

/// A frame's rays; `noise` moves each one's parameters by up to so much.
struct Frame {
    std::vector<vec2> parameters;
    std::vector<Rgb> radiance = std::vector<Rgb>(width * height, Rgb(1.0f, 0.8f, 0.6f));
    std::vector<Rgb> change = std::vector<Rgb>(width * height, Rgb(0.0f));

    explicit Frame(float noise) {
        std::mt19937 random(3);
        std::uniform_real_distribution<float> uniform(-noise, noise);
        for (std::size_t y = 0; y < height; ++y)
            for (std::size_t x = 0; x < width; ++x) {
                const vec2 place(static_cast<float>(x) / width, static_cast<float>(y) / height);
                parameters.push_back(
                    glm::clamp(0.5f + 0.4f * vec2(std::sin(5.0f * place.x + place.y), std::cos(4.0f * place.y)) +
                                   vec2(uniform(random), uniform(random)),
                               0.0f, 1.0f));
            }
    }
};

template <typename Real>
Rgb plain_change(const ComposedFunction& function, vec2 parameters, const Rgb& radiance) {
    const auto size = static_cast<Real>(function.size);
    const auto position = [&](float parameter) {
        return std::clamp<Real>(static_cast<Real>(parameter) * size - Real(0.5), 0, size - 1);
    };
    const Real x = position(parameters.x), y = position(parameters.y);
    const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
    const std::size_t right = std::min<std::size_t>(i + 1, function.size - 1),
                      up = std::min<std::size_t>(j + 1, function.size - 1);
    const Real share_x = x - static_cast<Real>(i), share_y = y - static_cast<Real>(j);
    Rgb change;
    const auto channel = [&](int c) {
        const auto texel = [&](std::size_t column, std::size_t row) {
            return static_cast<Real>(function.texels[row * function.size + column][c]);
        };
        const Real below = texel(i, j) * (1 - share_x) + texel(right, j) * share_x;
        const Real above = texel(i, up) * (1 - share_x) + texel(right, up) * share_x;
        return below * (1 - share_y) + above * share_y;
    };
    const Real alpha = channel(3);
    for (int c = 0; c < 3; ++c)
        change[c] = static_cast<float>(channel(c) - alpha * static_cast<Real>(radiance[c]));
    return change;
}
} // namespace

static void apply_to_frame(benchmark::State& state, float noise, const Application& application) {
    const Progress progress;
    const ComposedFunction function = compose(five_layers(), default_size, progress);
    Frame frame(noise);
    for (auto _ : state)
        apply(function, application, frame.parameters, frame.radiance, {}, frame.change, progress);
    if (application.use != Use::Replace)
        return;
    std::ranges::fill(frame.change, Rgb(0.0f));
    apply(function, application, frame.parameters, frame.radiance, {}, frame.change, progress);
    float error = 0.0f;
    for (std::size_t ray = 0; ray < frame.change.size(); ++ray) {
        const Rgb away = frame.change[ray] - plain_change<double>(function, frame.parameters[ray], frame.radiance[ray]);
        error = std::max({error, std::abs(away.x), std::abs(away.y), std::abs(away.z)});
    }
    state.counters["max_error"] = double{error};
}
static void apply_smooth(benchmark::State& state) { apply_to_frame(state, 0.0f, {}); }
static void apply_noisy(benchmark::State& state) { apply_to_frame(state, 1.0f, {}); }
static void apply_multiply(benchmark::State& state) { apply_to_frame(state, 0.02f, {.use = Use::Multiply}); }
static void apply_tint(benchmark::State& state) { apply_to_frame(state, 0.02f, {.use = Use::Tint}); }

static void plain_apply(benchmark::State& state) {
    const ComposedFunction function = compose(five_layers(), default_size, Progress());
    Frame frame(0.0f);
    for (auto _ : state)
        for (std::size_t ray = 0; ray < frame.change.size(); ++ray)
            frame.change[ray] += plain_change<float>(function, frame.parameters[ray], frame.radiance[ray]);
}

static void compose_layers(benchmark::State& state) {
    const Progress progress;
    const TransferFunction function = five_layers();
    for (auto _ : state)
        benchmark::DoNotOptimize(compose(function, static_cast<std::uint32_t>(state.range(0)), progress));
}
static void diffuse(benchmark::State& state) {
    const Progress progress;
    TransferFunction function{.name = "diffusion",
                              .layers = {diffusion_layer(static_cast<std::size_t>(state.range(0)))}};
    for (auto _ : state) {
        function.layers[0].constraints[0].position.x = 1.0f - function.layers[0].constraints[0].position.x;
        benchmark::DoNotOptimize(compose(function, default_size, progress));
    }
}

#define TYNDALL_FUNCTIONS_BENCHMARK(name)                                                                              \
    BENCHMARK(name)->MeasureProcessCPUTime()->UseRealTime()->Unit(benchmark::kMillisecond)
TYNDALL_FUNCTIONS_BENCHMARK(plain_apply);
TYNDALL_FUNCTIONS_BENCHMARK(apply_smooth);
TYNDALL_FUNCTIONS_BENCHMARK(apply_noisy);
TYNDALL_FUNCTIONS_BENCHMARK(apply_multiply);
TYNDALL_FUNCTIONS_BENCHMARK(apply_tint);
TYNDALL_FUNCTIONS_BENCHMARK(compose_layers)->ArgName("size")->Arg(256)->Arg(512);
TYNDALL_FUNCTIONS_BENCHMARK(diffuse)->ArgName("constraints")->Arg(1)->Arg(20)->Arg(50)->Arg(200);
} // namespace tyndall::bench
