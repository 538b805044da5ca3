// SPDX-License-Identifier: GPL-3.0-or-later
// A camera ray on its way through transparent surfaces: every layer adds its light, weighted by what lies in front; and
// what mirrors send on, as far as the settings say.
// Differs from Cycles: layers are followed deterministically with their share per channel, not picked at random, so
//           that a window or a leaf's edge adds no noise. The expected picture is the same. So are mirrors, but for those
//           of which less than 1 / 1,024 would reach the camera. Where glass bends, ways that count little are drawn: see
//           sent_rays.hpp.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "render/direct_light.hpp"
#include "render/film.hpp"
#include "render/indirect_config.hpp"
#include "render/surface_walk.hpp"
#include <optional>
#include <span>
#include <vector>

namespace tyndall::render {
/// Transparent surfaces that a camera ray may pass before it counts as black.
inline constexpr std::uint32_t max_layer_count = 256;

/// A stretch of a camera ray between two surfaces, in a medium.
struct MediumPart {
    float near_m, far_m; ///< From the camera; far may be infinite.
    Rgb weight;          ///< Share that the surfaces and media in front of near_m let pass.
};

struct ViewPathConfig {
    bool is_film_transparent = false;   ///< The world is not seen: alpha is what covers it.
    bool collects_parts = false;        ///< Fill `parts` where there is a medium.
    bool lights_black_surfaces = false; ///< The Shadow pass needs light on surfaces that show none.
    bool finds_ambient = false;         ///< The ambient occlusion pass needs a point on all that covers anything.
    bool tells_paths = false;           ///< Samples come with LightPaths.
    float pass_alpha_threshold = 0.5f;  ///< See FrameConfig.
    IndirectConfig indirect = {};
    float voxel_detail_px = 0.0f; ///< Cubes of voxels no wider are not looked into; 0: every voxel is met.
    bool operator==(const ViewPathConfig&) const = default;
};

class SentAir; // sent_air.hpp

class ViewPath {
public:
    /// `sent_air`: what media scatter into rays that surfaces send on; nothing: nothing does.
    ViewPath(const Scene& scene, const Media& media, const DirectLight& light, const Camera& camera,
             const ViewPathConfig& config, const SentAir* sent_air = nullptr)
        : scene_(scene), media_(media), light_(light), camera_(camera), config_(config), sent_air_(sent_air) {}

    [[nodiscard]] const ViewPathConfig& config() const { return config_; }
    [[nodiscard]] bool catches_shadows() const { return scene_.has_shadow_catchers(); }
    static constexpr std::uint32_t nowhere = ~0u;
    /// Follows the rays of up to DirectLight::most_points neighbouring pixels through all that they pass. Overwrites
    /// `samples` with what they bring home without light on surfaces (adding to their groups), and appends the parts of
    /// each that lie in media to the parts of its index. Where light is wanted, appends a batch of points per layer to
    /// the walk, of each ray for sample targets[ray]; rays whose target is nowhere only keep the others company. Where
    /// there is `data`, one per ray, it gets what they meet. A ray that does not exist leaves a sample as it is by
    /// itself.
    void walk(std::span<const Ray> camera_rays, std::span<const std::uint32_t> pixel_seeds, std::uint32_t sample_index,
              std::span<const std::uint32_t> targets, std::span<PathSample> samples,
              std::span<std::vector<MediumPart>> parts, SurfaceWalk* walked, const DataOfRays& data = {}) const;
    /// Overwrites what those lights that `is_asked` give to the points, the many by so many groups, too.
    void ask_lights(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<const std::uint8_t> is_asked,
                    SurfaceLight& light, std::size_t group_count = 0) const;
    /// The same of the other lights, at those points alone that have a shadow ray which may meet the boxes; returns how
    /// many there are, light by light.
    std::size_t ask_again(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<const std::uint8_t> is_asked,
                          const MovedBoxes& moved, SurfaceLight& light) const;
    /// Adds the light on their surfaces to the samples.
    void add_light(const SurfaceWalk& walked, const SurfaceLight& light, std::span<PathSample> samples) const;

private:
    /// Of each light to its group, of samples that have some.
    void add_light_to_groups(const SurfaceWalk& walked, const SurfaceLight& light, std::span<PathSample> samples) const;
    struct Follower;
    /// Neighbouring rays of one company.
    struct Rays;
    struct Sending;
    struct Hidden;
    struct Beside;
    struct Lit;
    struct Share;
    /// Appends a surface's points on the viewer's side, behind, and where what is seen of what lies below came in.
    void await_light(const Lit& lit, const Share& share, SurfaceWalk& walked, Hidden& hidden) const;
    /// Lobes of a point: where passes tell light apart by them, those that are not matte wait at points of their own.
    void await_lobes(const Lit& lit, const Share& share, const SurfacePoint& point, std::span<const Lobe> lobes,
                     SurfaceWalk& walked, SurfaceWalk& apart) const;
    void await_exits(const Lit& lit, const Share& share, SurfaceWalk& exits) const;
    void catch_shadow(const Follower& follower, const SurfaceClosures& closures, PathSample& sample) const;
    /// Follows up to most_points rays by their layers; what is mirrored and bent on the way goes to `sent`, where there is
    /// one.
    void follow(const Rays& rays, std::span<PathSample> samples, std::span<std::vector<MediumPart>> parts,
                const DataOfRays& data, std::vector<Follower>* sent, SurfaceWalk* walked) const;
    /// Adds what media scatter into a ray from a mirror or glass, by random numbers of a seed, before it ends.
    void see_air(const Follower& follower, float end_m, std::uint32_t seed, std::uint32_t sample_index,
                 PathSample& sample) const;
    /// Adds lamps with a size that a ray from a mirror or glass meets before it ends.
    void see_lamps(const Follower& follower, float end_m, PathSample& sample) const;
    /// Appends the rays that mirrors and glass send on.
    void send_on(const Sending& sending, const SurfaceClosures& closures, std::span<const Lobe> bent,
                 std::vector<Follower>& sent) const;
    /// Light of a surface that is not what lamps and world throw on it; the first one that covers tells what it is.
    void show(Follower& follower, const SurfacePoint& point, const SurfaceClosures& closures, bool is_sent_on,
              LightOf of, PathSample& sample) const;
    /// Light of the media up to the hit, and their parts: nothing, where they do not count.
    void pass_media(Follower& follower, const Hit& hit, const Ray& camera_ray, PathSample& sample,
                    std::vector<MediumPart>& parts) const;
    /// Where on its camera's ray one that was bent begins, if it goes on along that, nearly, as behind a pane.
    [[nodiscard]] static std::optional<float> goes_on_at(const Follower& follower, const Ray& camera_ray);
    /// Light of the world, if the film shows it; mirrors and what bends always do.
    void reach_world(const Follower& follower, bool is_sent_on, PathSample& sample) const;

    const Scene& scene_;
    const Media& media_;
    const DirectLight& light_;
    const Camera& camera_;
    ViewPathConfig config_;
    const SentAir* sent_air_;
};
} // namespace tyndall::render
