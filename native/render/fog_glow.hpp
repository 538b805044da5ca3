// SPDX-License-Identifier: GPL-3.0-or-later
// Light of meshes and media that glow, scattered once by media towards the camera: a few draws per part of a view ray.
// Based on: next event estimation; light_tree_along.cpp chooses a triangle for the ray, glow_distances.hpp where its light
//           is scattered, and triangle_point() a place on it, evenly in the solid angle from there. Where fog scatters
//           mostly onwards, and among what glows all around, multiple importance sampling (Veach 1997, section 9.2) with
//           phase_directions.hpp.
// Differs:  from lamps' light shafts, which have no noise: rows of what shadows a lamp serve many rays, and an area of
//           thousands of triangles has no few strata. Directions are drawn only where a pilot finds that worth its time: the
//           light per metre and steradian has no singularity that triangles' draws would leave over.
//           Media that glow, hair, points, and voxels in great numbers are met by directions alone.
// Data flow: part of a view ray -> its pieces in media, once (media_line.hpp) -> per draw: triangle, distance, place, one
//           shadow ray -> radiance, by light groups where these are kept apart.
// Bound:    a draw takes 1 us in a fog box and its shadow ray, half as much again where directions are drawn, too; the error
//           of n draws falls with 1 / sqrt(n). 60 bytes a triangle beside those of mesh_emitters.hpp.
#pragma once
#include "core/statistics.hpp"
#include "render/kept_light_trees.hpp"
#include "render/media_line.hpp"
#include "render/phase_directions.hpp"
#include "render/shadow_ray_counts.hpp"

namespace tyndall::render {
/// All of its pieces, which it has.
[[nodiscard]] LightTree::Line tree_line(const MediaLine& line);
/// Of light along a ray: by what blocks a light with these links, nothing for all, and by media, if any dim it.
[[nodiscard]] Rgb passing_along(const Scene& scene, const Media* media, const Ray& ray, const LightLinks* links);

class FogGlow {
public:
    /// Draws of a part at most, in each sample: twice as many save little more of the noise in a fixed time.
    static constexpr std::uint32_t most_draws = 4;
    /// The references must outlive this. Reports what is not followed.
    FogGlow(const Scene& scene, const Media& media, const MeshEmitters& emitters, bool attenuates_light,
            Statistics& statistics, KeptLightTrees* kept = nullptr);

    /// Nothing glows that lights media, or no medium scatters.
    [[nodiscard]] bool is_empty() const { return tree_ == nullptr && !has_met_alone_ && !has_glowing_media_; }
    /// Of what glows, each once; see LightLinks.
    [[nodiscard]] std::vector<std::uint8_t> light_groups() const;

    /// Whose random numbers a draw takes.
    struct Numbers {
        std::uint32_t pixel_seed;
        std::uint32_t draw; ///< Of all samples of the pixel.
        std::uint32_t part; ///< Of the pixel's ray.
    };
    struct Found {
        Rgb radiance{0.0f};
        std::uint8_t light_group = no_light_group;
    };
    /// One draw of a triangle, and where that helps, one of a direction, and one of media that glow; appends what they
    /// find. Together, and in the mean over all draws, that is what all triangles and media give.
    void draw(const MediaLine& line, const Numbers& numbers, std::vector<Found>& found) const;
    /// The pieces of a part.
    void assign(MediaLine& line, const light_shafts::ViewRay& part) const { line.assign(media_, part, StepLimits{}); }

    /// Before draws: how many of them a part is worth beside all else that its pixel's noise comes from, and whether
    /// directions are drawn in fog without a peak, too. One draw in each sample where there was no pilot, and before this is
    /// called. Throws Cancelled.
    void prepare(const PilotSamples& pilot, const Progress& progress);
    /// Of a part in each sample that has some: a power of two up to most_draws.
    [[nodiscard]] std::uint32_t draw_count() const { return draw_count_; }
    /// Every so many-th sample of a pixel has draws, which count for as many; a power of two.
    [[nodiscard]] std::uint32_t turn() const { return turn_; }
    [[nodiscard]] bool draws_directions() const { return draws_directions_; }

private:
    struct PilotLight {
        double mean = 0.0, variance = 0.0; ///< Of one draw.
    };
    /// Of each pixel of a pilot.
    [[nodiscard]] std::vector<PilotLight> pilot_lights(std::span<const PilotPixel> pixels,
                                                       const Progress& progress) const;
    void draw_triangle(const MediaLine& line, const Numbers& numbers, const PhaseDirections* directions,
                       std::vector<Found>& found) const;
    void draw_direction(const MediaLine& line, const Numbers& numbers, const PhaseDirections& directions,
                        std::vector<Found>& found) const;
    void draw_media(const MediaLine& line, const Numbers& numbers, const PhaseDirections& directions,
                    std::vector<Found>& found) const;
    /// What a direction that was drawn brings of what glows there, weighed against draw_triangle().
    [[nodiscard]] Rgb met(const MediaLine& line, const PhaseDirections& directions, const PhaseDirections::Drawn& drawn,
                          const Hit& hit) const;
    [[nodiscard]] const LightLinks* links_of(std::uint32_t instance) const {
        const LightLinks& links = scene_.object_info(instance).links;
        return links == LightLinks{} ? nullptr : &links;
    }
    /// Whether a ray by chance may meet it, and be told what blocks it.
    [[nodiscard]] bool is_met_by_chance(const EmissiveTriangle& triangle) const {
        return scene_.lights_media(triangle.instance) && scene_.lights_surfaces(triangle.instance).diffuse &&
               scene_.object_info(triangle.instance).links.is_blocked_by_all();
    }
    [[nodiscard]] bool is_met_by_chance(const Hit& hit) const {
        const EmissiveTriangle* const triangle = emitters_.triangle_of(hit);
        return triangle != nullptr ? is_met_by_chance(*triangle)
                                   : emitters_.is_met_alone(hit) && scene_.lights_media(hit.instance);
    }
    /// From a place on a triangle, which `hit` is.
    [[nodiscard]] Rgb passing_to(const vec3& point, const Hit& hit, const vec3& direction,
                                 const LightLinks* links) const;

    const Scene& scene_;
    const Media& media_;
    const MeshEmitters& emitters_;
    std::shared_ptr<const LightTree> tree_; ///< Of those of its triangles that light media; none: nothing does.
    bool has_met_alone_ = false;            ///< What lights media, and is met by directions alone.
    bool attenuates_light_, has_glowing_media_ = false, draws_directions_ = false;
    std::uint32_t draw_count_ = 1, turn_ = 1;
};
} // namespace tyndall::render
