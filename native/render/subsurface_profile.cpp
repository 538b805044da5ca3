// SPDX-License-Identifier: GPL-3.0-or-later
// An exit by a profile of distances, found by a line through a disc beside the entry.
// Based on: King, Kulla, Conty, Fajardo, BSSRDF Importance Sampling, SIGGRAPH Talks 2013: lines along the normal and two
//           axes across it, and radii as one of the channels draws them, weighed together.
// Differs:  of all that a line meets, not of four, one is drawn by what it counts, and counts for all.
//           As in Cycles a place off the entry's plane counts as at its distance in space, but as dense as on the disc.
// Bound:    one ray through the object.
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "render/subsurface_exit.hpp"
#include <array>
#include <cmath>
#include <vector>

namespace tyndall::render {
namespace {
/// Of the channels that have a radius.
class Profile {
public:
    explicit Profile(const Rgb& scales_m) : scales_m_(scales_m) {
        for (int channel = 0; channel < 3; ++channel)
            if (scales_m[channel] > 0.0f)
                channels_[static_cast<std::size_t>(count_++)] = channel;
    }
    [[nodiscard]] Rgb density_per_m(float radius_m) const {
        Rgb density(0.0f);
        for (int i = 0; i < count_; ++i)
            density[channel(i)] = subsurface::profile_density_per_m(scales_m_[channel(i)], radius_m);
        return density;
    }
    [[nodiscard]] float pdf_per_m(float radius_m) const {
        const Rgb density = density_per_m(radius_m);
        return (density.x + density.y + density.z) / static_cast<float>(count_);
    }
    struct Drawn {
        float radius_m, reach_m;
    };
    /// u is in [0, 1).
    [[nodiscard]] Drawn sample(float u) const {
        const float scaled = u * static_cast<float>(count_);
        const int i = std::min(static_cast<int>(scaled), count_ - 1);
        const float scale_m = scales_m_[channel(i)];
        return {subsurface::sample_profile_radius_m(scale_m, scaled - static_cast<float>(i)),
                subsurface::profile_reach * scale_m};
    }

private:
    [[nodiscard]] int channel(int i) const { return channels_[static_cast<std::size_t>(i)]; }
    Rgb scales_m_;
    std::array<int, 3> channels_{};
    int count_ = 0;
};
} // namespace

FoundExits exit_by_profile(const SubsurfaceEntry& entry) {
    constexpr std::array<float, 3> axis_share{0.5f, 0.25f, 0.25f};
    const ShadingPoint& shading = entry.point.shading;
    const vec3 outside = shading.is_backface ? -shading.geometric_normal : shading.geometric_normal;
    const vec3 along = glm::cross(vec3(1.0f), outside); // the axes that Cycles has: what they find depends on them
    const float length = glm::length(along);
    const vec3 first = length > 1e-4f ? along / length : orthonormal_basis(outside).first;
    const std::array<vec3, 3> axes{outside, first, glm::cross(outside, first)};

    vec2 u = sobol_point(entry.random.sample_index, hash(entry.random.seed, 1u));
    std::size_t axis = 0;
    if (u.y < 0.5f)
        u.y *= 2.0f;
    else {
        axis = u.y < 0.75f ? 1 : 2;
        u.y = (u.y - (axis == 1 ? 0.5f : 0.75f)) * 4.0f;
    }
    const Profile profile(entry.lobe.a);
    const auto [radius_m, reach_m] = profile.sample(u.x);
    const float height_m = std::sqrt(std::max(0.0f, reach_m * reach_m - radius_m * radius_m));
    const float density_per_m = profile.pdf_per_m(radius_m), turn = 2.0f * std::numbers::pi_v<float> * u.y;
    if (!(density_per_m > 0.0f))
        return {};
    const vec3 beside = radius_m * (std::cos(turn) * axes[(axis + 1) % 3] + std::sin(turn) * axes[(axis + 2) % 3]);
    const Ray line{.origin = shading.position + beside + height_m * axes[axis],
                   .direction = -axes[axis],
                   .near_m = 0.0f,
                   .far_m = 2.0f * height_m};
    thread_local std::vector<Hit> hits;
    hits.clear();
    entry.scene.append_hits(line, entry.point.hit.instance, hits);

    thread_local std::vector<Rgb> weights;
    weights.clear();
    float sum = 0.0f;
    for (const Hit& hit : hits) {
        std::array<float, 3> seen{};
        float squares = 0.0f;
        for (std::size_t i = 0; i < 3; ++i) {
            seen[i] = axis_share[i] * std::abs(glm::dot(axes[i], hit.geometric_normal));
            squares += seen[i] * seen[i];
        }
        const vec3 there = line.origin + hit.distance_m * line.direction;
        weights.push_back(profile.density_per_m(glm::length(there - shading.position)) *
                          (seen[axis] / (squares * density_per_m)));
        sum += average(weights.back());
    }
    if (!(sum > 0.0f))
        return {};
    float left = sobol_point(entry.random.sample_index, hash(entry.random.seed, 2u)).x * sum;
    std::size_t drawn = 0;
    while (drawn + 1 < hits.size() && left >= average(weights[drawn]))
        left -= average(weights[drawn++]);
    Hit hit = hits[drawn];
    const float weight = average(weights[drawn]);
    if (!(weight > 0.0f))
        return {};
    const vec3 normal = shading.is_backface ? -hit.geometric_normal : hit.geometric_normal;
    const vec3 position = line.origin + hit.distance_m * line.direction;
    hit.distance_m = 1.0f;
    return {.each = {{{.from_outside = {.origin = position + normal, .direction = -normal},
                       .hit = hit,
                       .weight = entry.lobe.weight * weights[drawn] * (sum / weight)}}},
            .count = 1};
}
} // namespace tyndall::render
