// SPDX-License-Identifier: GPL-3.0-or-later
// Voxel DAGs of other programs' files and grids, and back.
#include "bindings/arrays.hpp"
#include "bindings/paths.hpp"
#include "bindings/voxel_dag.hpp"
#include "voxel_dag/coarse_voxels.hpp"
#include "voxel_dag/leaf_blocks.hpp"
#include "voxel_dag/open_faces.hpp"
#include "voxel_dag/vox_scene.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;
using namespace voxel_dag;

static std::shared_ptr<PlacedDag> import_vox(const py::object& path, double voxel_size_m, Symmetry symmetry,
                                             const AttributeConfig& attribute_config, std::uint64_t memory_budget_bytes,
                                             const Progress& progress) {
    const std::string file = path_of(path);
    return without_gil([&] {
        const vox::PlacedVoxels scene =
            vox::read_placed(file, voxel_size_m, {.memory_budget_bytes = memory_budget_bytes}, progress);
        return packed(
            scene.leaves, scene.attributes, scene.bounds_m,
            {.symmetry = symmetry, .attributes = attribute_config, .memory_budget_bytes = memory_budget_bytes},
            progress);
    });
}

static std::shared_ptr<PlacedDag> dag_of_blocks(const py::array& origins, const py::array& words, std::uint32_t level,
                                                bool is_shell, const Bounds& bounds, Symmetry symmetry,
                                                std::uint64_t memory_budget_bytes, const Progress& progress) {
    check_array<std::uint32_t>(origins, {-1, 3}, "origins");
    check_array<std::uint64_t>(words, {origins.shape(0), 8}, "words");
    const auto count = static_cast<std::size_t>(origins.shape(0));
    const std::span places(static_cast<const Voxel*>(origins.data()), count);
    const std::span bits(static_cast<const BlockBits*>(words.data()), count);
    return without_gil([&] {
        const LeafMasks leaves = leaf_masks_of(places, bits, level, progress);
        return packed(is_shell ? shell_of(leaves, progress) : leaves, {}, cube_of(bounds),
                      {.symmetry = symmetry, .attributes = {}, .memory_budget_bytes = memory_budget_bytes}, progress);
    });
}

static void save_vox(const PlacedDag& self, const py::object& path, bool is_quantized,
                     std::uint64_t memory_budget_bytes, const Progress& progress) {
    const std::string file = path_of(path);
    without_gil([&] {
        const LeafMasks leaves = coarse_voxels(self.dag, 0, memory_budget_bytes, progress);
        std::vector<ByteColor> colors;
        if (self.attributes && self.attributes->layout().has_colors)
            colors = colors_at(self.dag, *self.attributes, voxels_of(leaves), 0, progress);
        vox::write_placed(leaves, colors, self.bounds_m,
                          is_quantized ? vox::TooManyColors::Quantize : vox::TooManyColors::Refuse, file, progress);
    });
}

void bind_voxel_files(py::module_& native, VoxelDagClass& type) {
    type.def("save_vox", &save_vox, "path"_a, "is_quantized"_a, "memory_budget_bytes"_a, "progress"_a,
             "Releases the GIL. InvalidInput: what a .vox file has no room for; IoError: the path and why; Cancelled.");
    native.def(
        "import_vox", &import_vox, "path"_a, "voxel_size_m"_a, "symmetry"_a, "attribute_config"_a,
        "memory_budget_bytes"_a, "progress"_a,
        R"(Releases the GIL. IoError: the path and the chunk that is damaged; InvalidInput: a scene that is too large, a
value; Cancelled.)");
    native.def(
        "voxel_dag_of_blocks", &dag_of_blocks, "origins"_a, "words"_a, "level"_a, "is_shell"_a, "bounds"_a,
        "symmetry"_a, "memory_budget_bytes"_a, "progress"_a,
        R"(origins: uint32 (n, 3), below 2 ** level, of blocks of 8 x 8 x 8; words: uint64 (n, 8), bit 8 y + z of word
x. is_shell: only voxels with a face towards one that is not set. Releases the GIL. TypeError: dtype or shape;
InvalidInput: a value; Cancelled.)");
}
} // namespace tyndall::bindings
