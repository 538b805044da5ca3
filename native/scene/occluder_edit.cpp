// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/occluder_edit.hpp"
#include "core/errors.hpp"
#include <algorithm>

namespace tyndall {
void require_usable(const OccluderEdit& edit) {
    constexpr float largest_m = 1e6f, smallest_m = 1e-6f;
    require(edit.kind <= EditKind::Holes && edit.shape <= KernelShape::Square, "kind ", static_cast<int>(edit.kind),
            " or shape ", static_cast<int>(edit.shape), " is unknown");
    require_in(edit.size_m, 0.0f, largest_m, "size_m");
    require_in(edit.distance_m, smallest_m, largest_m, "distance_m");
    require_in(edit.noise.scale_m, smallest_m, largest_m, "scale_m");
    require(1 <= edit.noise.octaves && edit.noise.octaves <= 12, "octaves is ", edit.noise.octaves,
            ", outside [1, 12]");
    require_in(edit.noise.persistence, 0.0f, 1.0f, "persistence");
    require_in(edit.noise.probability, 0.0f, 1.0f, "probability");
    require_in(edit.noise.sway, 0.0f, 100.0f, "sway");
    require(std::isfinite(edit.noise.turn_rad), "turn_rad is not finite");
    require(std::ranges::is_sorted(edit.objects), "objects do not rise");
    if (!edit.mask)
        return;
    require(edit.mask->width > 0 && edit.mask->height > 0 &&
                edit.mask->values.size() == std::size_t{edit.mask->width} * edit.mask->height,
            "mask \"", edit.mask->name, "\" has no pixels");
    require_in(edit.mask->size_m, smallest_m, largest_m, "size_m of mask \"" + edit.mask->name + "\"");
}
} // namespace tyndall
