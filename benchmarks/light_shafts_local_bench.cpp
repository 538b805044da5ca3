// SPDX-License-Identifier: GPL-3.0-or-later
// What a local light scatters, shadows given: time per ray and light sample, per instruction set, one thread. 96 x 54 rays
// of a camera in a hall of fog of 17 x 14 x 8 m. A spot that half of them meet or all of them meet, a lamp, strata of
// soft ones, of a wide area light and of a ball, a lamp outside of the fog; all of a ray lit, or 30 cm of each metre.
// Counter: worst relative error of 200 of the rays against thousands of panels in doubles.
#include "core/simd.hpp"
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "support/local_panels.hpp"
#include "support/machine.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace support;
namespace {
struct Hall {
    std::vector<FogBox> boxes{{{0, -1.3, 4.1},
                               {8.5, 7.2, 4.1},
                               {.name = "haze", .lobes = {{Rgb(0.049f, 0.049f, 0.05f), 0.3f}}, .sigma_a_per_m = {}}}};
    std::unique_ptr<Scene> scene;
    Progress progress;
    std::unique_ptr<Media> media;
    std::unique_ptr<MediaRays> rays;

    explicit Hall(bool is_grey) {
        if (is_grey)
            boxes[0].medium.lobes[0].sigma_s_per_m = Rgb(0.05f);
        scene = scene_of(boxes);
        media = std::make_unique<Media>(*scene, progress);
        rays = std::make_unique<MediaRays>(MediaRays{*media, {}, {0}, {}});
        for (int y = 0; y < 54; ++y)
            for (int x = 0; x < 96; ++x) {
                const vec3 through((static_cast<float>(x) - 47.5f) / 75.0f, 1.0f,
                                   (static_cast<float>(y) - 26.5f) / 75.0f + 0.1f);
                rays->add({{0.9f, -7.2f, 2.15f}, glm::normalize(through), 0.0f, 12.5f});
            }
    }
};
const Hall& hall(bool is_grey) {
    static const Hall grey(true), coloured(false);
    return is_grey ? grey : coloured;
}

Light light_of(const std::string& name) {
    Light light{.name = name, .kind = LightKind::Spot, .strength = Rgb(100.0f), .position = {-3.0f, 2.0f, 7.0f}};
    light.spot_axis = glm::normalize(vec3(0.3f, -0.2f, -1.0f));
    light.spot_half_angle_rad = name == "wide" ? 0.8f : 0.25f;
    light.spot_blend = 0.15f;
    const auto [tangent, bitangent] = orthonormal_basis(-light.spot_axis);
    light.light_from_world_directions = glm::transpose(mat3(tangent, bitangent, -light.spot_axis));
    light.body = LightBody::FacingDisc;
    light.radius_m = name == "soft" ? 0.06f : 0.0f;
    if (name == "lamp" || name == "outside")
        light.kind = LightKind::Point;
    if (name == "ball")
        light.kind = LightKind::Point, light.body = LightBody::Sphere, light.radius_m = 0.3f;
    if (name == "panel") {
        light.kind = LightKind::Area, light.half_size_m = {1.0f, 1.0f};
        light.spot_half_angle_rad = 0.5f * std::numbers::pi_v<float>;
    }
    if (name == "outside")
        light.position = {-3.0f, 2.0f, 12.0f};
    return light;
}

void local(benchmark::State& state, const std::string& name, bool is_grey, bool is_striped, SimdTarget target) {
    const Hall& in = hall(is_grey);
    const Light light = light_of(name);
    const LightSample sample = name == "panel" || name == "ball" ? light_shafts::stratum_of(light, 0, 20, 64, 0)
                                                                 : sample_light(light, 0, vec3(0.3f, 0.7f, 0.4f));
    const light_shafts::LocalScatter scatter(*in.media, sample);
    const ForcedSimdTarget forced(target);
    const Stripes stripes(0.0f, is_striped ? 0.3f : 1e3f, is_striped ? 1.0f : 1e3f);
    std::vector<Rgb> radiance(in.rays->rays.size());
    // In blocks of 256 rays, as a frame asks.
    std::vector<MediaRays> blocks;
    std::vector<light_shafts::LocalRays> columns;
    for (std::size_t first = 0; first < radiance.size(); first += 256) {
        MediaRays& block = blocks.emplace_back(MediaRays{*in.media, {}, {0}, {}});
        for (std::size_t ray = first; ray < std::min(first + 256, radiance.size()); ++ray)
            block.add(in.rays->rays[ray]);
    }
    for (const MediaRays& block : blocks)
        columns.push_back(block.columns());
    for (auto _ : state) {
        std::ranges::fill(radiance, Rgb(0.0f));
        for (std::size_t block = 0; block < blocks.size(); ++block)
            scatter.add_scattered(columns[block], &stripes,
                                  std::span(radiance).subspan(block * 256, columns[block].size()), {}, {});
        benchmark::DoNotOptimize(radiance.data());
        stripes.asked.clear();
    }
    state.counters["per_ray"] =
        benchmark::Counter(static_cast<double>(radiance.size()),
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    if (is_striped)
        return;
    double worst = 0.0;
    for (std::size_t ray = 0; ray < radiance.size(); ray += radiance.size() / 200) {
        const dvec3 truth = by_panels(in.boxes, sample, *in.rays, ray);
        if (truth != dvec3(0.0))
            worst = std::max(worst, glm::length(dvec3(radiance[ray]) - truth) / glm::length(truth));
    }
    state.counters["worst_error"] = worst;
}

const bool is_registered = [] {
    add_machine_to_context();
    for (const SimdTarget target : available_simd_targets()) {
        const ForcedSimdTarget forced(target);
        for (const std::string name : {"spot", "wide", "soft", "lamp", "panel", "ball", "outside"})
            for (const bool is_grey : {true, false})
                for (const bool is_striped : {false, true})
                    benchmark::RegisterBenchmark(
                        ("local/" + name + (is_grey ? "/grey" : "/rgb") + (is_striped ? "/stripes/" : "/lit/") +
                         simd_target_name())
                            .c_str(),
                        [=](benchmark::State& state) { local(state, name, is_grey, is_striped, target); })
                        ->Unit(benchmark::kMicrosecond);
    }
    return true;
}();
} // namespace
} // namespace tyndall::bench
