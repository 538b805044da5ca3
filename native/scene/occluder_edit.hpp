// SPDX-License-Identifier: GPL-3.0-or-later
// Edits of what stands between a light and the air: holes closed, made, silhouettes drawn out. The air sees the edited
// occluders; surfaces see them as they are, but for the edits that are meant for them, too.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1.
// Differs:  sizes are metres, not texels; each edit says which objects it means, and where.
#pragma once
#include "core/math.hpp"
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tyndall {
enum class EditKind : std::uint8_t {
    Close = 0,         ///< Holes up to a size vanish: a closing of the light's depth map.
    EpipolarClose = 1, ///< Along the light's planes through the camera only: no halo in mid-air.
    Silhouette = 2,    ///< Occluders grow away from the camera, behind what it sees of them (eq. 5.3).
    Holes = 3,         ///< Thresholded Perlin noise (eq. 5.4, 5.5).
};
enum class KernelShape : std::uint8_t { Disc = 0, Square = 1 };

/// Perlin noise in the light's own metres: holes stay where they are when the camera moves.
struct HoleNoise {
    float scale_m = 1.0f;      ///< Of its coarsest octave, (0, 1e6].
    std::uint32_t octaves = 3; ///< [1, 12]; each has twice the frequency of the one before.
    float persistence = 0.5f;  ///< [0, 1]: amplitude of an octave, of the one before.
    float probability = 0.3f;  ///< [0, 1]: share of holes.
    float sway = 0.0f;         ///< [0, 100]: how far the noise moves its own lookup, in units of scale_m; 0: none.
    float turn_rad = 0.0f;     ///< Turns the first lookup: over time, holes drift and change their form.
    std::uint32_t seed = 0;
    bool operator==(const HoleNoise&) const = default;
};

/// A picture in the light's space. Sun: size_m wide, upright along the light's axes, its middle on the line through the
/// light's origin. Spot: as wide as its cone. Point: all directions, equirectangular around the light's Z.
struct LightMask {
    std::string name; ///< For reports.
    std::uint32_t width = 0, height = 0;
    std::vector<float> values; ///< Rows bottom to top, [0, 1]; the edit works where it is at least 1/2, not outside.
    float size_m = 10.0f;      ///< (0, 1e6].
    bool operator==(const LightMask&) const = default;
};

struct OccluderEdit {
    std::string name; ///< For reports.
    EditKind kind = EditKind::Close;
    KernelShape shape = KernelShape::Disc; ///< Close.
    /// Close: diameter of the largest holes that vanish. EpipolarClose: their length. Silhouette: by how much. [0, 1e6].
    float size_m = 0.1f;
    /// Lamps: sizes are measured this far from the light, and grow with the distance. (0, 1e6].
    float distance_m = 5.0f;
    HoleNoise noise = {};          ///< Holes.
    bool affects_surfaces = false; ///< Surfaces see what it does, too: light through holes, the shadows of the others.
    bool affects_all = true;
    std::vector<std::uint32_t> objects = {}; ///< Into SceneDescription::object_names, rising; unless it affects all.
    std::shared_ptr<const LightMask> mask = {};
};

/// Throws InvalidInput that names what is out of its range.
void require_usable(const OccluderEdit& edit);
} // namespace tyndall
