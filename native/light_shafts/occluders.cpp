// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/occluders.hpp"
#include "core/parallel.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <map>
#include <numeric>

namespace tyndall::light_shafts {
namespace {
enum class Passage : std::uint8_t { Everything, Something, Nothing };

Passage passage(const Material& material) {
    if (!material.has_surface || (material.is_constant() && material.constant.transparent == Rgb(1.0f)))
        return Passage::Everything;
    return is_opaque_everywhere(material) ? Passage::Nothing : Passage::Something;
}

/// A mesh with the slots whose triangles stop light.
struct MeshUse {
    std::uint32_t mesh;
    std::vector<bool> is_opaque; ///< Empty: all of them.
    auto operator<=>(const MeshUse&) const = default;
};

std::optional<MeshUse> use_of(const SceneDescription& scene, const Instance& instance,
                              std::optional<std::string>& transmitting_material) {
    MeshUse use{.mesh = instance.mesh_index, .is_opaque = {}};
    for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot) {
        const Material& material = scene.materials[scene.slot_materials[instance.first_slot_material + slot]];
        const Passage passes = passage(material);
        use.is_opaque.push_back(passes == Passage::Nothing);
        if (passes == Passage::Something)
            transmitting_material = material.name;
    }
    if (std::ranges::find(use.is_opaque, true) == use.is_opaque.end())
        return std::nullopt;
    if (std::ranges::find(use.is_opaque, false) == use.is_opaque.end())
        use.is_opaque.clear();
    return use;
}

std::unique_ptr<const OccluderMesh> make_mesh(const MeshArrays& mesh, const MeshUse& use) {
    if (use.is_opaque.empty())
        return make_occluder_mesh(mesh.positions, mesh.triangles);
    std::vector<uvec3> selected;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::size_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[t];
        if (use.is_opaque[std::min(slot, use.is_opaque.size() - 1)])
            selected.push_back(mesh.triangles[t]);
    }
    return make_occluder_mesh(mesh.positions, selected);
}

/// Spreads the lowest 10 bits to every third place.
std::uint32_t every_third(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// The triangles in the order of the cells of a coarse grid, along Morton's curve, so that blocks are small.
std::vector<std::uint32_t> order_in_space(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                          const Bounds3& bounds) {
    std::vector<std::uint32_t> order(triangles.size());
    std::uint32_t bits = 0; // per axis: half a block per cell
    while (bits < 6 && (std::size_t{OccluderBlock::capacity / 2} << (3 * bits)) < triangles.size())
        ++bits;
    if (triangles.size() <= 2 * OccluderBlock::capacity) {
        std::iota(order.begin(), order.end(), 0u);
        return order;
    }
    const auto cells = static_cast<float>(1u << bits);
    const vec3 per_m = cells / glm::max(3.0f * (bounds.max - bounds.min), vec3(1e-30f));
    std::vector<std::uint32_t> cell_of(triangles.size()), next((std::size_t{1} << (3 * bits)) + 1, 0);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const uvec3 corners = triangles[t];
        const vec3 at = per_m * ((positions[corners.x] - bounds.min) + (positions[corners.y] - bounds.min) +
                                 (positions[corners.z] - bounds.min));
        std::uint32_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) // a NaN lands in cell 0
            cell |= every_third(at[axis] > 0.0f ? static_cast<std::uint32_t>(std::min(at[axis], cells - 1.0f)) : 0u)
                    << axis;
        cell_of[t] = cell;
        ++next[cell + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        order[next[cell_of[t]]++] = t;
    return order;
}
} // namespace

std::unique_ptr<const OccluderMesh> make_occluder_mesh(std::span<const vec3> positions,
                                                       std::span<const uvec3> triangles) {
    auto mesh = std::make_unique<OccluderMesh>();
    for (const uvec3& corners : triangles)
        for (int c = 0; c < 3; ++c)
            mesh->bounds.grow(positions[corners[c]]);
    const std::vector<std::uint32_t> order = order_in_space(positions, triangles, mesh->bounds);
    const auto padded = [](std::size_t count) { return (count + 15) / 16 * 16; };
    constexpr std::size_t capacity = OccluderBlock::capacity;
    mesh->columns.resize(9 * (triangles.size() / capacity * capacity + padded(triangles.size() % capacity)));
    for (std::size_t start = 0; start < triangles.size(); start += capacity) {
        const std::size_t count = std::min(capacity, triangles.size() - start), stride = padded(count);
        float* columns = mesh->columns.data() + 9 * start;
        OccluderBlock& block = mesh->blocks.emplace_back();
        block.columns = columns;
        block.stride = static_cast<std::uint32_t>(stride);
        block.count = static_cast<std::uint32_t>(count);
        for (std::size_t t = 0; t < stride; ++t) {
            const uvec3 corners = triangles[order[start + std::min(t, count - 1)]];
            for (std::size_t c = 0; c < 3; ++c) {
                const vec3 corner = positions[corners[static_cast<int>(c)]];
                block.bounds.grow(corner);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    columns[(3 * c + axis) * stride + t] = corner[static_cast<int>(axis)];
            }
        }
    }
    return mesh;
}

void Occluders::add(const OccluderMesh* mesh, const mat4* scene_from_object) {
    instances.push_back({mesh, scene_from_object});
    for (const OccluderBlock& block : mesh->blocks)
        triangle_count += block.count;
}

Occluders gather_occluders(const SceneDescription& scene, const Progress& progress) {
    Occluders occluders;
    std::map<MeshUse, std::size_t> index_of; // into uses
    std::vector<MeshUse> uses;
    std::vector<std::pair<std::size_t, const mat4*>> instances;
    for (const Instance& instance : scene.instances) {
        if (!instance.casts_shadow || instance.slot_count == 0)
            continue;
        if (auto use = use_of(scene, instance, occluders.transmitting_material)) {
            const auto [found, is_new] = index_of.try_emplace(*use, uses.size());
            if (is_new)
                uses.push_back(std::move(*use));
            instances.emplace_back(found->second, &instance.world_from_object);
        }
    }
    occluders.meshes.resize(uses.size());
    parallel_for(
        uses.size(), progress,
        [&](std::size_t i) { occluders.meshes[i] = make_mesh(scene.meshes[uses[i].mesh]->arrays(), uses[i]); }, 1);
    for (const auto& [mesh, scene_from_object] : instances)
        occluders.add(occluders.meshes[mesh].get(), scene_from_object);
    return occluders;
}
} // namespace tyndall::light_shafts
