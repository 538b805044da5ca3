// SPDX-License-Identifier: GPL-3.0-or-later
// Light of meshes that glow, scattered once by media towards the camera: a few draws per part of a view ray.
// Based on: next event estimation; light_tree_along.cpp chooses a triangle for the ray, glow_distances.hpp where its light
//           is scattered, and triangle_point() a place on it, evenly in the solid angle from there.
// Differs:  from lamps' light shafts, which have no noise: rows of what shadows a lamp serve many rays, and an area of
//           thousands of triangles has no few strata. The estimate is not weighed with others: the light per metre and
//           steradian has no singularity that one of the three choices would leave over.
// Data flow: part of a view ray -> its pieces in media, once (media_line.hpp) -> per draw: triangle, distance, place, one
//           shadow ray -> radiance, by light groups where these are kept apart.
// Bound:    a draw takes 1 us in a fog box and its shadow ray; the error of n draws falls with 1 / sqrt(n). 60 bytes a
//           triangle beside those of mesh_emitters.hpp.
#pragma once
#include "core/statistics.hpp"
#include "render/media_line.hpp"
#include "render/mesh_emitters.hpp"

namespace tyndall::render {
class FogGlow {
public:
    /// Draws of a part at most: then they take twice the time of a camera ray, and their noise is most of what is left.
    static constexpr std::uint32_t most_draws = 8;
    /// The references must outlive this. Reports what is not followed.
    FogGlow(const Scene& scene, const Media& media, const MeshEmitters& emitters, bool attenuates_light,
            Statistics& statistics);

    /// Nothing glows that lights media, or no medium scatters.
    [[nodiscard]] bool is_empty() const { return tree_.is_empty(); }
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
    /// One draw: in the mean over all of them, what all triangles give.
    [[nodiscard]] Found draw(const MediaLine& line, const Numbers& numbers) const;
    /// The pieces of a part.
    void assign(MediaLine& line, const light_shafts::ViewRay& part) const { line.assign(media_, part, StepLimits{}); }

    /// How many draws a part gets in each sample: as many as the error target asks for in some of the parts, a power of two up to
    /// most_draws.
    [[nodiscard]] std::uint32_t count_draws(std::span<const light_shafts::ViewRay> parts, float error_target,
                                            std::uint32_t pixel_samples, const Progress& progress) const;

private:
    /// From a place on a triangle, which `hit` is.
    [[nodiscard]] Rgb passing_to(const vec3& point, const Hit& hit, const vec3& direction,
                                 const LightLinks* links) const;

    const Scene& scene_;
    const Media& media_;
    const MeshEmitters& emitters_;
    LightTree tree_; ///< Of those of its triangles that light media.
    bool attenuates_light_;
};
} // namespace tyndall::render
