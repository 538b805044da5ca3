// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/occluders.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/shape_faces.hpp"
#include "light_shafts/strand_bands.hpp"
#include "scene/strands.hpp"
#include <algorithm>
#include <map>
#include <numeric>
#include <optional>

namespace tyndall::light_shafts {
namespace {
/// A mesh with the slots whose triangles stop light.
struct MeshUse {
    std::uint32_t mesh;
    std::vector<bool> is_opaque; ///< Empty: all of them.
    auto operator<=>(const MeshUse&) const = default;
};

/// A mesh with the material of each slot whose triangles let a part of the light pass.
struct PartialUse {
    static constexpr std::uint32_t none = ~0u;
    std::uint32_t mesh;
    std::vector<std::uint32_t> materials;
    auto operator<=>(const PartialUse&) const = default;
};

struct Uses {
    std::optional<MeshUse> opaque;
    std::optional<PartialUse> partial;
};
Uses uses_of(const SceneDescription& scene, const Instance& instance) {
    MeshUse opaque{.mesh = instance.mesh_index, .is_opaque = {}};
    PartialUse partial{.mesh = instance.mesh_index, .materials = {}};
    for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot) {
        const std::uint32_t material = scene.slot_materials[instance.first_slot_material + slot];
        const Occlusion occlusion = occlusion_of(scene.materials[material]);
        opaque.is_opaque.push_back(occlusion == Occlusion::Opaque);
        partial.materials.push_back(occlusion == Occlusion::Partial ? material : PartialUse::none);
    }
    Uses uses;
    if (std::ranges::any_of(partial.materials, [](std::uint32_t material) { return material != PartialUse::none; }))
        uses.partial = std::move(partial);
    if (std::ranges::find(opaque.is_opaque, true) == opaque.is_opaque.end())
        return uses;
    if (std::ranges::find(opaque.is_opaque, false) == opaque.is_opaque.end())
        opaque.is_opaque.clear();
    uses.opaque = std::move(opaque);
    return uses;
}

/// Triangles of the slots for which `is_wanted`.
template <typename IsWanted>
std::vector<std::uint32_t> select(const SharedMeshArrays& mesh, std::size_t slot_count, const IsWanted& is_wanted) {
    std::vector<std::uint32_t> selected;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (is_wanted(std::min<std::size_t>(mesh.slot_of(t), slot_count - 1)))
            selected.push_back(t);
    }
    return selected;
}
std::unique_ptr<const OccluderMesh> make_mesh(const SharedMeshArrays& mesh, std::span<const std::uint32_t> selected) {
    std::vector<uvec3> triangles;
    for (const std::uint32_t t : selected)
        triangles.push_back(mesh.triangles[t]);
    return make_occluder_mesh(mesh.positions, triangles);
}
std::vector<std::uint32_t> select(const SharedMeshArrays& mesh, const std::vector<bool>& has_slot) {
    return select(mesh, has_slot.size(), [&](std::size_t slot) { return has_slot[slot]; });
}
std::unique_ptr<const OccluderMesh> make_mesh(const SharedMeshArrays& mesh, const std::vector<bool>& has_slot) {
    return has_slot.empty() ? make_occluder_mesh(mesh.positions, mesh.triangles)
                            : make_mesh(mesh, select(mesh, has_slot));
}

/// `lookup_of` is by material.
std::unique_ptr<const PartialOccluderMesh> make_partial_mesh(const SharedMeshArrays& mesh, const PartialUse& use,
                                                             const std::vector<bool>& has_slot,
                                                             std::shared_ptr<const OccluderMesh> geometry,
                                                             std::span<const TransparencyLookup* const> lookup_of) {
    auto partial = std::make_unique<PartialOccluderMesh>();
    partial->arrays = &mesh;
    const std::vector<std::uint32_t> selected = select(mesh, has_slot);
    partial->geometry = std::move(geometry);
    for (const std::uint32_t t : partial->geometry->order)
        partial->triangles.push_back(selected[t]);
    for (const std::uint32_t material : use.materials) {
        PartialOccluderMesh::Slot& slot = partial->slots.emplace_back();
        if (material == PartialUse::none)
            continue;
        slot.lookup = lookup_of[material];
        partial->is_coloured |= slot.lookup->is_coloured();
        for (const std::string& name : slot.lookup->material().uv_map_names) {
            const SharedMeshArrays::UvMap* map = mesh.uv_map(name);
            slot.corner_uvs.push_back(map == nullptr ? nullptr : map->corner_uvs.data());
        }
    }
    return partial;
}

PartialOccluderInstance placed_instance(const SceneDescription& scene, const PartialOccluderMesh& mesh,
                                        std::uint32_t index) {
    const Instance& instance = scene.instances[index];
    return {.mesh = &mesh,
            .scene_from_object = &instance.world_from_object,
            .index = index,
            .object_from_scene = glm::inverse(instance.world_from_object),
            .info = scene.object_infos.empty() ? nullptr : &scene.object_infos[instance.name_index],
            .random = instance.random,
            .particle = scene.particle_of(index),
            .origin_in_world = vec3(scene.origin_in_world)};
}

/// Spreads the lowest 10 bits to every third place.
std::uint32_t every_third(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

} // namespace

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
    parallel_for(
        triangles.size(), Progress(),
        [&](std::size_t t) {
            const uvec3 corners = triangles[t];
            const vec3 at = per_m * ((positions[corners.x] - bounds.min) + (positions[corners.y] - bounds.min) +
                                     (positions[corners.z] - bounds.min));
            std::uint32_t cell = 0;
            for (int axis = 0; axis < 3; ++axis) // a NaN lands in cell 0
                cell |= every_third(at[axis] > 0.0f ? static_cast<std::uint32_t>(std::min(at[axis], cells - 1.0f)) : 0u)
                        << axis;
            cell_of[t] = cell;
        },
        1 << 13);
    for (const std::uint32_t cell : cell_of)
        ++next[cell + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        order[next[cell_of[t]]++] = t;
    return order;
}

std::unique_ptr<const OccluderMesh> make_occluder_mesh(std::span<const vec3> positions,
                                                       std::span<const uvec3> triangles) {
    auto mesh = std::make_unique<OccluderMesh>();
    for (const uvec3& corners : triangles)
        for (int c = 0; c < 3; ++c)
            mesh->bounds.grow(positions[corners[c]]);
    mesh->order = order_in_space(positions, triangles, mesh->bounds);
    const std::vector<std::uint32_t>& order = mesh->order;
    const auto padded = [](std::size_t count) { return (count + 15) / 16 * 16; };
    constexpr std::size_t capacity = OccluderBlock::capacity;
    mesh->columns =
        large_vector<float>(9 * (triangles.size() / capacity * capacity + padded(triangles.size() % capacity)));
    mesh->blocks.resize((triangles.size() + capacity - 1) / capacity);
    const auto fill = [&](std::size_t index) {
        const std::size_t start = index * capacity;
        const std::size_t count = std::min(capacity, triangles.size() - start), stride = padded(count);
        float* columns = mesh->columns.data() + 9 * start;
        OccluderBlock& block = mesh->blocks[index];
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
    };
    parallel_for(mesh->blocks.size(), Progress(), fill, 16);
    return mesh;
}

std::shared_ptr<const OccluderMesh> Occluders::mesh_of(const Source& source) const {
    const auto found = meshes.find(source);
    return found == meshes.end() ? nullptr : found->second;
}

void Occluders::add(const OccluderMesh* mesh, const mat4* scene_from_object, std::uint32_t index) {
    instances.push_back({mesh, scene_from_object, index});
    for (const OccluderBlock& block : mesh->blocks)
        triangle_count += block.count;
}

void Occluders::add(std::unique_ptr<const OccluderMesh> mesh, const mat4* scene_from_object) {
    add(mesh.get(), scene_from_object);
    meshes.emplace(Source(), std::move(mesh));
}

/// Uses without their repetitions, and which one each instance has.
template <typename Use>
struct DistinctUses {
    std::map<Use, std::size_t> index_of;
    std::vector<Use> uses;
    std::vector<std::pair<std::size_t, std::uint32_t>> instances; ///< Into uses, and into the scene's instances.

    void add(Use use, std::uint32_t instance) {
        const auto [found, is_new] = index_of.try_emplace(std::move(use), uses.size());
        if (is_new)
            uses.push_back(found->first);
        instances.emplace_back(found->second, instance);
    }
};

bool is_drawn(const ShapeGeometry& shape, std::size_t place_count) {
    if (const CellShape* const cells = shape.cells())
        return cells->cell_count() <= most_cells_with_faces / place_count;
    const Strands* const strands = shape.strands();
    return strands != nullptr && strands->are_splines() &&
           strands->segment_count() <= most_segments_with_bands / place_count;
}

static std::unique_ptr<const OccluderMesh> drawn_mesh(const ShapeGeometry& shape) {
    const CellShape* const cells = shape.cells();
    return cells != nullptr ? make_face_mesh(*cells) : make_band_mesh(*shape.strands());
}

/// Shapes join the instances by what is drawn of them, or are traced.
static void gather_shapes(const SceneDescription& scene, const Occluders* another, Occluders& occluders,
                          const Progress& progress) {
    std::vector<std::vector<std::uint32_t>> placed_of(scene.shapes.size());
    for (std::uint32_t i = 0; i < scene.placed_shapes.size(); ++i)
        if (const std::optional<std::uint32_t> shade = shade_of(scene, scene.placed_shapes[i]))
            placed_of[*shade].push_back(i);
    std::vector<std::uint32_t> traced;
    for (std::size_t index = 0; index < placed_of.size(); ++index) {
        progress.poll();
        const std::vector<std::uint32_t>& placed = placed_of[index];
        if (placed.empty())
            continue;
        if (!is_drawn(*scene.shapes[index], placed.size())) {
            traced.insert(traced.end(), placed.begin(), placed.end());
            continue;
        }
        Occluders::Source source{scene.shapes[index], {}};
        std::shared_ptr<const OccluderMesh> mesh = another ? another->mesh_of(source) : nullptr;
        if (!mesh)
            mesh = drawn_mesh(*scene.shapes[index]);
        occluders.meshes.emplace(std::move(source), mesh);
        for (const std::uint32_t i : placed)
            occluders.add(mesh.get(), &scene.placed_shapes[i].world_from_object,
                          static_cast<std::uint32_t>(scene.instances.size()) + i);
    }
    if (!traced.empty())
        occluders.traced = std::make_shared<const ShapeTracer>(scene, std::move(traced), progress);
}

Occluders gather_occluders(const SceneDescription& scene, const Progress& progress, const Occluders* another) {
    Occluders occluders;
    DistinctUses<MeshUse> opaque;
    DistinctUses<PartialUse> partial;
    occluders.are_whole =
        std::ranges::none_of(scene.placed_shapes, [](const PlacedShape& placed) { return placed.casts_shadow; });
    for (std::uint32_t index = 0; index < scene.instances.size(); ++index) {
        const Instance& instance = scene.instances[index];
        if (!instance.casts_shadow || instance.slot_count == 0)
            continue;
        Uses uses = uses_of(scene, instance);
        occluders.are_whole &= uses.opaque ? uses.opaque->is_opaque.empty() : !scene.has_surface(instance);
        if (uses.opaque)
            opaque.add(std::move(*uses.opaque), index);
        if (uses.partial)
            partial.add(std::move(*uses.partial), index);
    }
    std::vector<const TransparencyLookup*> lookup_of(scene.materials.size(), nullptr);
    for (const PartialUse& use : partial.uses)
        for (const std::uint32_t material : use.materials)
            if (material != PartialUse::none && lookup_of[material] == nullptr)
                lookup_of[material] =
                    occluders.lookups
                        .emplace_back(std::make_unique<const TransparencyLookup>(scene.materials[material]))
                        .get();
    std::vector<Occluders::Source> sources; // of the opaque uses, then of the partial ones
    for (const MeshUse& use : opaque.uses)
        sources.push_back({scene.meshes[use.mesh], use.is_opaque});
    for (const PartialUse& use : partial.uses) {
        Occluders::Source& source = sources.emplace_back(scene.meshes[use.mesh], std::vector<bool>());
        for (const std::uint32_t material : use.materials)
            source.has_slot.push_back(material != PartialUse::none);
    }
    std::vector<std::shared_ptr<const OccluderMesh>> meshes(sources.size());
    occluders.partial_meshes.resize(partial.uses.size());
    parallel_for(
        sources.size(), progress,
        [&](std::size_t i) {
            const bool is_partial = i >= opaque.uses.size();
            const std::size_t of_partial = i - opaque.uses.size();
            const SharedMeshArrays& arrays =
                scene.meshes[is_partial ? partial.uses[of_partial].mesh : opaque.uses[i].mesh]->arrays();
            if (another != nullptr)
                meshes[i] = another->mesh_of(sources[i]);
            if (!meshes[i])
                meshes[i] = make_mesh(arrays, sources[i].has_slot);
            if (is_partial)
                occluders.partial_meshes[of_partial] =
                    make_partial_mesh(arrays, partial.uses[of_partial], sources[i].has_slot, meshes[i], lookup_of);
        },
        1);
    for (const auto& [use, instance] : opaque.instances)
        occluders.add(meshes[use].get(), &scene.instances[instance].world_from_object, instance);
    for (std::size_t i = 0; i < sources.size(); ++i)
        occluders.meshes.emplace(std::move(sources[i]), std::move(meshes[i]));
    for (const auto& [use, instance] : partial.instances)
        if (const auto& mesh = occluders.partial_meshes[use]; !mesh->triangles.empty())
            occluders.partial_instances.push_back(placed_instance(scene, *mesh, instance));
    gather_shapes(scene, another, occluders, progress);
    return occluders;
}

std::unique_ptr<const Occluders> blocking(const Scene& scene, const Occluders& occluders, const LightLinks& links,
                                          const Progress& progress) {
    auto some = std::make_unique<Occluders>();
    for (const OccluderInstance& instance : occluders.instances)
        if (scene.blocks(instance.index, links))
            some->add(instance.mesh, instance.scene_from_object, instance.index);
    for (const PartialOccluderInstance& instance : occluders.partial_instances)
        if (scene.blocks(instance.index, links))
            some->partial_instances.push_back(instance);
    std::vector<std::uint32_t> traced;
    for (const std::uint32_t placed : occluders.traced ? occluders.traced->placed() : std::span<const std::uint32_t>())
        if (scene.blocks(static_cast<std::uint32_t>(scene.description().instances.size()) + placed, links))
            traced.push_back(placed);
    if (!traced.empty())
        some->traced = std::make_shared<const ShapeTracer>(scene.description(), std::move(traced), progress);
    if (occluders.kept)
        some->kept = occluders.kept->of(scene.description(), *some);
    return some;
}
} // namespace tyndall::light_shafts
