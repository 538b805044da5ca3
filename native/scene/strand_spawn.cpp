// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/strand_spawn.hpp"
#include "scene/strands.hpp"

namespace tyndall {
SpawnPoint strand_spawn_point(const Scene& scene, const Hit& hit, const SpawnPoint& spawn) {
    const PlacedShape* placed = scene.placed_shape(hit.instance);
    const Strands* strands = placed != nullptr ? scene.description().shapes[placed->shape_index]->strands() : nullptr;
    if (strands == nullptr || strands->form() != StrandForm::Ribbon)
        return spawn;
    const StrandPoint at = strands->on_spline(static_cast<std::uint32_t>(hit.cell), hit.barycentrics.x);
    const vec3 centre(placed->world_from_object * vec4(at.centre, 1.0f)), aside = spawn.position - centre;
    const float aside_m = glm::length(aside);
    if (!(aside_m > 0.0f))
        return spawn;
    return {.position = centre, .normal = aside / aside_m, .offset_m = aside_m};
}
} // namespace tyndall
