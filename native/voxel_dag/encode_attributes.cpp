// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/encode_attributes.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/color_palette.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include "voxel_dag/stored_walk.hpp"
#include <numbers>

namespace tyndall::voxel_dag {
namespace {
using Column = std::vector<std::uint32_t>;
constexpr std::size_t block = 1 << 14;

void require_usable(const VoxelAttributes& attributes, std::uint64_t voxel_count) {
    const auto check = [&](std::size_t count, const std::string& what) {
        require(count == 0 || count == voxel_count, "attributes: ", count, " ", what, " for ", voxel_count, " voxels");
    };
    check(attributes.colors.size(), "colors");
    check(attributes.normals.size(), "normals");
    require(attributes.channels.size() <= VoxelAttributes::most_channels, "attributes: ", attributes.channels.size(),
            " channels; up to ", VoxelAttributes::most_channels, " are possible");
    for (std::size_t i = 0; i < attributes.channels.size(); ++i) {
        const std::string& name = attributes.channels[i].name;
        require(!name.empty(), "attributes: channel ", i, " has no name");
        require(attributes.channels[i].values.size() == voxel_count,
                "attributes: ", attributes.channels[i].values.size(), " values of channel '", name, "' for ",
                voxel_count, " voxels");
        for (std::size_t other = 0; other < i; ++other)
            require(attributes.channels[other].name != name, "attributes: two channels are '", name, "'");
    }
}
void require_usable(const AttributeConfig& config) {
    require(config.color_count == 0 || config.most_color_difference == 0.0,
            "attributes: color_count and most_color_difference are two ways to choose colors: give one of them");
    require(octahedral::least_bits <= config.normal_bits && config.normal_bits <= octahedral::most_bits,
            "normal_bits is ", config.normal_bits, ", outside [", octahedral::least_bits, ", ", octahedral::most_bits,
            "]");
}

/// From red in the lowest bits to red in the highest, and back.
std::uint32_t with_ends_exchanged(std::uint32_t color) {
    return (color & 0xff) << 16 | (color & 0xff00) | (color >> 16 & 0xff);
}

Column fewer_colors(const Column& colors, const AttributeConfig& config, AttributeErrors& errors,
                    const Progress& progress) {
    std::vector<PackedColor> entries(colors.size());
    std::ranges::transform(colors, entries.begin(), with_ends_exchanged);
    color_palette::Result palette = config.color_count > 0
                                        ? color_palette::of_size(entries, config.color_count, progress)
                                        : color_palette::within(entries, config.most_color_difference, progress);
    errors.mean_cie94 = palette.statistics.mean_difference;
    errors.most_cie94 = palette.statistics.most_difference;
    for (std::uint32_t& index : palette.indices)
        index = with_ends_exchanged(palette.colors[index]);
    return std::move(palette.indices);
}

/// Degrees between normals, of many.
struct Angles {
    double sum = 0.0, most = 0.0;
    Angles& operator+=(const Angles& other) {
        sum += other.sum, most = std::max(most, other.most);
        return *this;
    }
};
Column shorter_normals(const Column& normals, std::uint32_t bits, AttributeErrors& errors, const Progress& progress) {
    Column codes(normals.size());
    const Angles angles =
        parallel_sum(normals.size(), block, Angles{}, progress, [&](std::size_t begin, std::size_t end) {
            Angles part;
            double degrees = 0.0;
            for (std::size_t i = begin; i < end; ++i) {
                if (i > begin && normals[i] == normals[i - 1]) {
                    codes[i] = codes[i - 1];
                } else {
                    const dvec3 given = octahedral::decode(normals[i], octahedral::most_bits);
                    codes[i] = octahedral::encode(given, bits);
                    const dvec3 kept = octahedral::decode(codes[i], bits);
                    degrees = std::atan2(glm::length(glm::cross(given, kept)), glm::dot(given, kept)) * 180.0 /
                              std::numbers::pi;
                }
                part += {degrees, degrees};
            }
            return part;
        });
    errors.mean_degrees = normals.empty() ? 0.0 : angles.sum / static_cast<double>(normals.size());
    errors.most_degrees = angles.most;
    return codes;
}

std::vector<std::span<const std::uint32_t>> spans_of(const std::vector<Column>& columns) {
    return {columns.begin(), columns.end()};
}

/// Of nodes of 16^3, from the voxels; above, from those below.
struct Averaging {
    using Sum = SampleSum;
    static constexpr std::uint32_t least_level = least_mean_level;

    Sum at_end(const StoredPlace& place, std::uint64_t first_voxel, std::uint64_t voxel_count) const {
        SampleSum sum;
        VoxelSample sample;
        for (std::uint64_t voxel = first_voxel; voxel < first_voxel + voxel_count; ++voxel) {
            if (!given.colors.empty())
                sample.color = given.colors[voxel];
            if (!given.normals.empty() && (voxel == first_voxel || given.normals[voxel] != given.normals[voxel - 1]))
                sample.normal = vec3(octahedral::decode(given.normals[voxel], octahedral::most_bits));
            for (std::size_t i = 0; i < given.channels.size(); ++i)
                sample.channels[i] = given.channels[i].values[voxel];
            sum.add(sample);
        }
        keep(place.number, sum);
        return sum;
    }
    Sum joined(const StoredPlace& place, const std::array<Sum, 8>& children) const {
        SampleSum sum;
        for (const Sum& child : children)
            sum += child;
        keep(place.number, sum);
        return sum;
    }
    void keep(std::uint64_t number, const SampleSum& sum) const {
        const VoxelSample mean = sum.mean();
        std::size_t column = 0;
        if (!given.colors.empty())
            columns[column++][number] = mean.color;
        if (!given.normals.empty())
            columns[column++][number] = octahedral::encode(dvec3(mean.normal), normal_bits);
        for (std::size_t i = 0; i < given.channels.size(); ++i)
            columns[column++][number] = mean.channels[i];
    }

    const VoxelAttributes& given;
    std::uint32_t normal_bits;
    std::span<Column> columns; ///< By number.
};
} // namespace

std::shared_ptr<const DagAttributes> encode_attributes(const PackedDag& dag, const VoxelAttributes& attributes,
                                                       const AttributeConfig& config, const Progress& progress) {
    require_usable(attributes, dag.voxel_count);
    require_usable(config);
    AttributeParts parts;
    parts.order = stored_order_of(dag, progress);
    {
        std::vector<Column> columns;
        if (!attributes.colors.empty()) {
            parts.layout.has_colors = true;
            const bool is_lossless = config.color_count == 0 && config.most_color_difference == 0.0;
            columns.push_back(is_lossless ? attributes.colors
                                          : fewer_colors(attributes.colors, config, parts.errors, progress));
        }
        if (!attributes.normals.empty()) {
            parts.layout.normal_bits = config.normal_bits;
            columns.push_back(config.normal_bits == octahedral::most_bits
                                  ? attributes.normals
                                  : shorter_normals(attributes.normals, config.normal_bits, parts.errors, progress));
        }
        for (const VoxelChannel& channel : attributes.channels) {
            parts.layout.channels.push_back(channel.name);
            columns.emplace_back(channel.values.begin(), channel.values.end());
        }
        JointMaterials joint = join(spans_of(columns), progress);
        columns.clear();
        Column stored(joint.indices.size());
        to_stored_order(dag, parts.order, joint.indices, stored, progress);
        parts.voxels = {.materials = encode_columns(joint), .indices = run_array::encode(stored, {}, progress)};
    }
    if (config.has_means && parts.order.node_count > 0) {
        std::vector<Column> columns(parts.layout.column_count(), Column(parts.order.node_count));
        const Averaging averaging{attributes, parts.layout.mean_normal_bits(), columns};
        StoredWalk(dag, parts.order, averaging, progress).run();
        const JointMaterials joint = join(spans_of(columns), progress);
        parts.means = {.materials = encode_columns(joint), .indices = run_array::encode(joint.indices, {}, progress)};
    }
    return std::make_shared<const DagAttributes>(std::move(parts), dag);
}
} // namespace tyndall::voxel_dag
