// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/occluders.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
namespace {
enum class Passage : std::uint8_t { Everything, Something, Nothing };

Passage passage(const Material& material) {
    if (!material.has_surface || (material.is_constant() && material.constant.transparent == Rgb(1.0f)))
        return Passage::Everything;
    return is_opaque_everywhere(material) ? Passage::Nothing : Passage::Something;
}
} // namespace

static std::span<const uvec3> opaque_triangles(const SceneDescription& scene, const Instance& instance,
                                               Occluders& occluders) {
    const MeshArrays& mesh = scene.meshes[instance.mesh_index]->arrays();
    std::vector<Passage> passages;
    for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot) {
        const Material& material = scene.materials[scene.slot_materials[instance.first_slot_material + slot]];
        passages.push_back(passage(material));
        if (passages.back() == Passage::Something)
            occluders.transmitting_material = material.name;
    }
    const auto is_opaque = [](Passage p) { return p == Passage::Nothing; };
    if (std::all_of(passages.begin(), passages.end(), is_opaque))
        return mesh.triangles;
    if (std::none_of(passages.begin(), passages.end(), is_opaque))
        return {};
    auto& selected = *occluders.selected.emplace_back(std::make_unique<std::vector<uvec3>>());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::size_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[t];
        if (is_opaque(passages[std::min(slot, passages.size() - 1)]))
            selected.push_back(mesh.triangles[t]);
    }
    return selected;
}

Occluders gather_occluders(const SceneDescription& scene) {
    Occluders occluders;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (!instance.casts_shadow || instance.slot_count == 0)
            continue;
        const auto triangles = opaque_triangles(scene, instance, occluders);
        const MeshArrays& mesh = scene.meshes[instance.mesh_index]->arrays();
        for (std::size_t start = 0; start < triangles.size(); start += Occluders::piece_triangles) {
            const std::size_t count = std::min(Occluders::piece_triangles, triangles.size() - start);
            occluders.pieces.push_back({static_cast<std::uint32_t>(i), mesh.positions, triangles.subspan(start, count),
                                        &instance.world_from_object});
        }
        occluders.triangle_count += triangles.size();
    }
    return occluders;
}
} // namespace tyndall::light_shafts
