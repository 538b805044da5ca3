// SPDX-License-Identifier: GPL-3.0-or-later
// What camera rays met in the last pictures, kept for the next: an edit of what stands before a light in the air traces
// no ray, and a light that moved is asked anew at the points that the others have lit already.
// Differs:  nothing is told by names or by what was changed, as in light_shafts/map_cache.hpp: all that a pass depends on
//           is its key, and so pictures have the same bits with and without it, whatever was rendered before. Where
//           instances moved, scenes are compared (scene/moved_instances.hpp), and what no ray could tell stays. Those bits
//           are not promised where surfaces of several instances lie in one another: which of them a ray meets is then a
//           matter of Embree's tree.
// Bound:    as many bytes as it is given: some 100 per pixel and sample with their light (of 1920 x 1080 pixels 200 MB);
//           where there is room, 300 per pixel and 12 more per light, with points that a changed light is asked at.
//           Passes of the last pictures do not make room for others: what does not fit is rendered anew each time.
#pragma once
#include "light_shafts/surface_shadows.hpp"
#include "render/shadow_ray_counts.hpp"
#include "render/surface_pass.hpp"
#include "scene/camera.hpp"
#include "scene/moved_instances.hpp"
#include "scene/scene.hpp"
#include <algorithm>
#include <list>
#include <memory>
#include <optional>
#include <vector>

namespace tyndall::render {
/// What a pass over surfaces depends on, but for lights.
struct SurfaceKey {
    std::shared_ptr<const void> geometry; ///< Scene::geometry: materials and media are part of it.
    World world;
    Camera camera;
    Region region{};
    PixelFilter filter = PixelFilter::Box;
    float filter_width_px = 0.0f;
    bool is_filtered = false; ///< Samples lie beside the pixel's centre.
    std::uint32_t seed = 0, sample_index = 0;
    ViewPathConfig path;
    std::uint32_t bounce_rays = 0; ///< Per surface point.
    PackedSamples::Parts parts;
    [[nodiscard]] bool operator==(const SurfaceKey& other) const;
};

/// A light as surfaces see it. The world's has no more than its ray count: the rest is part of SurfaceKey.
struct KeptLight {
    Light light;
    std::vector<Light> many = {}; ///< Lamps that are drawn: all together are one light.
    std::uint32_t ray_count = 0;  ///< Shadow rays per point; 0: its light has to be asked for.
    std::uint32_t turn = 1;       ///< Samples that they stand for.
    /// Where edits of its occluders cast shadows.
    std::optional<light_shafts::SurfaceShadows::Config> edited_shadows = {};
    [[nodiscard]] bool operator==(const KeptLight& other) const {
        return ray_count == other.ray_count && turn == other.turn && edited_shadows == other.edited_shadows &&
               lights_surfaces_alike(light, other.light) && std::ranges::equal(many, other.many, lights_surfaces_alike);
    }
};

/// One sample of a picture's surfaces.
struct KeptPass {
    SurfaceKey key;
    SurfaceForm form = SurfaceForm::Nothing;
    std::size_t light_count = 0;
    std::vector<KeptLight> lights;                ///< In the order of DirectLight; none before the pass is complete.
    std::vector<std::vector<SurfaceBlock>> bands; ///< Of the picture, from below.
    StoodAt stood_at;        ///< When some of its blocks were traced, and not in the scene of its key.
    bool is_at_work = false; ///< Some of its blocks may have been traced in the scene of its key.
    [[nodiscard]] std::size_t bytes() const;
    /// Its key gets that geometry, before which those instances stood elsewhere.
    void move_to(std::shared_ptr<const void> geometry, const StoodAt& moved);
    /// All of its blocks are of the scene of its key.
    void finish(std::vector<KeptLight> lights_of_key);
};

/// What the shadow ray counts of a picture depend on.
struct CountsKey {
    SurfaceKey surfaces;
    std::vector<Light> lights;
    bool may_share_world = false, attenuates_light = true, world_scatters = true;
    std::uint32_t longest_turn = 1, pixel_samples = 1;
    light_shafts::GridMethod grid_method = light_shafts::GridMethod::March;
    float grid_error_target = 0.0f;
    std::uint32_t shafts_seed = 0;
    std::optional<light_shafts::SurfaceShadows::Config> edited_shadows = {};
    [[nodiscard]] bool operator==(const CountsKey& other) const;
};

/// For one thread at a time.
class KeptSurfaces {
public:
    explicit KeptSurfaces(std::size_t capacity_bytes) : capacity_bytes_(capacity_bytes) {}

    /// Call it before each picture: passes over other geometry are forgotten, but for where instances stand.
    void begin_picture(const Scene& scene);
    /// What of a pass is worth its memory.
    [[nodiscard]] SurfaceForm form_for(std::size_t pixel_count, std::size_t light_count, bool has_lobes) const;
    /// Nothing where no such pass is kept. Its lights may be others.
    [[nodiscard]] std::shared_ptr<KeptPass> find(const SurfaceKey& key);
    /// Takes the place of the same sample of another picture of that size. Not kept where there is no room.
    void keep(std::shared_ptr<KeptPass> pass);
    /// Its points were lit anew.
    void count_again(const KeptPass& pass);

    [[nodiscard]] const ShadowRayCounts* find_counts(const CountsKey& key) const;
    void keep_counts(CountsKey key, ShadowRayCounts counts);

    [[nodiscard]] std::size_t bytes() const { return bytes_; }

private:
    struct Entry {
        std::shared_ptr<KeptPass> pass;
        std::size_t bytes;
        std::uint64_t picture; ///< That asked for it last.
    };
    void remove(std::list<Entry>::iterator entry);

    std::size_t capacity_bytes_, bytes_ = 0;
    std::uint64_t picture_ = 0;
    std::unique_ptr<const Scene> last_scene_; ///< In the dark.
    std::list<Entry> entries_;                ///< Those last asked for come first.
    std::list<std::pair<CountsKey, ShadowRayCounts>> counts_;
};
} // namespace tyndall::render
