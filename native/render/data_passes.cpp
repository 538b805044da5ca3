// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/data_passes.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "render/matte_id.hpp"
#include "scene/strands.hpp"
#include <algorithm>
#include <cmath>
#include <type_traits>

namespace tyndall::render {
static constexpr std::size_t pixels_per_block = 1 << 14;
static constexpr std::uint32_t ranks_per_plane = 2;

void DataPassConfig::add(std::string_view name) {
    const auto found = std::ranges::find(data_pass_names, name);
    if (found != data_pass_names.end()) {
        bits |= 1u << (found - data_pass_names.begin());
        return;
    }
    std::string names;
    for (const std::string_view known : data_pass_names)
        names += (names.empty() ? "" : ", ") + std::string(known);
    refuse("there is no data pass \"", name, "\"; there are: ", names);
}

void PathData::clear() {
    layers.clear();
    near_cover = 0.0f;
    has_surface = has_uv = false;
    aovs.clear();
    features = {};
    motion = vec4(0.0f);
}

/// Share of a surface that the mist leaves, as Cycles has it.
static float clearness(const Camera& camera, const vec3& position, const MistRange& mist) {
    const vec3 from_camera = position - camera.position();
    const float distance_m = camera.kind != CameraKind::Orthographic
                                 ? glm::length(from_camera)
                                 : std::abs(glm::dot(from_camera, camera.forward()));
    const float way = mist.depth_m > 0.0f ? std::clamp((distance_m - mist.start_m) / mist.depth_m, 0.0f, 1.0f) : 0.0f;
    return 1.0f - (mist.exponent == 1.0f ? way : std::pow(way, mist.exponent));
}

/// The active UV map at the hit; false where there is none.
static bool find_uv(const Scene& scene, const Hit& hit, vec2& uv) {
    if (const PlacedShape* const placed = scene.placed_shape(hit.instance)) {
        const Strands* const strands = scene.description().shapes[placed->shape_index]->strands();
        const std::optional<vec2> of_strand =
            strands != nullptr ? strands->active_uv(static_cast<std::uint32_t>(hit.cell), hit.barycentrics)
                               : std::nullopt;
        uv = of_strand.value_or(uv);
        return of_strand.has_value();
    }
    const SceneDescription& description = scene.description();
    const SharedMeshArrays& mesh = description.meshes[description.instances[hit.instance].mesh_index]->arrays();
    const SharedMeshArrays::UvMap* map = mesh.uv_map("");
    if (map == nullptr)
        return false;
    const vec2* corners = &map->corner_uvs[3 * std::size_t{hit.triangle}];
    const vec2 b = hit.barycentrics;
    uv = (1.0f - b.x - b.y) * corners[0] + b.x * corners[1] + b.y * corners[2];
    return true;
}

float share_going_on(const SurfaceClosures& closures, std::span<const Lobe> lobes, std::span<const Lobe> bent) {
    const float on = average(closures.transparent);
    float sum = on + average(closures.diffuse_albedo + closures.translucent + closures.mirrored);
    for (const Lobe& lobe : lobes)
        sum += lobe.sampling;
    for (const Lobe& lobe : bent)
        sum += average(lobe.a + lobe.weight);
    return sum > 0.0f ? on / sum : 0.0f;
}

void see_aovs(const Scene& scene, const AskingRay& asking, const ShadingPoint& point, const Hit& hit, float reached,
              std::span<const Aov> aovs, PathData& data) {
    data.aovs.resize(aovs.size());
    const std::vector<Material>& materials = scene.description().materials;
    const auto material_index =
        static_cast<std::uint32_t>(&scene.material(hit.instance, hit.triangle) - materials.data());
    AskingRay about = asking;
    for (std::size_t index = 0; index < aovs.size(); ++index)
        if (const auto found = aovs[index].program_of.find(material_index); found != aovs[index].program_of.end()) {
            about.material = &materials[found->second];
            data.aovs[index] += reached * vec4(scene.closures(about, point, hit).emission, 1.0f);
        }
}

void see_layer(const Scene& scene, const Camera& camera, const Hit& hit, const vec3& position, float cover,
               bool is_first, const DataPassConfig& config, PathData& data) {
    const SceneDescription& description = scene.description();
    const std::uint32_t name_index = description.name_index_of(hit.instance);
    const auto material_index =
        static_cast<std::uint32_t>(&scene.material(hit.instance, hit.triangle) - description.materials.data());
    if (cover > 0.0f) {
        data.layers.push_back({name_index, material_index, cover});
        data.near_cover += cover * clearness(camera, position, config.mist);
    }
    if (!is_first)
        return;
    data.has_surface = true;
    data.name_index = name_index;
    data.material_index = material_index;
    data.has_uv = find_uv(scene, hit, data.uv);
    if (config.neighbours)
        data.motion = motion_vector(scene, camera, hit, position, *config.neighbours);
}

/// What a name counts as.
static const std::string& alias_of(const std::unordered_map<std::string, std::string>& aliases,
                                   const std::string& name) {
    const auto found = aliases.find(name);
    return found == aliases.end() ? name : found->second;
}

DataSums::DataSums(std::size_t pixel_count, std::uint32_t pixel_samples, const Scene& scene,
                   const DataPassConfig& config)
    : pixel_count_(pixel_count), pixel_samples_(static_cast<float>(pixel_samples)), scene_(scene), config_(config),
      rank_count_((config.matte_ranks + 1) / ranks_per_plane * ranks_per_plane), sample_counts_(pixel_count) {
    require(1 <= config.matte_ranks && config.matte_ranks <= 16, "matte_ranks is ", config.matte_ranks,
            ", outside [1, 16]");
    const SceneDescription& description = scene.description();
    for (std::size_t kind = 0; kind < matte_kind_count; ++kind)
        if (config.has(static_cast<DataPass>(kind)))
            mattes_[kind].resize(pixel_count * rank_count_);
    if (config.has(DataPass::ObjectMattes))
        for (const std::string& name : description.object_names)
            ids_[0].push_back(matte_id(name));
    if (config.has(DataPass::MaterialMattes))
        for (const Material& material : description.materials)
            ids_[1].push_back(matte_id(alias_of(config.material_alias, material.name)));
    if (config.has(DataPass::AssetMattes))
        for (const std::string& name : description.object_names)
            ids_[2].push_back(matte_id(alias_of(config.asset_of, name)));
    if (config.has(DataPass::MaterialIndex))
        for (const Material& material : description.materials) {
            const auto found = config.material_index.find(material.name);
            material_indices_.push_back(found == config.material_index.end() ? 0.0f : found->second);
        }
    object_index_.resize(config.has(DataPass::ObjectIndex) ? pixel_count : 0);
    material_index_.resize(config.has(DataPass::MaterialIndex) ? pixel_count : 0);
    near_cover_.resize(config.has(DataPass::Mist) ? pixel_count : 0);
    uv_.resize(config.has(DataPass::Uv) ? pixel_count : 0);
    features_.resize(config.has_features() ? pixel_count : 0);
    motion_.resize(config.has(DataPass::Vector) ? pixel_count : 0, vec4(0.0f));
    surface_counts_.resize(motion_.size());
    if (config.neighbours)
        config.neighbours->require_fit(scene);
    for (const Aov& aov : config.aovs)
        for (const auto& [material, program] : aov.program_of)
            require(material < description.materials.size() && program < description.materials.size(), "AOV \"",
                    aov.name, "\" names material ", std::max(material, program), " of ", description.materials.size());
    aovs_.resize(pixel_count * config.aovs.size(), vec4(0.0f));
}

float DataSums::id_of(std::size_t kind, const PathData::Layer& layer) const {
    return ids_[kind]
               [kind == static_cast<std::size_t>(DataPass::MaterialMattes) ? layer.material_index : layer.name_index];
}

/// What finds no rank any more counts for the last, as in Cycles: shares add up to alpha.
void DataSums::add_matte(Rank* ranks, float id, float cover) const {
    Rank* const last = ranks + rank_count_ - 1;
    Rank* rank = ranks;
    while (rank != last && rank->id != 0.0f && rank->id != id)
        ++rank;
    if (rank->id == 0.0f)
        rank->id = id;
    rank->cover += cover;
}

void DataSums::add(std::size_t pixel, const PathData& data) {
    ++sample_counts_[pixel];
    for (std::size_t kind = 0; kind < matte_kind_count; ++kind)
        if (!mattes_[kind].empty())
            for (const PathData::Layer& layer : data.layers)
                add_matte(&mattes_[kind][pixel * rank_count_], id_of(kind, layer), layer.cover);
    if (!near_cover_.empty())
        near_cover_[pixel] += data.near_cover;
    for (std::size_t index = 0; index < data.aovs.size(); ++index)
        aovs_[pixel * config_.aovs.size() + index] += data.aovs[index];
    if (!features_.empty()) {
        features_[pixel].albedo += glm::min(data.features.albedo, Rgb(1.0f));
        features_[pixel].normal += data.features.normal;
        features_[pixel].depth_m += data.features.depth_m;
    }
    if (!data.has_surface)
        return;
    if (!motion_.empty()) {
        motion_[pixel] += data.motion;
        ++surface_counts_[pixel];
    }
    if (!uv_.empty() && data.has_uv)
        uv_[pixel] += vec3(data.uv, 1.0f);
}

void DataSums::set_indices(std::size_t pixel, const PathData& data) {
    if (!object_index_.empty()) {
        const std::vector<ObjectInfo>& infos = scene_.description().object_infos;
        object_index_[pixel] = infos.empty() ? 0.0f : infos[data.name_index].pass_index;
    }
    if (!material_index_.empty())
        material_index_[pixel] = material_indices_[data.material_index];
}

NamedPlane DataSums::matte_plane(std::size_t kind, std::uint32_t plane, const Progress& progress) const {
    NamedPlane result{.name = std::string(data_pass_names[kind]) + (plane < 10 ? "0" : "") + std::to_string(plane),
                      .channel_count = 2 * ranks_per_plane,
                      .values = std::vector<float>(pixel_count_ * 2 * ranks_per_plane)};
    parallel_for(
        pixel_count_, progress,
        [&](std::size_t pixel) {
            std::array<Rank, 16> ranks;
            std::copy_n(&mattes_[kind][pixel * rank_count_], rank_count_, ranks.begin());
            std::stable_sort(ranks.begin(), ranks.begin() + rank_count_,
                             [](const Rank& a, const Rank& b) { return a.cover > b.cover; });
            const float scale = sample_counts_[pixel] > 0 ? 1.0f / static_cast<float>(sample_counts_[pixel]) : 0.0f;
            float* to = &result.values[pixel * result.channel_count];
            for (std::uint32_t rank = ranks_per_plane * plane; rank < ranks_per_plane * (plane + 1); ++rank) {
                *to++ = ranks[rank].id;
                *to++ = ranks[rank].cover * scale;
            }
        },
        pixels_per_block);
    return result;
}

NamedPlane DataSums::aov_plane(std::size_t index, const Progress& progress) const {
    const Aov& aov = config_.aovs[index];
    NamedPlane result{.name = aov.name, .channel_count = aov.is_colour ? 4u : 1u, .values = {}};
    result.values.resize(pixel_count_ * result.channel_count);
    parallel_for(
        pixel_count_, progress,
        [&](std::size_t pixel) {
            const vec4& sum = aovs_[pixel * config_.aovs.size() + index];
            const auto count = static_cast<float>(std::max(sample_counts_[pixel], 1u));
            for (std::uint32_t channel = 0; channel < result.channel_count; ++channel)
                result.values[pixel * result.channel_count + channel] = sum[static_cast<int>(channel)] / count;
        },
        pixels_per_block);
    return result;
}

/// Of most passes.
static std::uint32_t channel_count_of(DataPass pass) {
    if (pass == DataPass::Vector)
        return 4;
    return pass == DataPass::Uv || pass == DataPass::DenoisingNormal || pass == DataPass::DenoisingAlbedo ? 3 : 1;
}

NamedPlane DataSums::plane_of(DataPass pass, const Progress& progress) const {
    NamedPlane result{.name = std::string(data_pass_names[static_cast<std::size_t>(pass)]),
                      .channel_count = channel_count_of(pass),
                      .values = {}};
    const std::size_t channel_count = result.channel_count;
    result.values.resize(pixel_count_ * channel_count);
    // A pixel's number, or its three.
    const auto fill = [&](const auto& value_of) {
        parallel_for(
            pixel_count_, progress,
            [&](std::size_t pixel) {
                const float count = static_cast<float>(sample_counts_[pixel]);
                if (count == 0.0f)
                    return;
                const auto value = value_of(pixel, count);
                if constexpr (std::is_same_v<std::decay_t<decltype(value)>, float>)
                    result.values[pixel] = value;
                else
                    std::copy_n(&value.x, channel_count, &result.values[pixel * channel_count]);
            },
            pixels_per_block);
    };
    switch (pass) {
    case DataPass::ObjectIndex:
        result.values = object_index_;
        break;
    case DataPass::MaterialIndex:
        result.values = material_index_;
        break;
    case DataPass::Mist:
        fill([&](std::size_t pixel, float count) { return std::clamp(1.0f - near_cover_[pixel] / count, 0.0f, 1.0f); });
        break;
    case DataPass::SampleCount:
        fill([&](std::size_t, float count) { return count / pixel_samples_; });
        break;
    case DataPass::Uv:
        fill([&](std::size_t pixel, float count) { return uv_[pixel] / count; });
        break;
    case DataPass::DenoisingNormal:
        fill([&](std::size_t pixel, float count) { return features_[pixel].normal / count; });
        break;
    case DataPass::DenoisingAlbedo:
        fill([&](std::size_t pixel, float count) { return features_[pixel].albedo / count; });
        break;
    case DataPass::DenoisingDepth:
        fill([&](std::size_t pixel, float count) { return features_[pixel].depth_m / count; });
        break;
    case DataPass::Vector:
        fill([&](std::size_t pixel, float) {
            return motion_[pixel] / static_cast<float>(std::max(surface_counts_[pixel], 1u));
        });
        break;
    case DataPass::ObjectMattes:
    case DataPass::MaterialMattes:
    case DataPass::AssetMattes:
        break; // see matte_plane
    }
    return result;
}

std::vector<NamedPlane> DataSums::resolve(const Progress& progress) const {
    std::vector<NamedPlane> planes;
    for (std::size_t index = 0; index < data_pass_count; ++index) {
        const auto pass = static_cast<DataPass>(index);
        if (!config_.has(pass))
            continue;
        if (index < matte_kind_count)
            for (std::uint32_t plane = 0; plane < rank_count_ / ranks_per_plane; ++plane)
                planes.push_back(matte_plane(index, plane, progress));
        else
            planes.push_back(plane_of(pass, progress));
    }
    for (std::size_t index = 0; index < config_.aovs.size(); ++index)
        planes.push_back(aov_plane(index, progress));
    return planes;
}
} // namespace tyndall::render
