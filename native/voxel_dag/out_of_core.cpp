// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/out_of_core.hpp"
#include "core/partial_file.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/checked_file.hpp"
#include "voxel_dag/fingerprint.hpp"
#include "voxel_dag/join_attributes.hpp"
#include "voxel_dag/join_parts.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/solid_fill.hpp"
#include "voxel_dag/solid_parts.hpp"
#include "voxel_dag/tile.hpp"
#include <cerrno>
#include <charconv>
#include <fcntl.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

namespace tyndall::voxel_dag {
namespace {
/// Of a part's voxels, tables and DAG, per brick of 4^3: measured on scans and architecture, rounded up.
constexpr std::uint64_t dag_bytes_per_brick = 96;
/// How the work is shared, roughly.
constexpr float parts_end = 0.75f, join_end = 0.82f, pack_end = 0.88f;

/// The same while attributes are made, before the DAG.
std::uint64_t attribute_bytes_per_brick(const OutOfCoreConfig& config) {
    const Surface& surface = config.surface;
    if (surface.is_empty())
        return 0;
    const std::uint64_t has_colors = surface.has_colors(), has_normals = surface.normals != SurfaceNormals::None,
                        channels = surface.channels.size();
    constexpr std::uint64_t numbers = 8, normal_table = 16;
    const std::uint64_t per_voxel = 4 * has_colors + (8 + normal_table) * has_normals + 5 * channels + numbers;
    const std::uint64_t voxels = config.voxels.rule == VoxelizeRule::Thin ? 16 : 24;
    constexpr std::uint64_t brick = 16, sums_of_nodes = 16;
    return brick + sums_of_nodes + voxels * per_voxel;
}

/// What two processes must not do at once in one folder. Goes with the process, however that ends.
class FolderLock {
public:
    explicit FolderLock(const std::filesystem::path& folder)
        : file_(open((folder / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
        if (file_ < 0)
            refuse_file(folder, std::generic_category().message(errno) + ": see that the folder can be written to");
        if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
            close(file_);
            refuse_file(folder, "another process is at work on the same voxel DAG: wait for it, or choose another "
                                "scratch folder");
        }
    }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock() { close(file_); }

private:
    int file_;
};

void add_to(Fingerprint& fingerprint, const Texture& texture) {
    fingerprint.add_word(texture.width);
    fingerprint.add_word(texture.height);
    fingerprint.add(std::as_bytes(std::span(texture.bytes)));
    fingerprint.add(std::as_bytes(std::span(texture.floats)));
    fingerprint.add_word(texture.is_srgb);
    fingerprint.add_word(texture.has_alpha);
    fingerprint.add_word(static_cast<std::uint64_t>(texture.extension));
    fingerprint.add_word(static_cast<std::uint64_t>(texture.interpolation));
}
void add_to(Fingerprint& fingerprint, const Surface& surface) {
    fingerprint.add(std::as_bytes(surface.colors));
    for (const SurfaceMaterial& material : surface.materials) {
        fingerprint.add(bytes_of(material.color));
        if (material.texture != nullptr)
            add_to(fingerprint, material.texture->texture());
        for (std::size_t channel = 0; channel < surface.channels.size(); ++channel) {
            fingerprint.add(bytes_of(material.channels[channel]));
            if (material.channel_textures[channel] != nullptr)
                add_to(fingerprint, material.channel_textures[channel]->texture());
        }
    }
    fingerprint.add_word(surface.has_material_colors);
    fingerprint.add(std::as_bytes(surface.material_of_triangle));
    fingerprint.add(std::as_bytes(surface.corner_uvs));
    fingerprint.add_word(static_cast<std::uint64_t>(surface.normals));
    fingerprint.add(std::as_bytes(surface.vertex_normals));
    for (const SurfaceChannel& channel : surface.channels) {
        fingerprint.add(std::as_bytes(std::span(channel.name)));
        fingerprint.add(std::as_bytes(channel.values));
    }
}

/// What decides the content of the parts.
Fingerprint fingerprint_of(const SnappedMesh& mesh, const OutOfCoreConfig& config) {
    Fingerprint fingerprint;
    fingerprint.add(std::as_bytes(std::span(mesh.positions)));
    fingerprint.add(std::as_bytes(mesh.triangles));
    fingerprint.add_word(mesh.level);
    fingerprint.add_word(static_cast<std::uint64_t>(config.voxels.rule));
    fingerprint.add_word(static_cast<std::uint64_t>(config.symmetry));
    if (config.is_solid)
        fingerprint.add(std::as_bytes(std::span("solid", 5)));
    if (!config.surface.is_empty()) {
        add_to(fingerprint, config.surface);
        fingerprint.add_word(config.attributes.normal_bits); // palettes are made when parts are joined
    }
    return fingerprint;
}

/// What the budget leaves each process beside the mesh.
std::uint64_t bytes_beside(const SnappedMesh& mesh, const OutOfCoreConfig& config) {
    require(config.worker_count > 0, "0 processes make no parts");
    const std::uint64_t budget_bytes = config.voxels.memory_budget_bytes / config.worker_count;
    const std::uint64_t mesh_bytes = sizeof(Steps) * mesh.positions.size() + 8 * mesh.triangles.size();
    require(mesh_bytes < budget_bytes, "the mesh alone takes ", mesh_bytes >> 20, " MiB, and the budget is ",
            budget_bytes >> 20, " MiB for each process");
    return budget_bytes - mesh_bytes;
}
/// Bricks of a part's surface that there is room for; a solid's inside may take as much again.
std::uint64_t most_bricks(std::uint64_t bytes, const OutOfCoreConfig& config) {
    return bytes / (config.is_solid ? 2 : 1) / std::max(dag_bytes_per_brick, attribute_bytes_per_brick(config));
}
/// Of parts whose bricks fit that if all are there, as in a solid they are.
std::uint32_t most_solid_level(std::uint64_t bytes) {
    constexpr std::uint64_t bytes_per_brick = 48; // codes and masks, while they are gathered
    std::uint32_t level = tile_level;
    for (; level < most_level; ++level) {
        const std::uint64_t bricks = std::uint64_t{1} << 3 * (level + 1 - leaf_level);
        if (bricks * bytes_per_brick + estimated_build_bytes(bricks, level + 1) > bytes / 2)
            break;
    }
    return level;
}

/// Of the parts in a folder: with another budget the same job goes on with them. most_level where there are none.
std::uint32_t level_of_parts(const std::filesystem::path& folder) {
    std::uint32_t level = most_level;
    std::error_code ignored; // no folder, no parts
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
        const std::string name = entry.path().filename().string();
        std::uint32_t found = 0;
        if (std::from_chars(name.data(), name.data() + name.size(), found).ec == std::errc())
            level = std::min(level, found);
    }
    return level;
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        refuse_file(folder, error.message());
}
} // namespace

template <typename Position>
OutOfCore::OutOfCore(std::span<const Position> positions_m, std::span<const uvec3> triangles,
                     const OutOfCoreConfig& config, const Progress& progress)
    : config_(config), mesh_(snap(positions_m, triangles, config.voxels, progress)) {
    if (!config.surface.is_empty()) {
        require_usable(config.surface, positions_m.size(), triangles.size());
        require_usable(config.attributes);
    }
    config_.attributes.memory_budget_bytes = config.voxels.memory_budget_bytes;
    cube_m_ = config.voxels.bounds_m ? *config.voxels.bounds_m : cube_around(positions_m, triangles);
    const Fingerprint fingerprint = fingerprint_of(mesh_, config);
    job_ = fingerprint.value();
    folder_ = config.scratch_folder / ("tyndall-" + fingerprint.text());
    const std::uint64_t bytes = bytes_beside(mesh_, config);
    std::uint32_t most_part_level = level_of_parts(folder_);
    if (config.is_solid) {
        require(config.surface.is_empty(), "voxels inside of a solid have no surface: they carry nothing");
        require_closed(mesh_, positions_m, progress);
        most_part_level = std::min(most_part_level, most_solid_level(bytes));
    }
    parts_ = split(mesh_, config.voxels.rule, most_bricks(bytes, config), most_part_level, progress);
    if (config.is_solid) {
        before_ = triangles_before(mesh_);
        parts_ = with_inside(mesh_, parts_, before_, progress);
    }
    statistics_.part_count = parts_.count();
}
template OutOfCore::OutOfCore(std::span<const vec3>, std::span<const uvec3>, const OutOfCoreConfig&, const Progress&);
template OutOfCore::OutOfCore(std::span<const dvec3>, std::span<const uvec3>, const OutOfCoreConfig&, const Progress&);

std::filesystem::path OutOfCore::part_path(std::size_t part) const {
    require(part < parts_.count(), "there is no part ", part, " of ", parts_.count());
    return folder_ / (std::to_string(parts_.level) + "-" + std::to_string(parts_.codes[part]) + ".part");
}

PartKey OutOfCore::key_of(std::size_t part) const {
    return {.job = job_, .level = parts_.level, .code = parts_.codes[part]};
}

std::optional<PartFile> OutOfCore::finished(std::size_t part, const Progress& progress) const {
    if (!std::filesystem::exists(part_path(part)))
        return std::nullopt;
    try {
        return this->part(part, progress);
    } catch (const IoError&) { // damaged, or of another job
        return std::nullopt;
    }
}

void OutOfCore::draw_part(std::size_t part, const Progress& progress) const {
    if (config_.is_solid && parts_.first[part] == parts_.first[part + 1]) {
        const std::uint64_t voxel_count = std::uint64_t{1} << 3 * parts_.level;
        write_part(full_dag(parts_.level, config_.symmetry), {}, key_of(part), voxel_count, part_path(part), progress);
        return;
    }
    const SubMesh sub = sub_mesh(mesh_, parts_, part);
    LeafMasks leaves = voxelize(sub.mesh, config_.voxels, progress).leaves;
    if (config_.is_solid)
        leaves = filled(crossings_of_part(mesh_, parts_, before_, part, progress), leaves, config_.voxels, progress);
    const PartAttributes attributes = part_attributes(part, sub.mesh, leaves, progress);
    const std::uint64_t voxel_count = leaves.voxel_count();
    Dag dag = build_dag(leaves, {.memory_budget_bytes = config_.voxels.memory_budget_bytes}, progress);
    leaves = {};
    if (config_.symmetry != Symmetry::None)
        dag = merge_symmetric(
            dag, {.symmetry = config_.symmetry, .memory_budget_bytes = config_.voxels.memory_budget_bytes}, progress);
    write_part(dag, attributes, key_of(part), voxel_count, part_path(part), progress);
}

PartAttributes OutOfCore::part_attributes(std::size_t part, const SnappedMesh& mesh, const LeafMasks& leaves,
                                          const Progress& progress) const {
    if (config_.surface.is_empty() || leaves.codes.empty())
        return {};
    const auto triangles =
        std::span(parts_.triangles).subspan(parts_.first[part], parts_.first[part + 1] - parts_.first[part]);
    const SubSurface sub = sub_surface(config_.surface, mesh_.triangles, triangles);
    const VoxelAttributes attributes = surface_attributes(mesh, config_.voxels, leaves, sub.surface, progress);
    return voxel_dag::part_attributes(leaves, attributes, config_.attributes, progress);
}

void OutOfCore::make_part(std::size_t part, const Progress& progress) const {
    make_folder(folder_);
    if (!finished(part, progress))
        draw_part(part, progress);
}

void OutOfCore::make_parts(std::vector<PartFile>& parts, Progress& progress) {
    for (std::size_t part = 0; part < parts_.count(); ++part) {
        progress.set_message("Voxels: part " + std::to_string(part + 1) + " of " + std::to_string(parts_.count()));
        std::optional<PartFile> file = finished(part, progress);
        if (file)
            ++statistics_.kept_part_count;
        else {
            if (std::filesystem::exists(part_path(part)))
                statistics_.damaged_parts.push_back(part_path(part).filename().string());
            draw_part(part, progress);
            file = this->part(part, progress);
        }
        statistics_.part_bytes += file->byte_count();
        statistics_.voxel_count += file->voxel_count();
        parts.push_back(std::move(*file));
        progress.advance_to(parts_end * static_cast<float>(part + 1) / static_cast<float>(parts_.count()));
    }
}

PackedDag OutOfCore::joined(const std::vector<PartFile>& parts, Progress& progress) {
    progress.set_message("Joining " + std::to_string(parts.size()) + " parts");
    JoinResult joined =
        join_parts(parts,
                   {.level = mesh_.level,
                    .part_level = parts_.level,
                    .symmetry = config_.symmetry,
                    .memory_budget_bytes = config_.voxels.memory_budget_bytes},
                   progress, [&](double share) {
                       progress.advance_to(parts_end + (join_end - parts_end) * static_cast<float>(share));
                   });
    statistics_.join_pass_count = joined.statistics.most_passes;
    const std::uint64_t pack_bytes = estimated_pack_bytes(joined.dag),
                        budget_bytes = config_.voxels.memory_budget_bytes;
    require(pack_bytes <= budget_bytes, "voxel DAG: packing ", joined.dag.node_count(), " nodes takes about ",
            pack_bytes >> 20, " MiB, and the budget is ", budget_bytes >> 20, " MiB: allow more, or a resolution of ",
            config_.voxels.resolution / 2, ", which takes a quarter to a half");
    progress.set_message("Packing " + std::to_string(joined.dag.node_count()) + " nodes");
    PackedDag packed = pack_dag(joined.dag, progress);
    statistics_.node_count = packed.node_count;
    statistics_.geometry_bytes = packed.byte_count();
    return packed;
}

void OutOfCore::write(const std::vector<PartFile>& parts, const PackedDag& dag, const std::filesystem::path& path,
                      Progress& progress) {
    const auto say = [&] { progress.set_message("Writing " + path.filename().string()); };
    if (config_.surface.is_empty() || dag.voxel_count == 0) {
        say();
        return write_dag(dag, cube_m_, path, progress);
    }
    progress.set_message("Attributes of " + std::to_string(dag.voxel_count) + " voxels");
    const StreamedAttributes attributes =
        join_attributes(parts, dag,
                        {.layout = layout_of(config_.surface, config_.attributes),
                         .attributes = config_.attributes,
                         .part_level = parts_.level,
                         .folder = folder_},
                        progress, [&](double share) {
                            progress.advance_to(pack_end + (1.0f - pack_end) * 0.9f * static_cast<float>(share));
                        });
    statistics_.attribute_bytes = attributes.byte_count();
    say();
    write_dag(dag, cube_m_, attributes, path, progress);
}

std::string OutOfCore::what_is_kept(std::size_t finished_count) const {
    return " (" + std::to_string(finished_count) + " of " + std::to_string(parts_.count()) + " parts are kept in " +
           folder_.string() + ": the same call goes on from there)";
}

OutOfCoreStatistics OutOfCore::finish(const std::filesystem::path& path, Progress& progress) {
    make_folder(folder_);
    const FolderLock lock(folder_);
    statistics_ = {.part_count = parts_.count()}; // a call before may have failed
    std::vector<PartFile> parts;
    try {
        make_parts(parts, progress);
        const PackedDag dag = joined(parts, progress);
        progress.advance_to(pack_end);
        write(parts, dag, path, progress);
    } catch (const IoError& error) {
        throw IoError(error.what() + what_is_kept(parts.size()));
    } catch (const InvalidInput& error) {
        throw InvalidInput(error.what() + what_is_kept(parts.size()));
    }
    std::error_code ignored; // the file is there: what cannot be removed does it no harm
    std::filesystem::remove_all(folder_, ignored);
    progress.advance_to(1.0f);
    return statistics_;
}
} // namespace tyndall::voxel_dag
