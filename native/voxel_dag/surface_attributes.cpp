// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/surface_attributes.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "image/srgb.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/surface_values.hpp"
#include "voxel_dag/tile_triangles.hpp"
#include <algorithm>
#include <bit>
#include <cmath>
#include <tbb/enumerable_thread_specific.h>
#include <utility>

namespace tyndall::voxel_dag {
namespace {
/// sRGB's byte of linear values from 0 to whole_value.
const std::array<std::uint8_t, 1 << 16>& bytes_of_linear() {
    static const auto table = [] {
        std::array<std::uint8_t, 1 << 16> bytes{};
        for (std::size_t value = 0; value < bytes.size(); ++value)
            bytes[value] = static_cast<std::uint8_t>(
                std::lround(255.0f * srgb_from_linear(static_cast<float>(value) / whole_value)));
        return bytes;
    }();
    return table;
}

/// Sums of the normals that lean to the lower and to the upper side of each axis.
using Sides = std::array<FourSums, 6>;

/// Of the six sides, the sum that reaches farthest along its own axis; no direction where all parts are lines.
dvec3 largest_side(const Sides& sides) {
    std::size_t largest = 0;
    for (std::size_t side = 1; side < sides.size(); ++side)
        if (std::abs(sides[side][side / 2]) > std::abs(sides[largest][largest / 2]))
            largest = side;
    const FourSums& sum = sides[largest];
    return {static_cast<double>(sum[0]), static_cast<double>(sum[1]), static_cast<double>(sum[2])};
}

/// Of a picture, per step of a voxel in the direction that minifies it most.
float texels_per_voxel(const SampledTriangle& triangle, std::span<const vec2, 3> uvs, const vec2& size) {
    vec3 along_u(0.0f), along_v(0.0f);
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto& per_step = triangle.shares.per_step;
        const vec3 gradient(per_step[0][corner], per_step[1][corner], per_step[2][corner]);
        along_u += gradient * (uvs[corner].x * size.x);
        along_v += gradient * (uvs[corner].y * size.y);
    }
    const float uu = glm::dot(along_u, along_u), vv = glm::dot(along_v, along_v), uv = glm::dot(along_u, along_v);
    return std::sqrt(0.5f * (uu + vv + std::sqrt((uu - vv) * (uu - vv) + 4 * uv * uv)));
}

/// Bricks of `leaves` from `first` to `end`, and the number of the first voxel there.
struct BrickRange {
    std::size_t first, end;
    std::uint64_t first_voxel;
};

/// The first voxel of a mask.
[[noreturn]] void refuse_voxel(std::uint64_t brick, std::uint64_t mask) {
    const Voxel voxel = voxel_at(brick << 3 * leaf_level | static_cast<std::uint64_t>(std::countr_zero(mask)));
    refuse("voxel (", voxel[0], ", ", voxel[1], ", ", voxel[2],
           ") is set, but by no triangle of the mesh: it has no attributes");
}

/// Sums of one tile after the other.
class TileSums {
public:
    TileSums(const SnappedMesh& mesh, VoxelizeRule rule, const LeafMasks& leaves, const SurfaceValues& values)
        : mesh_(mesh), rule_(rule), leaves_(leaves), values_(values) {}

    /// The attributes of a tile's bricks; returns how many voxels they have.
    std::uint64_t take(std::uint64_t tile, std::span<const std::uint64_t> entries, const BrickRange& bricks,
                       VoxelAttributes& to) {
        number_voxels(bricks);
        sums_.assign(voxel_count_ * fours().count, FourSums{});
        triangles_.lay(mesh_, rule_, tile, entries);
        for_each_triangle([&](std::size_t triangle, const SampledTriangle& sampled) { add(triangle, sampled); });
        require_weights(bricks);
        if (!to.colors.empty())
            write_colors(std::span(to.colors).subspan(bricks.first_voxel, voxel_count_));
        if (fours().channels != 0)
            write_channels(bricks.first_voxel, to.channels);
        if (fours().normals != 0)
            write_normals(bricks.first_voxel, to);
        return voxel_count_;
    }

private:
    [[nodiscard]] const SurfaceFours& fours() const { return values_.fours(); }
    [[nodiscard]] const FourSums& sum(std::size_t slot, std::size_t four) const {
        return sums_[slot * fours().count + four];
    }

    void number_voxels(const BrickRange& bricks) {
        slots_.masks.fill(0);
        voxel_count_ = 0;
        for (std::size_t brick = bricks.first; brick < bricks.end; ++brick) {
            const std::size_t in_tile = leaves_.codes[brick] % tile_bricks;
            slots_.masks[in_tile] = leaves_.masks[brick];
            slots_.first[in_tile] = static_cast<std::uint32_t>(voxel_count_);
            voxel_count_ += static_cast<std::uint64_t>(std::popcount(leaves_.masks[brick]));
        }
    }

    /// use(triangle, as it is sampled) while runs_ has the voxels that it sets.
    template <typename Use>
    void for_each_triangle(const Use& use) {
        const TileFrame& frame = triangles_.frame();
        constexpr std::size_t ahead = 4;
        for (std::size_t index = 0; index < triangles_.near_count(); ++index) {
            if (index + ahead < triangles_.near_count())
                values_.prefetch(triangles_.near_triangles()[index + ahead]);
            list_runs(triangles_.near_lines()[index / block_lanes], index % block_lanes, frame.axes, runs_);
            const std::size_t triangle = triangles_.near_triangles()[index];
            if (runs_.count != 0)
                use(triangle, sampled(mesh_.triangle(triangle), frame));
        }
        for (const auto& [triangle, corners] : triangles_.far()) {
            list_far(corners);
            if (runs_.count != 0)
                use(triangle, sampled(corners, frame));
        }
    }
    void list_far(const SnappedTriangle& corners) {
        WidePlane plane;
        switch (lay_lines(corners, triangles_.frame(), far_lines_, 0, plane)) {
        case Meets::No:
            runs_.count = 0;
            break;
        case Meets::Lines:
            list_runs(far_lines_, 0, triangles_.frame().axes, runs_);
            break;
        case Meets::LinesAndWidePlane:
            list_runs(far_lines_, plane, triangles_.frame().axes, runs_);
            break;
        }
    }
    /// use() while samples_ has those of the triangle that runs_ is of, part by part.
    template <typename Use>
    void for_samples(const SampledTriangle& triangle, const Use& use) {
        for (std::size_t run = 0; run < runs_.count;) {
            run = take_samples(triangle, runs_, run, triangles_.frame().axes, slots_, samples_);
            use();
        }
    }

    void add(std::size_t triangle, const SampledTriangle& sampled) {
        values_.corners(triangle, sampled.normal, corners_);
        const SurfaceMaterial* const material = values_.material(triangle);
        const bool has_picture = material != nullptr && material->texture != nullptr;
        const bool has_channel_pictures =
            material != nullptr &&
            std::ranges::any_of(material->channel_textures, [](const auto& t) { return bool(t); });
        for_samples(sampled, [&] {
            for (std::size_t four = 0; four < fours().count; ++four)
                if (!(four == 0 && has_picture) && !(four != 0 && four == fours().channels && has_channel_pictures))
                    add_samples(samples_, corners_[four], fours().count, sums_.data() + four);
            if (has_picture)
                add_colors(*material->texture, sampled, values_.uvs(triangle));
            if (has_channel_pictures)
                add_channels(*material, sampled, values_.uvs(triangle));
        });
    }
    /// What is between the corners of a triangle.
    [[nodiscard]] static vec4 between(const SurfaceValues::Corners& corners, const Four& share) {
        vec4 value(0.0f);
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (int lane = 0; lane < 4; ++lane)
                value[lane] += share[corner] * corners[corner][static_cast<std::size_t>(lane)];
        return value;
    }
    [[nodiscard]] static vec2 between(std::span<const vec2, 3> uvs, const Four& share) {
        return share[0] * uvs[0] + share[1] * uvs[1] + share[2] * uvs[2];
    }
    void add_colors(const FilteredTexture& texture, const SampledTriangle& triangle, std::span<const vec2, 3> uvs) {
        const float texels = texels_per_voxel(triangle, uvs, texture.size());
        for (std::size_t sample = 0; sample < samples_.count; ++sample) {
            const Four& share = samples_.shares[sample];
            const float weight = samples_.weights[sample];
            const vec3 color = glm::clamp(texture.lookup(between(uvs, share), texels), 0.0f, 1.0f);
            const vec4 factor = values_.has_vertex_colors() ? between(corners_[0], share) : vec4(whole_value);
            FourSums& sum = sums_[samples_.slots[sample] * fours().count];
            for (int channel = 0; channel < 3; ++channel)
                sum[static_cast<std::size_t>(channel)] += std::lround(color[channel] * factor[channel] * weight);
            sum[3] += std::lround(weight);
        }
    }
    void add_channels(const SurfaceMaterial& material, const SampledTriangle& triangle, std::span<const vec2, 3> uvs) {
        std::array<float, VoxelAttributes::most_channels> texels{};
        for (std::size_t channel = 0; channel < texels.size(); ++channel)
            if (const auto& texture = material.channel_textures[channel])
                texels[channel] = texels_per_voxel(triangle, uvs, texture->size());
        for (std::size_t sample = 0; sample < samples_.count; ++sample) {
            const Four& share = samples_.shares[sample];
            vec4 value = between(corners_[fours().channels], share);
            for (std::size_t channel = 0; channel < texels.size(); ++channel)
                if (const auto& texture = material.channel_textures[channel])
                    value[static_cast<int>(channel)] *=
                        glm::clamp(texture->lookup(between(uvs, share), texels[channel]).x, 0.0f, 1.0f);
            FourSums& sum = sums_[samples_.slots[sample] * fours().count + fours().channels];
            for (std::size_t channel = 0; channel < texels.size(); ++channel)
                sum[channel] += std::lround(value[static_cast<int>(channel)] * samples_.weights[sample]);
        }
    }

    void require_weights(const BrickRange& bricks) const {
        std::size_t slot = 0;
        for (std::size_t brick = bricks.first; brick < bricks.end; ++brick)
            for (std::uint64_t left = leaves_.masks[brick]; left != 0; left &= left - 1)
                if (sum(slot++, 0)[3] == 0)
                    refuse_voxel(leaves_.codes[brick], left);
    }

    void take_four(std::size_t four) {
        means_.resize(voxel_count_);
        take_means(sums_.data() + four, sums_.data(), fours().count, voxel_count_, means_.data());
    }
    void write_colors(std::span<std::uint32_t> to) {
        const auto& byte_of_linear = bytes_of_linear();
        take_four(0);
        for (std::size_t slot = 0; slot < voxel_count_; ++slot) {
            const auto byte = [&](std::size_t channel) {
                return std::uint32_t{byte_of_linear[static_cast<std::uint16_t>(means_[slot][channel])]};
            };
            to[slot] = byte(0) | byte(1) << 8 | byte(2) << 16;
        }
    }
    void write_channels(std::uint64_t first_voxel, std::vector<VoxelChannel>& to) {
        take_four(fours().channels);
        for (std::size_t channel = 0; channel < to.size(); ++channel) {
            std::uint8_t* const values = to[channel].values.data() + first_voxel;
            for (std::size_t slot = 0; slot < voxel_count_; ++slot) // 65535 is 255 times 257
                values[slot] = static_cast<std::uint8_t>((means_[slot][channel] + 128) / 257);
        }
    }

    void write_normals(std::uint64_t first_voxel, VoxelAttributes& to) {
        cancelled_.clear();
        for (std::size_t slot = 0; slot < voxel_count_; ++slot) {
            const FourSums& total = sum(slot, fours().normals);
            const dvec3 normal(static_cast<double>(total[0]), static_cast<double>(total[1]),
                               static_cast<double>(total[2]));
            const double least = 0.25 * double{whole_normal} * static_cast<double>(sum(slot, 0)[3]);
            if (glm::dot(normal, normal) >= least * least)
                to.normals[first_voxel + slot] = octahedral::encode_rounded(normal);
            else
                cancelled_.push_back(static_cast<std::uint32_t>(slot));
        }
        if (!cancelled_.empty())
            write_cancelled(first_voxel, to);
    }
    /// A second pass, for the tiles that need it.
    void write_cancelled(std::uint64_t first_voxel, VoxelAttributes& to) {
        constexpr std::uint32_t is_fine = ~std::uint32_t{0};
        place_in_cancelled_.assign(voxel_count_, is_fine);
        for (std::size_t place = 0; place < cancelled_.size(); ++place)
            place_in_cancelled_[cancelled_[place]] = static_cast<std::uint32_t>(place);
        sides_.assign(cancelled_.size(), Sides{});
        for_each_triangle([&](std::size_t triangle, const SampledTriangle& sampled) {
            values_.corners(triangle, sampled.normal, corners_);
            for_samples(sampled, [&] {
                for (std::size_t sample = 0; sample < samples_.count; ++sample)
                    if (const std::uint32_t place = place_in_cancelled_[samples_.slots[sample]]; place != is_fine)
                        add_to_sides(sample, sampled.normal, sides_[place]);
            });
        });
        for (std::size_t place = 0; place < cancelled_.size(); ++place) {
            const dvec3 normal = largest_side(sides_[place]);
            to.normals[first_voxel + cancelled_[place]] =
                octahedral::encode_rounded(normal == dvec3(0) ? dvec3(0, 0, 1) : normal);
        }
    }
    void add_to_sides(std::size_t sample, const vec3& normal_of_triangle, Sides& sides) const {
        const SurfaceValues::Corners& normals = corners_[fours().normals];
        vec3 normal(0.0f);
        for (std::size_t corner = 0; corner < 3; ++corner)
            normal +=
                samples_.shares[sample][corner] * vec3(normals[corner][0], normals[corner][1], normals[corner][2]);
        if (normal == vec3(0.0f))
            normal = whole_normal * normal_of_triangle;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            FourSums& side = sides[2 * axis + (normal[static_cast<int>(axis)] > 0.0f ? 1 : 0)];
            for (std::size_t component = 0; component < 3; ++component)
                side[component] += std::lround(normal[static_cast<int>(component)] * samples_.weights[sample]);
        }
    }

    const SnappedMesh& mesh_;
    VoxelizeRule rule_;
    const LeafMasks& leaves_;
    const SurfaceValues& values_;
    TileTriangles triangles_;
    TileLines far_lines_;
    TriangleRuns runs_;
    TileSlots slots_;
    SurfaceSamples samples_;
    std::array<SurfaceValues::Corners, SurfaceFours::most> corners_;
    std::uint64_t voxel_count_ = 0;
    std::vector<FourSums> sums_;
    std::vector<FourMeans> means_;
    std::vector<std::uint32_t> cancelled_;          ///< Slots whose normals cancel.
    std::vector<std::uint32_t> place_in_cancelled_; ///< Of each slot.
    std::vector<Sides> sides_;                      ///< Of each cancelled slot.
};

void require_room(std::uint64_t voxel_count, std::uint64_t brick_count, const Surface& surface,
                  const VoxelizeConfig& config) {
    const std::uint64_t bytes_per_voxel =
        (surface.has_colors() ? 4 : 0) + (surface.normals == SurfaceNormals::None ? 0 : 4) + surface.channels.size();
    const std::uint64_t bytes = voxel_count * bytes_per_voxel + 16 * brick_count;
    require(bytes <= config.memory_budget_bytes, "voxels and their attributes are ", bytes >> 20,
            " MiB, beyond the budget of ", config.memory_budget_bytes >> 20, " MiB: ", voxel_count, " voxels of ",
            bytes_per_voxel, " bytes each, and ", 16 * brick_count >> 20, " MiB that say where they are");
}

/// Bricks of each part of the cube, which all bins have as many of.
std::vector<BrickRange> bricks_of_parts(const LeafMasks& leaves, std::size_t part_count, const Progress& progress) {
    const std::uint32_t tiles_level = leaves.level - std::min(leaves.level, tile_level);
    const std::uint64_t bricks_per_part = (std::uint64_t{tile_bricks} << 3 * tiles_level) / part_count;
    std::vector<BrickRange> ranges(part_count);
    parallel_for(
        part_count, progress,
        [&](std::size_t part) {
            const auto first_from = [&](std::uint64_t code) {
                return static_cast<std::size_t>(std::ranges::lower_bound(leaves.codes, code) - leaves.codes.begin());
            };
            BrickRange& range = ranges[part];
            range = {first_from(part * bricks_per_part), first_from((part + 1) * bricks_per_part), 0};
            for (std::size_t brick = range.first; brick < range.end; ++brick)
                range.first_voxel += static_cast<std::uint64_t>(std::popcount(leaves.masks[brick]));
        },
        16);
    std::uint64_t before = 0;
    for (BrickRange& range : ranges)
        before += std::exchange(range.first_voxel, before);
    return ranges;
}

} // namespace

VoxelAttributes surface_attributes(const SnappedMesh& mesh, const VoxelizeConfig& config, const LeafMasks& leaves,
                                   const Surface& surface, const Progress& progress) {
    const SurfaceValues values(surface, mesh.positions.size(), mesh.triangles, progress);
    const std::uint64_t voxel_count = leaves.voxel_count();
    require_room(voxel_count, leaves.codes.size(), surface, config);
    require(mesh.level == leaves.level, "the voxels have ", leaves.resolution(), " a side, the configuration ",
            config.resolution);
    const TileBins bins = bin_triangles(mesh, progress);
    const std::vector<BrickRange> ranges = bricks_of_parts(leaves, bins.part_count(), progress);

    VoxelAttributes attributes;
    if (surface.has_colors())
        attributes.colors = large_vector<std::uint32_t>(voxel_count);
    if (surface.normals != SurfaceNormals::None)
        attributes.normals = large_vector<std::uint32_t>(voxel_count);
    for (const SurfaceChannel& channel : surface.channels)
        attributes.channels.push_back({channel.name, large_vector<std::uint8_t>(voxel_count)});

    tbb::enumerable_thread_specific<std::unique_ptr<TileSums>> places(
        [&] { return std::make_unique<TileSums>(mesh, config.rule, leaves, values); });
    parallel_for(
        bins.part_count(), progress,
        [&](std::size_t part) {
            BrickRange left = ranges[part];
            for_each_tile(bins.part(part), [&](std::uint64_t tile, std::span<const std::uint64_t> entries) {
                progress.poll();
                BrickRange bricks = left;
                for (bricks.end = bricks.first;
                     bricks.end < left.end && leaves.codes[bricks.end] / tile_bricks == tile;)
                    ++bricks.end;
                left.first_voxel += places.local()->take(tile, entries, bricks, attributes);
                left.first = bricks.end;
            });
            if (left.first < left.end)
                refuse_voxel(leaves.codes[left.first], leaves.masks[left.first]);
        },
        1);
    return attributes;
}
VoxelAttributes surface_attributes(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                   const VoxelizeConfig& config, const LeafMasks& leaves, const Surface& surface,
                                   const Progress& progress) {
    return surface_attributes(snap(positions_m, triangles, config, progress), config, leaves, surface, progress);
}
VoxelAttributes surface_attributes(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                                   const VoxelizeConfig& config, const LeafMasks& leaves, const Surface& surface,
                                   const Progress& progress) {
    return surface_attributes(snap(positions_m, triangles, config, progress), config, leaves, surface, progress);
}
} // namespace tyndall::voxel_dag
