// SPDX-License-Identifier: GPL-3.0-or-later
// Light from infinitely far away: one radiance, or an equirectangular image of it, importance-sampled by luminance.
#pragma once
#include "core/math.hpp"
#include "core/shared_array.hpp"
#include "scene/lit_kinds.hpp"
#include "shading/direction_program.hpp"
#include "shading/light_links.hpp"
#include <memory>
#include <string>
#include <vector>

namespace tyndall {
/// Equirectangular radiance image in Blender's convention, rows bottom to top, as Image.pixels delivers it.
struct EnvironmentImage {
    std::string name;
    std::uint32_t width = 0, height = 0;
    SharedArray<vec4> pixels = {}; ///< width * height, scene-linear; the fourth value counts for nothing.
};

class EnvironmentImportance; // environment_importance.hpp

/// What cameras see in place of the light; either may be missing.
struct SeenWorld {
    std::shared_ptr<const EnvironmentImage> image = nullptr;   ///< Turned and multiplied as the world's own.
    std::shared_ptr<const DirectionProgram> program = nullptr; ///< The radiance itself; before an image.
    bool operator==(const SeenWorld&) const = default;
};

/// Copies share the image and its tables.
class World {
public:
    World() = default;
    /// Radiance is `radiance` times the image, if there is one. Pixels that are not finite are black, as in Cycles.
    /// Cameras see `seen`, which gives no light; nothing: they see the image. Throws InvalidInput that names the
    /// world: a radiance that is not finite, an image of another size than it says.
    World(std::string name, Rgb radiance, std::shared_ptr<const EnvironmentImage> image = nullptr,
          mat3 image_from_world = mat3(1.0f), SeenWorld seen = {});

    [[nodiscard]] bool is_black() const { return is_black_; }
    [[nodiscard]] bool has_image() const { return image_ != nullptr; }
    [[nodiscard]] Rgb radiance(const vec3& unit_direction) const;
    /// As a camera's rays see it, or those that surfaces send on, to which an image that cameras see does not show.
    [[nodiscard]] Rgb seen_radiance(const vec3& unit_direction, RayKind kind = RayKind::Camera) const;
    struct DirectionSample {
        vec3 direction; ///< Unit, towards the world.
        float pdf_per_sr;
        Rgb radiance;
    };
    [[nodiscard]] DirectionSample sample(vec2 u) const;
    [[nodiscard]] float pdf_per_sr(const vec3& unit_direction) const;
    /// Both at once, in half the time.
    struct Look {
        Rgb radiance;
        float pdf_per_sr;
    };
    [[nodiscard]] Look look(const vec3& unit_direction) const;
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::uint8_t light_group() const { return light_group_; }
    void set_light_group(std::uint8_t group) { light_group_ = group; }
    /// By its ray visibility.
    [[nodiscard]] const LitKinds& lights_surfaces() const { return lights_surfaces_; }
    [[nodiscard]] bool scatters_in_media() const { return scatters_in_media_ && !is_black_; }
    void set_lit(const LitKinds& surfaces, bool media) { lights_surfaces_ = surfaces, scatters_in_media_ = media; }
    /// The same radiance of the same image, not of an equal one; names do not count.
    [[nodiscard]] bool shines_as(const World& other) const {
        return radiance_ == other.radiance_ && image_ == other.image_ && seen_ == other.seen_ &&
               image_from_world_ == other.image_from_world_ && lights_surfaces_ == other.lights_surfaces_;
    }

private:
    std::string name_;
    Rgb radiance_{0.0f};
    std::shared_ptr<const EnvironmentImage> image_;
    SeenWorld seen_;
    mat3 image_from_world_{1.0f};
    bool is_black_ = true;
    std::uint8_t light_group_ = no_light_group;
    LitKinds lights_surfaces_ = {};
    bool scatters_in_media_ = true;
    std::shared_ptr<const EnvironmentImportance> importance_; ///< Nothing without an image.
};
} // namespace tyndall
