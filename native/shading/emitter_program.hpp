// SPDX-License-Identifier: GPL-3.0-or-later
// A surface program on a flat light: what the node tree of an area light is, drawn as a picture of it.
// Based on: blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/kernel/light/area.h and svm: which vectors an area light's shader
//           sees. Measured in the three; tests/blender/test_area_light_nodes.py compares pictures.
// Differs:  drawn once, as seen from straight before it. What changes with the direction or the distance from which
//           the light is seen is the sync's to report.
#pragma once
#include "core/progress.hpp"
#include "shading/program_point.hpp"

namespace tyndall {
/// A rectangle in the plane z = 0 of its object, around the origin, that shines along -Z.
struct FlatEmitter {
    mat4 world_from_object{1.0f};
    vec2 size{1.0f}; ///< In the object's space.
    /// Its points know an object's space and UV maps; up to 3.x only the world's, and UV maps are 0.
    bool is_object = true;
};

class EmitterProgram {
public:
    /// Throws InvalidInput that names a material that cannot run.
    explicit EmitterProgram(Material material);
    /// The material's emission at the middles of width * height texels, rows from -Y to +Y. All UV maps run from (0, 0) to
    /// (1, 1) over the rectangle. Throws Cancelled.
    [[nodiscard]] std::vector<Rgb> image(const FlatEmitter& emitter, std::uint32_t width, std::uint32_t height,
                                         const Progress& progress) const;

private:
    Material material_;
};
} // namespace tyndall
