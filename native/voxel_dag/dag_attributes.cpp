// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_attributes.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/byte_sections.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <atomic>

namespace tyndall::voxel_dag {
std::uint64_t AttributeParts::byte_count() const {
    return order.byte_count() + voxels.materials.size() + voxels.indices.size() + means.materials.size() +
           means.indices.size();
}

static constexpr std::string_view names_section = "names";
std::vector<std::uint8_t> encode_names(const AttributeParts& parts) {
    SectionWriter writer;
    writer.number(std::uint32_t{parts.layout.has_colors});
    writer.number(parts.layout.normal_bits);
    for (const double error :
         {parts.errors.mean_cie94, parts.errors.most_cie94, parts.errors.mean_degrees, parts.errors.most_degrees})
        writer.number(std::bit_cast<std::uint64_t>(error));
    writer.number(parts.order.root_bit);
    writer.number(parts.order.node_count);
    writer.number(static_cast<std::uint32_t>(parts.layout.channels.size()));
    for (const std::string& name : parts.layout.channels) {
        writer.number(static_cast<std::uint32_t>(name.size()));
        writer.section({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()});
    }
    return writer.finish();
}
void decode_names(std::span<const std::uint8_t> bytes, AttributeParts& parts) {
    SectionReader reader(bytes, "attributes");
    parts.layout.has_colors = reader.number<std::uint32_t>(names_section) != 0;
    parts.layout.normal_bits = reader.number<std::uint32_t>(names_section);
    for (double* const error :
         {&parts.errors.mean_cie94, &parts.errors.most_cie94, &parts.errors.mean_degrees, &parts.errors.most_degrees})
        *error = std::bit_cast<double>(reader.number<std::uint64_t>(names_section));
    parts.order.root_bit = reader.number<std::uint64_t>(names_section);
    parts.order.node_count = reader.number<std::uint64_t>(names_section);
    for (auto left = reader.number<std::uint32_t>(names_section); left > 0; --left) {
        const auto name = reader.take(reader.number<std::uint32_t>(names_section), names_section);
        parts.layout.channels.emplace_back(name.begin(), name.end());
    }
    reader.finish();
}

static void require_usable(const AttributeLayout& layout) {
    require(layout.column_count() > 0, "attributes: there are none");
    require(layout.normal_bits == 0 ||
                (octahedral::least_bits <= layout.normal_bits && layout.normal_bits <= octahedral::most_bits),
            "attributes: normals of ", layout.normal_bits, " bits");
    require(layout.channels.size() <= VoxelAttributes::most_channels, "attributes: ", layout.channels.size(),
            " channels; up to ", VoxelAttributes::most_channels, " are possible");
}

DagAttributes::DagAttributes(AttributeParts parts, const PackedDag& dag) : parts_(std::move(parts)) {
    require_usable(parts_.layout);
    require_usable(parts_.order, dag);
    voxels_ = opened(parts_.voxels, dag.voxel_count, parts_.layout.normal_bits);
    if (!parts_.means.indices.empty())
        means_ = opened(parts_.means, parts_.order.node_count, parts_.layout.mean_normal_bits());
}

DagAttributes::Materials DagAttributes::opened(const MaterialBytes& bytes, std::uint64_t entry_count,
                                               std::uint32_t normal_bits) const {
    Materials materials{
        .table = MaterialTable(bytes.materials), .indices = RunArray(bytes.indices), .normal_bits = normal_bits};
    require(materials.table.attribute_count() == parts_.layout.column_count(), "attributes: materials of ",
            materials.table.attribute_count(), " values instead of ", parts_.layout.column_count());
    require(materials.indices.size() == entry_count, "attributes: ", materials.indices.size(), " entries instead of ",
            entry_count);
    require(entry_count == 0 || materials.indices.largest() < materials.table.material_count(),
            "attributes: an entry has material ", materials.indices.largest(), " of ",
            materials.table.material_count());
    return materials;
}

VoxelSample DagAttributes::sample(const Materials& materials, std::uint32_t material) const {
    require(material < materials.table.material_count(), "attributes: material ", material, " of ",
            materials.table.material_count());
    VoxelSample sample;
    std::uint32_t column = 0;
    if (parts_.layout.has_colors)
        sample.color = materials.table.at(material, column++);
    if (parts_.layout.normal_bits > 0)
        sample.normal = vec3(octahedral::decode(materials.table.at(material, column++), materials.normal_bits));
    for (std::size_t channel = 0; channel < parts_.layout.channels.size(); ++channel)
        sample.channels[channel] = static_cast<std::uint8_t>(materials.table.at(material, column++));
    return sample;
}

std::optional<VoxelSample> DagAttributes::sample_at(const PackedDag& dag, const Voxel& voxel,
                                                    std::uint32_t level) const {
    const std::optional<StoredCube> cube = find_stored(dag, parts_.order, voxel, level);
    if (!cube)
        return std::nullopt;
    if (cube->entry_count == 0) {
        require(cube->number < means_->indices.size(), "attributes: the counts lead to node ", cube->number, " of ",
                means_->indices.size());
        return sample(*means_, means_->indices.at(cube->number));
    }
    require(cube->first_entry + cube->entry_count <= voxels_->indices.size(), "attributes: the counts lead to entry ",
            cube->first_entry, " of ", voxels_->indices.size());
    if (cube->entry_count == 1)
        return sample(*voxels_, voxels_->indices.at(cube->first_entry));
    std::array<std::uint32_t, 512> materials; // of 8^3 voxels
    const std::span entries = std::span(materials).first(static_cast<std::size_t>(cube->entry_count));
    constexpr std::size_t most_singly = 32; // beyond, decoding a block up to there is faster
    if (entries.size() > most_singly)
        voxels_->indices.decode(cube->first_entry, entries);
    else
        for (std::size_t i = 0; i < entries.size(); ++i)
            entries[i] = voxels_->indices.at(cube->first_entry + i);
    SampleSum sum;
    VoxelSample one;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (i == 0 || entries[i] != entries[i - 1])
            one = sample(*voxels_, entries[i]);
        sum.add(one);
    }
    return sum.mean();
}

std::vector<bool> DagAttributes::materials_where(const std::function<bool(const VoxelSample&)>& is_wanted) const {
    std::vector<bool> found(voxels_->table.material_count());
    for (std::uint32_t material = 0; material < found.size(); ++material)
        found[material] = is_wanted(sample(*voxels_, material));
    return found;
}

std::optional<std::vector<std::uint64_t>> DagAttributes::entries_of(const std::vector<bool>& is_wanted,
                                                                    std::size_t most, const Progress& progress) const {
    std::vector<std::uint64_t> entries;
    if (std::ranges::find(is_wanted, true) == is_wanted.end())
        return entries;
    std::vector<std::uint32_t> materials(std::size_t{1} << 16);
    for (std::uint64_t begin = 0; begin < voxels_->indices.size(); begin += materials.size()) {
        progress.poll();
        const auto count =
            static_cast<std::size_t>(std::min<std::uint64_t>(materials.size(), voxels_->indices.size() - begin));
        voxels_->indices.decode(begin, std::span(materials).first(count));
        for (std::size_t i = 0; i < count; ++i)
            if (materials[i] < is_wanted.size() && is_wanted[materials[i]])
                entries.push_back(begin + i);
        if (entries.size() > most)
            return std::nullopt;
    }
    return entries;
}

template <class Value, class Pick>
static std::vector<Value> picked(const PackedDag& dag, const DagAttributes& attributes, std::span<const Voxel> voxels,
                                 std::uint32_t level, const Progress& progress, const Pick& pick) {
    require(level < least_mean_level || attributes.has_means(), "attributes: there are no means of ", 1u << level,
            "^3 voxels; level ", least_mean_level - 1, " is the largest");
    std::vector<Value> values(voxels.size());
    std::atomic<std::size_t> first_empty = voxels.size();
    parallel_for(voxels.size(), progress, [&](std::size_t i) {
        if (const std::optional<VoxelSample> sample = attributes.sample_at(dag, voxels[i], level)) {
            values[i] = pick(*sample);
            return;
        }
        for (std::size_t known = first_empty; i < known && !first_empty.compare_exchange_weak(known, i);) {
        }
    });
    if (const std::size_t i = first_empty; i < voxels.size())
        refuse("voxel ", i, " of those asked for, (", voxels[i][0], ", ", voxels[i][1], ", ", voxels[i][2],
               "), is not set");
    return values;
}

std::vector<ByteColor> colors_at(const PackedDag& dag, const DagAttributes& attributes, std::span<const Voxel> voxels,
                                 std::uint32_t level, const Progress& progress) {
    require(attributes.layout().has_colors, "the voxel DAG has no colors");
    return picked<ByteColor>(dag, attributes, voxels, level, progress,
                             [](const VoxelSample& sample) { return byte_color(sample.color); });
}
std::vector<vec3> normals_at(const PackedDag& dag, const DagAttributes& attributes, std::span<const Voxel> voxels,
                             std::uint32_t level, const Progress& progress) {
    require(attributes.layout().normal_bits > 0, "the voxel DAG has no normals");
    return picked<vec3>(dag, attributes, voxels, level, progress,
                        [](const VoxelSample& sample) { return sample.normal; });
}
std::vector<std::uint8_t> channel_at(const PackedDag& dag, const DagAttributes& attributes, const std::string& name,
                                     std::span<const Voxel> voxels, std::uint32_t level, const Progress& progress) {
    const std::vector<std::string>& names = attributes.layout().channels;
    const auto found = std::ranges::find(names, name);
    require(found != names.end(), "the voxel DAG has no channel '", name, "'");
    const auto channel = static_cast<std::size_t>(found - names.begin());
    return picked<std::uint8_t>(dag, attributes, voxels, level, progress,
                                [=](const VoxelSample& sample) { return sample.channels[channel]; });
}
} // namespace tyndall::voxel_dag
