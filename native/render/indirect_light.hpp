// SPDX-License-Identifier: GPL-3.0-or-later
// What surfaces that the camera sees catch of others: how much of the world they see (the ambient occlusion pass), the
// light of one bounce, which bleeds colours, and that of media that glow, as fire.
// Based on: Kol, dissertation, TU Delft 2018, 2.5.6: rays over the hemisphere, and from what they hit rays to the lights;
//           Ward, Rubinstein, Clear, A Ray Tracing Solution for Diffuse Interreflection, SIGGRAPH 1988: by the cosine.
// Differs:  Owen-scrambled Sobol points instead of jittered strata, over all samples of a pixel, each pixel with its own;
//           what is hit gets one shadow ray of every light; transparent layers on the way are followed, not picked.
//           Lobes catch light by directions of their own, beside those by the cosine (Veach 1997, 9.2.4): as many as
//           they shine. Gloss of what is hit is blurred, as Cycles' Filter Glossy does by default.
// Bound:    per surface point and ray: one ray through the scene, which goes alone, and what it meets one shadow ray per
//           light; of the pass one ray.
#pragma once
#include "core/progress.hpp"
#include "render/direct_light.hpp"
#include "render/film.hpp"
#include "render/indirect_config.hpp"
#include "render/surface_walk.hpp"
#include <span>

namespace tyndall::render {
class IndirectLight {
public:
    /// The references must outlive this.
    IndirectLight(const Scene& scene, const Media& media, const DirectLight& light, const IndirectConfig& config,
                  bool finds_ambient);

    /// False: add() adds nothing.
    [[nodiscard]] bool is_wanted() const { return finds_ambient_ || has_bounce_; }
    /// Rays are sent for light: of media that glow always, of all that shines with IndirectConfig::has_bounce.
    [[nodiscard]] bool has_bounce() const { return has_bounce_; }
    /// They bring the light of surfaces, too.
    [[nodiscard]] bool sees_surfaces() const { return sees_surfaces_; }
    [[nodiscard]] std::uint32_t bounce_rays() const { return has_bounce_ ? bounce_rays_ : 0; }
    /// Per surface point.
    void set_bounce_rays(std::uint32_t count) { bounce_rays_ = count; }

    /// To the samples of the walk's points, and to their so many groups. Throws Cancelled.
    void add(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<PathSample> samples,
             std::size_t group_count, const Progress& progress) const;
    /// What one bounce brings to a point.
    struct Gathered {
        Rgb irradiance{0.0f}; ///< W/m^2.
        Rgb reflected{0.0f};  ///< Of that, towards the viewer by the point's lobes: radiance.
        Gathered& operator+=(const Gathered& other) {
            irradiance += other.irradiance;
            reflected += other.reflected;
            return *this;
        }
    };
    /// Adds the light of one bounce on up to DirectLight::most_points points, as many as are `gathered`. Takes the random
    /// numbers of a layer of surfaces along the pixels' rays. `lobes`: null where no point has any. Adds what comes from
    /// each group to by_group[group * points.size() + point].
    void gather(std::span<const SurfacePoint> points, std::uint32_t sample_index, std::uint32_t layer,
                std::uint32_t ray_count, const DirectLight::PointLobes* lobes, std::span<Gathered> gathered,
                std::span<Gathered> by_group = {}, Among among = Among::All) const;

private:
    struct Gatherer;
    struct Met;
    /// By a pair of random numbers: a direction of the lobes or one by the cosine, of so many rays.
    static void push_drawn(const SurfacePoint& point, const LobeSet& lobes, vec2 u, Gatherer ray,
                           std::vector<Gatherer>& gatherers);
    /// Up to the next surface: what media emit on the way; of those that end, or see none of it, no more is left.
    void catch_glow(std::vector<Gatherer>& gatherers, std::span<Gathered> gathered) const;
    /// Up to the next surface: its light comes to the points; what passes goes on.
    void catch_light(std::span<const SurfacePoint> points, std::vector<Gatherer>& gatherers,
                     const PairIndex& first_pair, std::span<Gathered> gathered, std::span<Gathered> by_group,
                     Among among) const;
    /// The light of the lights there comes to as many points as have gathered.
    void light(const Met& met, const PairIndex& first_pair, std::span<Gathered> gathered, std::span<Gathered> by_group,
               Among among) const;
    /// Shares of the world that the points see, within reach.
    void find_ambient(std::span<const SurfacePoint> points, std::uint32_t sample_index, std::uint32_t layer,
                      std::span<Rgb> seen) const;

    const Scene& scene_;
    const Media& media_;
    const DirectLight& light_;
    IndirectConfig config_;
    bool finds_ambient_, sees_surfaces_, has_bounce_;
    std::uint32_t bounce_rays_ = 1;
};
} // namespace tyndall::render
