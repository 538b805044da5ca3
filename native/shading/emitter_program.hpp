// SPDX-License-Identifier: GPL-3.0-or-later
// A surface program on a light: what the node tree of an area light is, drawn as a picture of it, and that of a lamp, by the
// direction in which its light leaves.
// Based on: blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/kernel/light and svm: which vectors a light's shader sees.
//           Measured in the three; tests/blender/test_area_light_nodes.py and test_lamp_nodes.py compare pictures.
// Differs:  drawn once: an area light as seen from straight before it, a lamp as if its normal were the direction. What
//           else changes with the direction or the distance from which the light is seen is the sync's to report.
#pragma once
#include "core/progress.hpp"
#include "shading/program_point.hpp"
#include <span>

namespace tyndall {
/// What Object Info says of a light.
struct EmitterObject {
    ObjectInfo info = {};
    float random = 0.0f; ///< [0, 1]
};

/// A rectangle in the plane z = 0 of its object, around the origin, that shines along -Z.
struct FlatEmitter {
    mat4 world_from_object{1.0f};
    vec2 size{1.0f}; ///< In the object's space.
    /// Its points know an object's space and UV maps; up to 3.x only the world's, and UV maps are 0.
    bool is_object = true;
    EmitterObject object = {};
};

/// A lamp: what its points know beside the direction in which they shine.
struct LocalEmitter {
    mat4 world_from_object{1.0f};
    vec3 middle{0.0f};
    float radius_m = 0.0f; ///< So far from its middle they lie, in that direction.
    EmitterObject object = {};
};
/// One point of it.
struct EmitterPoint {
    vec3 direction{0, 0, 1}; ///< Unit, in the world.
    vec2 uv{0.0f};           ///< Of all UV maps.
    vec2 barycentrics{0.0f};
};

class EmitterProgram {
public:
    /// Throws InvalidInput that names a material that cannot run.
    explicit EmitterProgram(Material material);
    /// The material's emission at the middles of width * height texels, rows from -Y to +Y. All UV maps run from (0, 0) to
    /// (1, 1) over the rectangle. Throws Cancelled.
    [[nodiscard]] std::vector<Rgb> image(const FlatEmitter& emitter, std::uint32_t width, std::uint32_t height,
                                         const Progress& progress) const;
    /// The same of points of a lamp. Throws Cancelled.
    [[nodiscard]] std::vector<Rgb> leaving(const LocalEmitter& lamp, std::span<const EmitterPoint> points,
                                           const Progress& progress) const;

private:
    Material material_;
};
} // namespace tyndall
