// SPDX-License-Identifier: GPL-3.0-or-later
// One fog box, many rays at a time: what one ray gets alone, from any side, along its faces and past it.
#include "core/simd.hpp"
#include "core/sobol.hpp"
#include "scene/media.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

namespace box_transmittance_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
std::unique_ptr<Scene> in_fog_box(const Rgb& sigma_t_per_m, const mat4& world_from_object) {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    return make_scene(
        {{.mesh = cube(), .world_from_object = world_from_object, .material = fog}},
        {{.name = "fog", .lobes = {}, .sigma_a_per_m = sigma_t_per_m, .emission_w_per_m3_sr = Rgb(0.0f)}});
}
/// In the space of a box [-1, 1]^3: to and from everywhere, and along the axes, where slabs are divided by 0.
std::vector<Ray> rays_around_the_box() {
    std::vector<Ray> rays;
    for (std::uint32_t index = 0; index < 500; ++index) {
        const auto point = [&](std::uint32_t seed) {
            const vec2 a = sobol_point(index, seed), b = sobol_point(index, seed + 1);
            return 6.0f * vec3(a, b.x) - 3.0f;
        };
        vec3 way = point(3) - point(1);
        for (int axis = 0; axis < 3; ++axis)
            if (index % 7 == 0 && axis != static_cast<int>(index / 7 % 3))
                way[axis] = 0.0f;
        const float length = glm::length(way);
        const float infinity = std::numeric_limits<float>::infinity();
        rays.push_back({point(1), way / length, index % 3 == 0 ? 0.3f : 0.0f, index % 2 == 0 ? length : infinity});
    }
    rays.push_back({{1, 0, -3}, {0, 0, 1}});       // in a face
    rays.push_back({{1.0001f, 0, -3}, {0, 0, 1}}); // beside it
    return rays;
}
} // namespace

// Seen to fail with an along-the-slab ray beside the box counted as inside of the slab.
TEST_CASE("rays through a fog box get together what each gets from the lengths of its segments") {
    const auto clear = [](const std::vector<Ray>& rays) { return std::vector<Rgb>(rays.size(), Rgb(0.5f)); };
    const std::vector<Ray> rays = rays_around_the_box();
    const mat4 turned = glm::rotate(translation({0.5f, 0.2f, -0.3f}), 0.7f, glm::normalize(vec3(1, 2, 3)));
    for (const mat4& placement : {mat4(1.0f), glm::scale(turned, vec3(1.5f, 0.5f, 1.0f))})
        for (const Rgb& sigma : {Rgb(0.4f), Rgb(0.1f, 0.5f, 2.0f)}) {
            const auto scene = in_fog_box(sigma, placement);
            const Media media(*scene, Progress());
            for (const SimdTarget target : available_simd_targets()) {
                const ForcedSimdTarget forced(target);
                std::vector<Rgb> passing = clear(rays);
                media.attenuate(rays, passing);
                for (std::size_t index = 0; index < rays.size(); ++index) {
                    std::vector<MediumSegment> segments;
                    media.segments(rays[index], segments);
                    float length_m = 0.0f;
                    for (const MediumSegment& segment : segments)
                        length_m += segment.far_m - segment.near_m;
                    for (int channel = 0; channel < 3; ++channel)
                        CHECK(std::abs(passing[index][channel] - 0.5f * std::exp(-sigma[channel] * length_m)) < 3e-6f);
                    CHECK(glm::length(media.transmittance(rays[index]) - 2.0f * passing[index]) < 6e-6f);
                }
            }
        }
}
} // namespace box_transmittance_test
