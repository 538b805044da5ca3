// SPDX-License-Identifier: GPL-3.0-or-later
// A camera ray on its way, and what a surface sends on of it or waits for: of the files view_path*.cpp alone.
#pragma once
#include "render/view_path.hpp"
#include <span>

namespace tyndall::render {
/// A ray on its way.
struct ViewPath::Follower {
    std::size_t index = 0; ///< Of its camera ray.
    float spread = 0.0f;   ///< What a pixel covers, per metre of the way.
    float near_m = 0.0f;   ///< Where the camera's ray began, along it.
    float width_m = 0.0f;  ///< What it covers where `part` begins.
    Ray part{};            ///< What is left of it.
    Rgb through_surfaces{1.0f}, through_media{1.0f};
    float samples = 1.0f;     ///< Share of a sampler's that would come here: see share_going_on().
    float gain = 1.0f;        ///< How much more than they met its surfaces gave; of sound ones 1.
    FeatureSearch features{}; ///< Where a denoiser is to be shown some.
    bool has_first_surface = false;
    LightOf of = LightOf::Picture; ///< What it brings home.
    RayKind kind = RayKind::Camera;
    std::uint32_t sender = 0;                      ///< The instance that sent it on.
    std::uint32_t way = 0;                         ///< Which of all ways it was sent, as a hash.
    std::uint8_t mirror_count = 0, bend_count = 0; ///< Behind it.
    Scatterer first = Scatterer::None;             ///< What sent it on first.
    bool is_past = false;                          ///< One more than there may be: it sees the world and what glows.
    /// Equal for rays that are followed together; those among catchers alone come last.
    [[nodiscard]] int company() const {
        return (of == LightOf::CatcherAlone ? 4 : 0) + (is_past ? 2 : 0) + (kind == RayKind::Transmission ? 1 : 0);
    }
    [[nodiscard]] Rgb throughput() const { return through_surfaces * through_media; }
    /// Of what shines at its end: direct, if that comes from there to what sent it on, and from that to the camera.
    [[nodiscard]] LightWay way_of_shine() const { return {first, mirror_count + bend_count == 1}; }
};

/// What is left of a ray behind a surface. Surfaces that give more than they meet make no infinity of it: 0 times that would
/// be no number.
[[nodiscard]] inline Rgb left_behind(const Rgb& in_front, const Rgb& share) {
    constexpr float largest = 1e30f;
    return glm::min(in_front * share, Rgb(largest));
}

/// A surface that waits for light.
struct ViewPath::Lit {
    const SurfacePoint& point;
    const SurfaceClosures& closures;
    std::span<const Lobe> lobes;
    std::span<const Lobe> below; ///< What lights it from below.
    vec3 towards_viewer;
    bool is_unseen;       ///< By the passes: in a mirror, or a shadow catcher.
    float footprint_m;    ///< What a pixel covers.
    ProgramRandom random; ///< Of its own ways below.
};
/// Where its light goes.
struct ViewPath::Share {
    Rgb throughput;
    std::uint16_t sample;
    LightOf of;
    Scatterer first; ///< Of the ray that is there.
    /// Of light that a point by itself sends so.
    [[nodiscard]] LightWay way(Scatterer own) const {
        return first == Scatterer::None ? LightWay{own, true} : LightWay{first, false};
    }
};

/// Points that light what is seen of surfaces from their other sides, and from below.
struct ViewPath::Hidden {
    SurfaceWalk behind, exits;
};
/// Points of a layer beside those that a walk holds already.
struct ViewPath::Beside {
    Hidden among_all;
    SurfaceWalk alone; ///< Of shadow catchers, with none but catchers around, as is what they hide.
    Hidden hidden_alone;
    void clear() {
        for (SurfaceWalk* walk :
             {&among_all.behind, &among_all.exits, &alone, &hidden_alone.behind, &hidden_alone.exits})
            walk->clear();
    }
};

/// What a surface sends on of a ray.
struct ViewPath::Sending {
    const Follower& follower;
    const SurfacePoint& point;
    float width_m; ///< What the ray covers there.
    const FeatureSearches& searches;
    Rgb through_media;
    LightOf of;
    float gain; ///< The follower's, and that of this surface.
    std::uint32_t pixel_seed, sample_index;
};
} // namespace tyndall::render
