// SPDX-License-Identifier: GPL-3.0-or-later
// Coloured voxels that the tables of attributes are about, one set at a time: the dragon and Sponza with the formulas of
// voxel_attributes.hpp, and two models of other people's, which have no normals.
#pragma once
#include "support/packed_voxels.hpp"
#include "support/tree_entries.hpp"
#include "support/voxel_attributes.hpp"
#include "support/voxel_pictures.hpp"
#include "voxel_dag/cielab.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/vox_scene.hpp"
#include "voxel_dag/voxelize.hpp"

namespace tyndall::bench {
struct ModelSource {
    const char* name;
    const char* file;         ///< Of shared data: a .vox; null: one of the meshes.
    std::int64_t mesh;        ///< bare_mesh().
    std::uint32_t resolution; ///< Of a mesh.
    View view;
};
inline constexpr std::size_t model_count = 4;
inline const std::array<ModelSource, model_count>& model_sources() {
    static const std::array<ModelSource, model_count> sources{{
        {"dragon_4096", nullptr, 0, 4096, {{0.45f, 0.5f, 1.0f}, {0.5f, 0.36f, 0.2f}, {0, 1, 0}, {0.5f, 1, 0.8f}, 0.4f}},
        {"Sponza_2048", nullptr, 1, 2048, {{0.2f, 0.1f, 0.3f}, {0.9f, 0.14f, 0.3f}, {0, 1, 0}, {0.2f, 1, 0.25f}, 0.7f}},
        {"monu6",
         "voxel_models/monu6.vox",
         0,
         0,
         {{1.1f, -0.5f, 0.8f}, {0.4f, 0.4f, 0.25f}, {0, 0, 1}, {1, -0.6f, 1.4f}, 0.4f}},
        {"monu8",
         "voxel_models/monu8.vox",
         0,
         0,
         {{1.1f, -0.5f, 0.8f}, {0.4f, 0.4f, 0.25f}, {0, 0, 1}, {1, -0.6f, 1.4f}, 0.4f}},
    }};
    return sources;
}

struct Model {
    const ModelSource* source = nullptr;
    voxel_dag::LeafMasks leaves;
    voxel_dag::VoxelAttributes attributes; ///< 24 and 32 bits.
    voxel_dag::Dag plain;                  ///< Without turns.
    voxel_dag::PackedDag dag;              ///< With the cube's 48.
    TreeEntries tree;
    std::optional<Picture> all_colors, all_normals; ///< Of either alone, without loss.

    [[nodiscard]] std::string name() const { return source->name; }
};

/// Between the order of DAGs, red lowest, and that of palettes, red highest.
inline std::uint32_t with_ends_exchanged(std::uint32_t color) {
    return (color & 0xff) << 16 | (color & 0xff00) | (color >> 16 & 0xff);
}
inline std::vector<std::uint32_t> with_ends_exchanged(std::vector<std::uint32_t> colors) {
    for (std::uint32_t& color : colors)
        color = with_ends_exchanged(color);
    return colors;
}

inline Model made_model(const ModelSource& source) {
    const Progress progress;
    Model model;
    model.source = &source;
    if (source.file != nullptr) {
        if (!std::ifstream(shared_data(source.file)))
            return model;
        voxel_dag::vox::PlacedVoxels placed = voxel_dag::vox::read_placed(shared_data(source.file), 1.0, {}, progress);
        model.leaves = std::move(placed.leaves);
        model.attributes.colors = std::move(placed.attributes.colors);
    } else if (const BareMesh* const mesh = bare_mesh(source.mesh)) {
        model.leaves = voxel_dag::voxelize(std::span<const vec3>(mesh->positions), mesh->triangles,
                                           {.resolution = source.resolution}, progress)
                           .leaves;
        VoxelAttributes values = voxel_attributes(*mesh, model.leaves, AttributeBits::Full);
        model.attributes.colors = with_ends_exchanged(std::move(values.baked));
        model.attributes.normals = std::move(values.normals);
    } else {
        return model;
    }
    model.plain = build_dag(model.leaves, {}, progress);
    model.dag = pack_dag(merge_symmetric(model.plain, {}, progress), progress);
    model.tree = tree_entries(model.leaves, model.attributes);
    return model;
}
/// The last one asked for is kept. Without voxels where its file is not there.
inline Model& model_at(std::size_t index) {
    static Model kept;
    const ModelSource& source = model_sources()[index];
    if (kept.source != &source) {
        kept = {};
        kept = made_model(source);
    }
    return kept;
}
} // namespace tyndall::bench
