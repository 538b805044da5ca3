// SPDX-License-Identifier: GPL-3.0-or-later
// The tables of attributes of Kol, dissertation, TU Delft 2018, section 2.5, remade: bytes, differences, similarity of
// pictures. Voxels, rule (thin) and formulas: support/table_models.hpp; write_voxel_tables.py makes docs/voxel-tables.md
// of what this measures, and says what each counter is.
//   table_2_1/MODEL         the DAG, with and without offsets; arrays of 24-bit colours, plain, indexed, with palettes; ours
//   table_2_2/MODEL/BITS    colours of a palette of 2^BITS: what is lost of them, and their bytes
//   normals/MODEL/BITS      the same of octahedral normals
//   color_picture/MODEL/BITS, normal_picture/MODEL/BITS: how like the picture of all is that of these
//   table_2_3/MODEL         the DAG with offsets, step by step, and ours
//   table_2_4/MODEL         12-bit colours in published structures and in ours
//   joint/MODEL             12-bit colours; with 10-bit normals; and with 8 bits of reflectance as well, see reflectance()
// "leaf" counts voxels alone, "all" every node of the tree.
#include "support/table_models.hpp"
#include "voxel_dag/color_palette.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/offset_counts.hpp"
#include "voxel_dag/palette_array.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
using Values = std::vector<std::uint32_t>;
const Progress progress;

void count(benchmark::State& state, const std::string& name, std::uint64_t value) {
    state.counters[name] = static_cast<double>(value);
}
voxel_dag::VoxelAttributes colors_of(const Model& model) {
    return {.colors = model.attributes.colors, .normals = {}, .channels = {}};
}
voxel_dag::VoxelAttributes normals_of(const Model& model) {
    return {.colors = {}, .normals = model.attributes.normals, .channels = {}};
}
/// Bytes of what is kept, and of the geometry.
void count_ours(benchmark::State& state, const Model& model, const AttributeParts& parts) {
    count(state, "ours_geometry", model.dag.byte_count());
    count(state, "ours_counts", parts.order.byte_count());
    count(state, "ours_voxels", parts.voxels.materials.size() + parts.voxels.indices.size());
    count(state, "ours_means", parts.means.materials.size() + parts.means.indices.size());
}
/// A table of the different values, and indices of it.
std::uint64_t indexed_bytes(const Values& values, std::uint32_t value_bits, std::size_t& different) {
    different = material_indices_of(values, progress).materials.size();
    return (bits_for(different) * values.size() + value_bits * different + 7) / 8;
}

void table_2_1(benchmark::State& state, Model& model) {
    for (auto _ : state) {
        std::uint64_t shared = 0;
        for (const DagLevel& level : model.plain.levels)
            shared += level.node_count();
        count(state, "dag_nodes", shared + model.plain.leaves.size());
        count(state, "dag", offset_dag_bytes(model.plain, {.has_offsets = false}));
        count(state, "with_offsets", offset_dag_bytes(model.plain, {}));
        for (const auto& [name, values] :
             {std::pair{"leaf", &model.attributes.colors}, std::pair{"all", &model.tree.colors}}) {
            std::size_t different = 0;
            const std::string of = name;
            count(state, of + "_entries", values->size());
            count(state, of + "_plain", 3 * values->size());
            count(state, of + "_indexed", indexed_bytes(*values, 24, different));
            count(state, of + "_different", different);
            count(state, of + "_palettes", encode_palettes(*values, {}, progress).size());
        }
        count_ours(state, model, encode_attributes(model.dag, colors_of(model), {}, progress)->parts());
    }
}

/// Of red, green and blue: the mean and the largest absolute error.
void count_byte_errors(benchmark::State& state, const Values& given, const Values& kept) {
    for (std::uint32_t shift = 0; shift < 24; shift += 8) {
        std::uint64_t sum = 0, most = 0;
        for (std::size_t i = 0; i < given.size(); ++i) {
            const auto byte = [&](std::uint32_t color) { return static_cast<int>(color >> shift & 255); };
            const auto error = static_cast<std::uint64_t>(std::abs(byte(given[i]) - byte(kept[i])));
            sum += error, most = std::max(most, error);
        }
        const std::string channel(1, "bgr"[shift / 8]);
        state.counters["mean_" + channel] = static_cast<double>(sum) / static_cast<double>(given.size());
        count(state, "most_" + channel, most);
    }
}
/// Of colours alone or of normals alone, against all of them.
void count_similarity(benchmark::State& state, Model& model, const voxel_dag::VoxelAttributes& attributes,
                      const AttributeConfig& config, const std::string& name) {
    const auto picture = [&](const AttributeConfig& kept, const std::string& as) {
        return picture_of({model.dag, Cube{}, encode_attributes(model.dag, attributes, kept, progress)},
                          model.source->view, as);
    };
    std::optional<Picture>& all = attributes.colors.empty() ? model.all_normals : model.all_colors;
    if (!all)
        all = picture({}, model.name() + (attributes.colors.empty() ? "_normals" : "_colors"));
    for (auto _ : state)
        state.counters["ssim"] = structural_similarity(all->luma, picture(config, name).luma, progress);
}

void table_2_2(benchmark::State& state, Model& model, std::uint32_t bits) {
    for (auto _ : state) {
        const auto kept = encode_attributes(model.dag, colors_of(model), {.color_count = 1u << bits}, progress);
        count_ours(state, model, kept->parts());
        state.counters["mean_cie94"] = kept->parts().errors.mean_cie94;
        state.counters["most_cie94"] = kept->parts().errors.most_cie94;
        for (const auto& [name, values] :
             {std::pair{"leaf", &model.attributes.colors}, std::pair{"all", &model.tree.colors}}) {
            const Values given = with_ends_exchanged(*values);
            const color_palette::Result few = color_palette::of_size(given, 1u << bits, progress);
            const std::string of = name;
            count(state, of + "_plain", 3 * values->size());
            count(state, of + "_palettes", encode_palettes(few.indices, {}, progress).size() + 3 * few.colors.size());
            count(state, of + "_different", few.colors.size());
            if (values != &model.attributes.colors)
                continue;
            Values found(given.size());
            std::ranges::transform(few.indices, found.begin(), [&](std::uint32_t index) { return few.colors[index]; });
            count_byte_errors(state, given, found);
        }
    }
}

/// Codes of fewer bits, of codes of 32.
Values shorter(const Values& normals, std::uint32_t bits) {
    Values codes(normals.size());
    for (std::size_t i = 0; i < codes.size(); ++i)
        codes[i] = i > 0 && normals[i] == normals[i - 1]
                       ? codes[i - 1]
                       : octahedral::encode(octahedral::decode(normals[i], octahedral::most_bits), bits);
    return codes;
}
void normals(benchmark::State& state, Model& model, std::uint32_t bits) {
    for (auto _ : state) {
        const auto kept = encode_attributes(model.dag, normals_of(model), {.normal_bits = bits}, progress);
        count_ours(state, model, kept->parts());
        state.counters["mean_degrees"] = kept->parts().errors.mean_degrees;
        state.counters["most_degrees"] = kept->parts().errors.most_degrees;
        for (const auto& [name, values] :
             {std::pair{"leaf", &model.attributes.normals}, std::pair{"all", &model.tree.normals}}) {
            const std::string of = name;
            count(state, of + "_plain", 4 * values->size());
            count(
                state, of + "_palettes",
                encode_palettes(bits == octahedral::most_bits ? *values : shorter(*values, bits), {}, progress).size());
        }
    }
}

void table_2_3(benchmark::State& state, Model& model) {
    for (auto _ : state) {
        const auto step = [&](const char* name, const OffsetLayout& layout) {
            count(state, name, offset_dag_bytes(model.plain, layout));
        };
        step("dag", {.has_offsets = false});
        step("uncompressed", {});
        step("implicit_offset", {.has_implicit_first = true});
        step("offset_compression", {.has_offset_bytes = true});
        step("pointer_compression", {.has_pointer_bytes = true});
        step("byte_masks", {.has_byte_masks = true});
        step("pointer_entropy", {.has_pointers_by_use = true});
        step("combined", OffsetLayout::combined());
        count(state, "ours_geometry", model.dag.byte_count());
        count(state, "ours_counts", stored_order_of(model.dag, progress).byte_count());
        const PackedDag unturned = pack_dag(model.plain, progress);
        count(state, "unturned_geometry", unturned.byte_count());
        count(state, "unturned_counts", stored_order_of(unturned, progress).byte_count());
    }
}

void table_2_4(benchmark::State& state, Model& model) {
    for (auto _ : state) {
        const color_palette::Result few =
            color_palette::of_size(with_ends_exchanged(model.tree.colors), 1u << 12, progress);
        const std::uint64_t nodes = few.indices.size(), inner = model.tree.inner_count, voxels = nodes - inner;
        count(state, "nodes", nodes);
        count(state, "voxels", voxels);
        count(state, "svo", (inner * (8 + 32 + 12) + voxels * 12) / 8);
        count(state, "psvo", (inner * (8 + 12) + voxels * 12) / 8);
        const ValuedDag naive = valued_dag(model.leaves, few.indices);
        count(state, "cdag_nodes", naive.inner_count + naive.leaf_count);
        count(state, "cdag", (naive.inner_count * (32 + 12) + naive.reference_count * 32 + naive.leaf_count * 12) / 8);
        count(state, "kol_geometry", offset_dag_bytes(model.plain, OffsetLayout::combined()));
        count(state, "kol_attributes", encode_palettes(few.indices, {}, progress).size() + 3 * few.colors.size());
        count_ours(state, model,
                   encode_attributes(model.dag, colors_of(model), {.color_count = 1u << 12}, progress)->parts());
    }
}

/// Of four materials, light and dark squares with and without veins: 10, 26, 51, 128.
std::vector<std::uint8_t> reflectance(const Model& model) {
    constexpr std::array<std::uint8_t, 4> of_material{10, 26, 51, 128};
    std::vector<std::uint8_t> values;
    for (const Voxel& voxel : support::listed(model.leaves)) {
        const dvec3 at = (dvec3(voxel[0], voxel[1], voxel[2]) + 0.5) / static_cast<double>(model.leaves.resolution());
        const bool is_dark = check_at(at) < 1.0, has_vein = vein_at(at) >= 0.5;
        values.push_back(of_material[2 * std::size_t{is_dark} + std::size_t{has_vein}]);
    }
    return values;
}
void joint(benchmark::State& state, Model& model) {
    for (auto _ : state) {
        voxel_dag::VoxelAttributes attributes = colors_of(model);
        const AttributeConfig config{.color_count = 1u << 12, .normal_bits = 10};
        const auto measure = [&](const std::string& name) {
            const auto kept = encode_attributes(model.dag, attributes, config, progress);
            count(state, name + "_materials", kept->parts().voxels.materials.size());
            count(state, name + "_bytes", model.dag.byte_count() + kept->parts().byte_count());
        };
        measure("color");
        attributes.normals = model.attributes.normals;
        measure("normal");
        attributes.channels = {{.name = "reflectance", .values = reflectance(model)}};
        measure("reflectance");
    }
}

void add(const std::string& name, std::size_t model, const std::function<void(benchmark::State&, Model&)>& run) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [=](benchmark::State& state) {
                                     Model& found = model_at(model);
                                     if (found.leaves.codes.empty())
                                         state.SkipWithError("the model is not there: set TYNDALL_SHARED_DATA");
                                     else
                                         run(state, found);
                                 })
        ->Iterations(1)
        ->Repetitions(1) // counts and pictures come out alike
        ->Unit(benchmark::kMillisecond);
}
const bool are_registered = [] {
    for (std::size_t model = 0; model < model_count; ++model) {
        const ModelSource& source = model_sources()[model];
        const auto named = [&](const char* table) { return std::string(table) + "/" + source.name; };
        add(named("table_2_1"), model, table_2_1);
        const bool is_mesh = source.file == nullptr;
        for (const std::uint32_t bits : is_mesh ? std::vector{14u, 12u, 10u} : std::vector{3u, 2u}) {
            const std::string of_bits = std::string("/") + std::to_string(bits); // GCC 12 warns of a shorter one
            add(named("table_2_2") + of_bits, model,
                [=](benchmark::State& state, Model& of) { table_2_2(state, of, bits); });
            add(named("color_picture") + of_bits, model, [=](benchmark::State& state, Model& of) {
                count_similarity(state, of, colors_of(of), {.color_count = 1u << bits},
                                 of.name() + "_colors_" + std::to_string(bits));
            });
        }
        for (const std::uint32_t bits : is_mesh ? std::vector{32u, 16u, 12u, 10u} : std::vector<std::uint32_t>{}) {
            const std::string of_bits = std::string("/") + std::to_string(bits); // GCC 12 warns of a shorter one
            add(named("normals") + of_bits, model,
                [=](benchmark::State& state, Model& of) { normals(state, of, bits); });
            add(named("normal_picture") + of_bits, model, [=](benchmark::State& state, Model& of) {
                count_similarity(state, of, normals_of(of), {.normal_bits = bits},
                                 of.name() + "_normals_" + std::to_string(bits));
            });
        }
        add(named("table_2_3"), model, table_2_3);
        add(named("table_2_4"), model, table_2_4);
        if (is_mesh)
            add(named("joint"), model, joint);
    }
    return true;
}();
} // namespace
} // namespace tyndall::bench
