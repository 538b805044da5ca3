// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh to a .tdag file within a memory budget, whatever the resolution, in parts that survive the end of the process.
// Based on: Jaspe, dissertation 2018, 5.3: sub-volumes are voxelized and reduced one by one, and merged bottom-up.
// Differs:  the file is, byte for byte, the one that the mesh makes at once in enough memory, however it was split. Parts
//           are files under a name that their mesh and settings make: whoever has the same job, in this process, in
//           another one, or on another machine that sees the folder, makes some of them, and what is finished is used.
// Bound:    the mesh as 24 bytes per vertex; one sub-cube's voxels, attributes and DAG at a time; then the whole DAG, as
//           join_parts.hpp and pack_dag.hpp say; then its packed bytes and join_attributes.hpp. On disk, the parts and, where
//           there are attributes, these twice.
#pragma once
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/part_file.hpp"
#include "voxel_dag/sub_volumes.hpp"
#include "voxel_dag/surface_attributes.hpp"

namespace tyndall::voxel_dag {
struct OutOfCoreConfig {
    VoxelizeConfig voxels; ///< Its budget is that of all memory beyond the mesh as it was handed in.
    Symmetry symmetry = Symmetry::Cube;
    bool is_solid = false;           ///< What the mesh closes around, too: solid_fill.hpp. Without a surface.
    Surface surface = {};            ///< What voxels carry; its arrays must outlive all of this.
    AttributeConfig attributes = {}; ///< Its budget is not looked at.
    std::uint32_t worker_count = 1;  ///< Processes that make parts side by side, and share the budget.
    /// Parts lie in a folder of their own in it, which goes when the file is there.
    std::filesystem::path scratch_folder;
};
struct OutOfCoreStatistics {
    std::uint64_t voxel_count = 0, node_count = 0;
    std::uint64_t geometry_bytes = 0;            ///< Of the packed DAG.
    std::uint64_t attribute_bytes = 0;           ///< Of all that voxels and means carry.
    std::size_t part_count = 0;                  ///< Sub-cubes that triangles may meet, or that a solid fills.
    std::size_t kept_part_count = 0;             ///< Of these, finished before.
    std::uint64_t part_bytes = 0;                ///< Of all parts' files.
    std::uint32_t join_pass_count = 0;           ///< As join_parts() states it.
    std::vector<std::string> damaged_parts = {}; ///< Names of files that were there, of no use, and made again.
};

class OutOfCore {
public:
    /// Snaps the mesh and splits the cube: as parts that are there already did, if those fit the budget. The triangles
    /// must outlive this. Throws as voxelize() and split() do.
    template <typename Position>
    OutOfCore(std::span<const Position> positions_m, std::span<const uvec3> triangles, const OutOfCoreConfig& config,
              const Progress& progress);

    [[nodiscard]] std::size_t part_count() const { return parts_.count(); }
    [[nodiscard]] std::filesystem::path part_path(std::size_t part) const;
    [[nodiscard]] std::uint32_t part_level() const { return parts_.level; }
    /// Makes a part's file, unless it is there and whole. Parts are independent of each other. Throws IoError, InvalidInput
    /// where the budget does not suffice after all, and Cancelled.
    void make_part(std::size_t part, const Progress& progress) const;
    /// One that was made. Throws IoError.
    [[nodiscard]] PartFile part(std::size_t part, const Progress& progress) const {
        return {part_path(part), key_of(part), progress};
    }
    /// Makes the parts that are missing, joins them, writes the file, and removes the parts. After any error the finished
    /// ones stay, and the same call goes on from there. Throws IoError, also where another process finishes the same job;
    /// InvalidInput where the budget does not suffice; and Cancelled.
    OutOfCoreStatistics finish(const std::filesystem::path& path, Progress& progress);

private:
    [[nodiscard]] PartKey key_of(std::size_t part) const;
    [[nodiscard]] std::optional<PartFile> finished(std::size_t part, const Progress& progress) const;
    void draw_part(std::size_t part, const Progress& progress) const;
    /// Of voxels that this mesh, the part's own, sets; empty ones where none are asked for.
    [[nodiscard]] PartAttributes part_attributes(std::size_t part, const SnappedMesh& mesh, const LeafMasks& leaves,
                                                 const Progress& progress) const;
    void make_parts(std::vector<PartFile>& parts, Progress& progress);
    [[nodiscard]] PackedDag joined(const std::vector<PartFile>& parts, Progress& progress);
    void write(const std::vector<PartFile>& parts, const PackedDag& dag, const std::filesystem::path& path,
               Progress& progress);
    [[nodiscard]] std::string what_is_kept(std::size_t finished_count) const;

    OutOfCoreConfig config_;
    Cube cube_m_;
    SnappedMesh mesh_;
    SubVolumes parts_;
    std::vector<std::uint32_t> before_; ///< Of a solid: triangles that all rows of parts have before them.
    std::array<std::uint64_t, 2> job_;
    std::filesystem::path folder_;
    OutOfCoreStatistics statistics_;
};
extern template OutOfCore::OutOfCore(std::span<const vec3>, std::span<const uvec3>, const OutOfCoreConfig&,
                                     const Progress&);
extern template OutOfCore::OutOfCore(std::span<const dvec3>, std::span<const uvec3>, const OutOfCoreConfig&,
                                     const Progress&);
} // namespace tyndall::voxel_dag
