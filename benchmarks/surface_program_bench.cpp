// SPDX-License-Identifier: GPL-3.0-or-later
// A surface program of 32 operations, as a material of some twenty nodes has it, at 16 points: one after another, and
// operation by operation over all of them. constant: a material without a program.
#include "shading/op_colour.hpp"
#include "shading/op_math.hpp"
#include "shading/surface_program.hpp"
#include <array>
#include <benchmark/benchmark.h>

namespace tyndall::bench {
namespace {
constexpr std::size_t point_count = 16;
using Code = SurfaceOp::Code;

Material twenty_nodes() {
    Material material{.name = "twenty nodes"};
    material.uv_map_names = {""};
    material.tables = {{std::vector<vec4>(257, vec4(0.25f, 0.5f, 0.75f, 1.0f))}};
    const auto option = [](auto kind) { return static_cast<std::uint8_t>(kind); };
    const auto add = [&](SurfaceOp op) { material.program.push_back(op); };
    add({.code = Code::Uv, .out = 0});
    add({.code = Code::Constant, .out = 1, .value = Rgb(0.5f, 0.25f, 2.0f)});
    for (std::uint16_t round = 0; round < 5; ++round) {
        add({.code = Code::Multiply, .out = 2, .a = 0, .b = 1});
        add({.code = Code::Math, .option = option(MathOperation::Fraction), .out = 3, .a = 2});
        add({.code = Code::Curve, .out = 4, .a = 3});
        add({.code = Code::Blend, .option = option(BlendKind::Overlay), .out = 5, .a = 4, .b = 2, .c = 3});
        add({.code = Code::VectorMath, .option = option(VectorOperation::Normalize), .out = 6, .a = 5});
        add({.code = Code::Mix, .out = 0, .a = 5, .b = 6, .c = 3});
    }
    material.diffuse_register = 0;
    material.emission_register = 5;
    material.transparent_register = 63;
    validate(material);
    return material;
}

struct Points {
    std::array<ProgramPoint, point_count> points;
    std::array<vec2, point_count> uvs;
    std::array<SurfaceClosures, point_count> closures;
    Points() {
        for (std::size_t i = 0; i < point_count; ++i)
            uvs[i] = vec2(0.13f, 0.37f) * static_cast<float>(i);
    }
};

void one_by_one(benchmark::State& state, const Material& material) {
    Points at;
    for (auto _ : state) {
        for (std::size_t i = 0; i < point_count; ++i)
            at.closures[i] = evaluate(material, at.points[i], std::span(at.uvs).subspan(i, 1));
        benchmark::DoNotOptimize(at.closures);
    }
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * point_count));
}
void program_one_by_one(benchmark::State& state) { one_by_one(state, twenty_nodes()); }
void constant_one_by_one(benchmark::State& state) { one_by_one(state, {}); }
void transparency_one_by_one(benchmark::State& state) {
    Material material = twenty_nodes();
    material.transparent_register = 5;
    const TransparentOperations operations(material);
    Points at;
    for (auto _ : state)
        for (std::size_t i = 0; i < point_count; ++i)
            benchmark::DoNotOptimize(
                evaluate_transparent(material, operations, at.points[i], std::span(at.uvs).subspan(i, 1)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * point_count));
}
} // namespace
BENCHMARK(program_one_by_one);
BENCHMARK(constant_one_by_one);
BENCHMARK(transparency_one_by_one);
} // namespace tyndall::bench
