// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/given_materials.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/color_palette.hpp"
#include "voxel_dag/material_rows.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::voxel_dag {
static constexpr std::size_t normals_per_block = 1 << 14;
static constexpr double degree_steps = 1 << 20;

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

NormalErrors& NormalErrors::operator+=(const NormalErrors& other) {
    sum += other.sum;
    most_degrees = std::max(most_degrees, other.most_degrees);
    return *this;
}
double NormalErrors::mean_degrees(std::uint64_t voxel_count) const {
    return voxel_count == 0 ? 0.0 : static_cast<double>(sum) / degree_steps / static_cast<double>(voxel_count);
}

static AttributeColumn shorter_normals(const AttributeColumn& normals, std::uint32_t bits, NormalErrors& errors,
                                       const Progress& progress) {
    AttributeColumn codes(normals.size());
    errors = parallel_sum(
        normals.size(), normals_per_block, NormalErrors{}, progress, [&](std::size_t begin, std::size_t end) {
            NormalErrors part;
            NormalErrors one;
            for (std::size_t i = begin; i < end; ++i) {
                if (i > begin && normals[i] == normals[i - 1]) {
                    codes[i] = codes[i - 1];
                } else {
                    const dvec3 given = octahedral::decode(normals[i], octahedral::most_bits);
                    codes[i] = octahedral::encode(given, bits);
                    const dvec3 kept = octahedral::decode(codes[i], bits);
                    one.most_degrees = std::atan2(glm::length(glm::cross(given, kept)), glm::dot(given, kept)) * 180.0 /
                                       std::numbers::pi;
                    one.sum = static_cast<std::uint64_t>(std::llround(one.most_degrees * degree_steps));
                }
                part += one;
            }
            return part;
        });
    return codes;
}

AttributeLayout layout_of(const VoxelAttributes& attributes, const AttributeConfig& config) {
    AttributeLayout layout{.has_colors = !attributes.colors.empty(),
                           .normal_bits = attributes.normals.empty() ? 0 : config.normal_bits,
                           .channels = {}};
    for (const VoxelChannel& channel : attributes.channels)
        layout.channels.push_back(channel.name);
    return layout;
}

AttributeLayout layout_of(const Surface& surface, const AttributeConfig& config) {
    AttributeLayout layout{.has_colors = surface.has_colors(),
                           .normal_bits = surface.normals == SurfaceNormals::None ? 0 : config.normal_bits,
                           .channels = {}};
    for (const SurfaceChannel& channel : surface.channels)
        layout.channels.push_back(channel.name);
    return layout;
}

/// What is given, what is made of it, and two arrays of numbers, of one of which the stored ones take the place.
static void require_room(const VoxelAttributes& attributes, const AttributeLayout& layout,
                         const AttributeConfig& config) {
    const std::uint64_t voxel_count =
        std::max({attributes.colors.size(), attributes.normals.size(),
                  attributes.channels.empty() ? std::size_t{0} : attributes.channels.front().values.size()});
    const std::uint64_t given =
        4 * std::uint64_t{layout.has_colors} + 4 * std::uint64_t{layout.normal_bits > 0} + layout.channels.size();
    const bool is_shortened = layout.normal_bits > 0 && layout.normal_bits < octahedral::most_bits;
    const std::uint64_t bytes =
        voxel_count * (given + 4 * std::uint64_t{is_shortened} + 4 * layout.channels.size() + 8);
    require(bytes <= config.memory_budget_bytes, "attributes: those of ", voxel_count, " voxels take about ",
            bytes >> 20, " MiB while they are put in order, and the budget is ", config.memory_budget_bytes >> 20,
            " MiB: allow more, choose a smaller resolution, or make the file part by part (voxelize_to_file)");
}

GivenMaterials given_materials(const VoxelAttributes& attributes, const AttributeConfig& config,
                               const Progress& progress) {
    GivenMaterials given{.layout = layout_of(attributes, config), .table = {}, .indices = {}, .normals = {}};
    require_room(attributes, given.layout, config);
    std::vector<AttributeColumn> made; // what is not as it was given
    made.reserve(1 + attributes.channels.size());
    std::vector<std::span<const std::uint32_t>> columns;
    if (!attributes.colors.empty())
        columns.emplace_back(attributes.colors);
    if (!attributes.normals.empty()) {
        if (config.normal_bits < octahedral::most_bits)
            columns.emplace_back(
                made.emplace_back(shorter_normals(attributes.normals, config.normal_bits, given.normals, progress)));
        else
            columns.emplace_back(attributes.normals);
    }
    for (const VoxelChannel& channel : attributes.channels)
        columns.emplace_back(made.emplace_back(channel.values.begin(), channel.values.end()));
    JointMaterials joint = join(columns, progress);
    given.table = {.columns = std::move(joint.columns), .counts = {}};
    given.indices = std::move(joint.indices);
    given.table.counts.resize(given.table.columns.front().size());
    for (const std::uint32_t index : given.indices)
        ++given.table.counts[index];
    return given;
}

/// From red in the lowest bits to red in the highest, and back.
static std::uint32_t with_ends_exchanged(std::uint32_t color) {
    return (color & 0xff) << 16 | (color & 0xff00) | (color >> 16 & 0xff);
}
/// Of each material, by the palette that all together have.
static AttributeColumn fewer_colors(const CountedMaterials& given, const AttributeConfig& config, KeptMaterials& kept,
                                    const Progress& progress) {
    using namespace color_palette;
    const AttributeColumn& of_material = given.columns.front();
    CountedColors different; // materials are in the order of their colours, red last: sorted once more
    for (std::size_t i = 0; i < of_material.size(); ++i)
        if (i == 0 || of_material[i] != of_material[i - 1])
            different.colors.push_back(with_ends_exchanged(of_material[i]));
    std::ranges::sort(different.colors);
    const auto index_of = [&](std::uint32_t color) {
        return static_cast<std::size_t>(std::ranges::lower_bound(different.colors, with_ends_exchanged(color)) -
                                        different.colors.begin());
    };
    require(different.colors.size() * bytes_per_color <= config.memory_budget_bytes, "attributes: a palette of ",
            different.colors.size(), " different colors takes about ", different.colors.size() * bytes_per_color >> 20,
            " MiB, and the budget is ", config.memory_budget_bytes >> 20, " MiB: allow more, or keep all colors");
    different.counts.resize(different.colors.size());
    for (std::size_t i = 0; i < of_material.size(); ++i)
        different.counts[index_of(of_material[i])] += given.counts[i];
    const std::vector<PackedColor> originals = different.colors;
    const Result palette = config.color_count > 0
                               ? counted_of_size(std::move(different), config.color_count, progress)
                               : counted_within(std::move(different), config.most_color_difference, progress);
    kept.mean_cie94 = palette.statistics.mean_difference;
    kept.most_cie94 = palette.statistics.most_difference;
    AttributeColumn colors(of_material.size());
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const auto at = std::ranges::lower_bound(originals, with_ends_exchanged(of_material[i])) - originals.begin();
        colors[i] = with_ends_exchanged(palette.colors[palette.indices[static_cast<std::size_t>(at)]]);
    }
    return colors;
}

KeptMaterials kept_materials(const CountedMaterials& given, const AttributeLayout& layout,
                             const AttributeConfig& config, const Progress& progress) {
    KeptMaterials kept{.columns = given.columns, .number_of = {}};
    kept.number_of.resize(given.counts.size());
    if (!layout.has_colors || !config.has_palette() || given.counts.empty()) {
        for (std::size_t i = 0; i < kept.number_of.size(); ++i)
            kept.number_of[i] = static_cast<std::uint32_t>(i);
        return kept;
    }
    kept.columns.front() = fewer_colors(given, config, kept, progress);
    MaterialRows rows(kept.columns.size(), config.memory_budget_bytes);
    rows.add({.columns = kept.columns, .counts = given.counts}, progress);
    CountedMaterials different = rows.take(progress);
    kept.number_of = RowFinder(different).numbers_of(kept.columns);
    kept.columns = std::move(different.columns);
    return kept;
}

void put_mean(const VoxelSample& mean, const AttributeLayout& layout, std::span<std::uint32_t> to) {
    std::size_t column = 0;
    if (layout.has_colors)
        to[column++] = mean.color;
    if (layout.normal_bits > 0)
        to[column++] = octahedral::encode(dvec3(mean.normal), layout.mean_normal_bits());
    for (std::size_t i = 0; i < layout.channels.size(); ++i)
        to[column++] = mean.channels[i];
}

SampleSum given_sum(const VoxelAttributes& attributes, std::uint64_t first_voxel, std::uint64_t voxel_count) {
    SampleSum sum;
    VoxelSample sample;
    for (std::uint64_t voxel = first_voxel; voxel < first_voxel + voxel_count; ++voxel) {
        if (!attributes.colors.empty())
            sample.color = attributes.colors[voxel];
        if (!attributes.normals.empty() &&
            (voxel == first_voxel || attributes.normals[voxel] != attributes.normals[voxel - 1]))
            sample.normal = vec3(octahedral::decode(attributes.normals[voxel], octahedral::most_bits));
        for (std::size_t i = 0; i < attributes.channels.size(); ++i)
            sample.channels[i] = attributes.channels[i].values[voxel];
        sum.add(sample);
    }
    return sum;
}
} // namespace tyndall::voxel_dag
