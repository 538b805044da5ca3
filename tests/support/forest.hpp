// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark scene F: a forest of thin leaf triangles, so that a view ray crosses dozens of shafts. The same everywhere.
#pragma once
#include "core/math.hpp"
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace tyndall::support {
struct TriangleSoup {
    std::vector<vec3> positions; ///< Metres, +Z up.
    std::vector<uvec3> triangles;
};

/// A small counter-based generator of its own: a benchmark scene must not change when core's sampler does.
class SceneRandom {
public:
    explicit SceneRandom(std::uint64_t seed) : state_(seed) {}
    /// Uniform in [0, 1).
    float uniform() {
        state_ += 0x9e3779b97f4a7c15ull; // SplitMix64, Steele et al. 2014
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
    }
    float uniform(float lowest, float highest) { return lowest + (highest - lowest) * uniform(); }
    vec3 direction() {
        const float z = uniform(-1.0f, 1.0f), azimuth_rad = uniform(0.0f, 2.0f * std::numbers::pi_v<float>);
        const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
        return {r * std::cos(azimuth_rad), r * std::sin(azimuth_rad), z};
    }

private:
    std::uint64_t state_;
};

/// Leaves of 0.3 m by 0.06 m in 1,350 ellipsoidal crowns over a square of 260 m; the ground is z = 0, without a triangle.
/// The view of the benchmarks stands at (0, -48, 1.7) and looks along +Y, see forest_camera_position.
inline TriangleSoup make_forest(std::size_t triangle_count = 1'000'000, std::uint64_t seed = 1) {
    struct Crown {
        vec3 centre, radii;
    };
    SceneRandom random(seed);
    std::vector<Crown> crowns(1350);
    for (Crown& crown : crowns) {
        const float radius = random.uniform(1.5f, 3.0f), height = random.uniform(2.5f, 5.0f);
        crown.centre = {random.uniform(-130.0f, 130.0f), random.uniform(-130.0f, 130.0f), random.uniform(7.0f, 13.0f)};
        crown.radii = {radius, radius, height};
    }
    TriangleSoup soup;
    soup.positions.reserve(3 * triangle_count);
    soup.triangles.reserve(triangle_count);
    for (std::size_t leaf = 0; leaf < triangle_count; ++leaf) {
        const Crown& crown = crowns[leaf % crowns.size()];
        const vec3 centre = crown.centre + crown.radii * (random.direction() * std::cbrt(random.uniform()));
        const auto [side, up] = orthonormal_basis(random.direction());
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        soup.positions.push_back(centre - 0.15f * up - 0.03f * side);
        soup.positions.push_back(centre - 0.15f * up + 0.03f * side);
        soup.positions.push_back(centre + 0.15f * up);
        soup.triangles.push_back(uvec3(first, first + 1, first + 2));
    }
    return soup;
}
inline constexpr vec3 forest_camera_position{0.0f, -48.0f, 1.7f};
inline constexpr Bounds3 forest_fog_box{.min = vec3(-50.0f, -50.0f, 0.0f), .max = vec3(50.0f, 50.0f, 20.0f)};
/// Towards the sun, 40 degrees above the horizon and to the side of the view.
inline vec3 forest_towards_sun() { return glm::normalize(vec3(0.5f, 0.6f, 0.65f)); }
} // namespace tyndall::support
