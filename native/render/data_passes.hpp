// SPDX-License-Identifier: GPL-3.0-or-later
// Passes that tell what a pixel shows, not how it is lit: Cryptomattes, indices, UV, mist, number of samples, and what
// materials put into passes of their own.
// Based on: Friedman and Jones, Cryptomatte specification 1.2.0, 2016; each pass is what Cycles' is, see the members.
// Differs:  from Cycles, transparent layers share a sample by what each of them covers, and not at random: a matte behind
//           glass has no noise. The expected picture is the same.
// Bound:    8 bytes per pixel, rank and kind of matte. Nothing is found and nothing kept where no such pass is asked for.
#pragma once
#include "core/progress.hpp"
#include "render/denoising_features.hpp"
#include "render/motion_vectors.hpp"
#include "scene/scene.hpp"
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace tyndall::render {
enum class DataPass : std::uint8_t {
    ObjectMattes = 0,   ///< Ranked pairs of an object's id and its share of the pixel, two pairs per plane.
    MaterialMattes = 1, ///< The same of materials.
    AssetMattes = 2,    ///< The same of what objects belong to.
    ObjectIndex = 3,    ///< Of the pixel's centre, as the next.
    MaterialIndex = 4,
    Uv = 5,              ///< u, v, and 1 where there is a UV map; the mean over samples.
    Mist = 6,            ///< 0 near, 1 far.
    SampleCount = 7,     ///< Share of the samples that the pixel has taken.
    DenoisingNormal = 8, ///< As DenoisingFeatures, as the next; the mean over samples.
    DenoisingAlbedo = 9,
    DenoisingDepth = 10,
    Vector = 11, ///< motion_vector(); the mean over samples that show a surface.
};
inline constexpr std::size_t data_pass_count = 12, matte_kind_count = 3;
/// What only a pixel's centre tells: pixel_centres.hpp.
inline constexpr std::uint32_t index_pass_bits =
    1u << static_cast<unsigned>(DataPass::ObjectIndex) | 1u << static_cast<unsigned>(DataPass::MaterialIndex);
/// As Blender calls them up to 4.5; mattes' planes have their number, of two digits, behind it.
inline constexpr std::array<std::string_view, data_pass_count> data_pass_names{
    "CryptoObject", "CryptoMaterial",     "CryptoAsset",      "IndexOB",          "IndexMA",         "UV",
    "Mist",         "Debug Sample Count", "Denoising Normal", "Denoising Albedo", "Denoising Depth", "Vector"};

struct MistRange {
    float start_m = 5.0f, depth_m = 25.0f; ///< A depth of 0: all is near.
    float exponent = 2.0f;                 ///< Of the way from one to the other.
};

/// A pass that materials fill by programs of their own: what these emit; 0 where a material has none.
struct Aov {
    std::string name;
    bool is_colour = true; ///< Four channels, the last one the share of samples that have it; else one.
    /// By the surface's material, into SceneDescription::materials.
    std::unordered_map<std::uint32_t, std::uint32_t> program_of = {};
};

struct DataPassConfig {
    std::uint32_t bits = 0;        ///< 1 << pass, of those asked for.
    std::uint32_t matte_ranks = 6; ///< Of each kind, [1, 16]; rounded up to even.
    /// By an object's name, of those that belong to another one: its name.
    std::unordered_map<std::string, std::string> asset_of = {};
    /// By a material's name, of those that matte files know by another.
    std::unordered_map<std::string, std::string> material_alias = {};
    std::unordered_map<std::string, float> material_index = {}; ///< By name; the others' is 0.
    MistRange mist = {};
    std::vector<Aov> aovs = {};
    std::shared_ptr<const NeighbourFrames> neighbours = {}; ///< Of Vector, which has nothing without them.

    [[nodiscard]] bool has(DataPass pass) const { return (bits >> static_cast<unsigned>(pass) & 1u) != 0; }
    [[nodiscard]] bool has_mattes() const {
        return has(DataPass::ObjectMattes) || has(DataPass::MaterialMattes) || has(DataPass::AssetMattes);
    }
    [[nodiscard]] bool has_features() const {
        return has(DataPass::DenoisingNormal) || has(DataPass::DenoisingAlbedo) || has(DataPass::DenoisingDepth);
    }
    [[nodiscard]] bool is_wanted() const { return bits != 0 || !aovs.empty(); }
    /// Throws InvalidInput that lists the names there are.
    void add(std::string_view name);
};

/// What one camera ray finds.
struct PathData {
    struct Layer {
        std::uint32_t name_index, material_index;
        float cover; ///< Share of the pixel.
    };
    std::vector<Layer> layers;
    float near_cover = 0.0f; ///< Cover of layers, each times what the mist leaves of it.
    /// Of the first surface that lets no more pass than FrameConfig::pass_alpha_threshold allows.
    bool has_surface = false, has_uv = false;
    std::uint32_t name_index = 0, material_index = 0;
    vec2 uv{0.0f};
    std::vector<vec4> aovs; ///< As many as the settings have; RGB and how much of it there is.
    DenoisingFeatures features;
    vec4 motion{0.0f}; ///< Of the surface.
    void clear();
};

/// What rays find, ray by ray, and what is asked for; empty where nothing is.
struct DataOfRays {
    std::span<PathData> each = {};
    const DataPassConfig* config = nullptr;
};

/// Of samples that choose one of a surface's shaders by its weight, as Cycles' do, those that go straight on, whatever colour
/// they are dimmed by. Lobes may be apart from those that bend rays.
[[nodiscard]] float share_going_on(const SurfaceClosures& closures, std::span<const Lobe> lobes,
                                   std::span<const Lobe> bent);
/// Adds the values that a surface has for each pass, by how much of the samples come to it.
void see_aovs(const Scene& scene, const AskingRay& asking, const ShadingPoint& point, const Hit& hit, float reached,
              std::span<const Aov> aovs, PathData& data);

/// A surface on the way of a camera ray. `cover` is the share of the pixel that it hides; `is_first`: it is the one
/// that PathData tells of.
void see_layer(const Scene& scene, const Camera& camera, const Hit& hit, const vec3& position, float cover,
               bool is_first, const DataPassConfig& config, PathData& data);

struct NamedPlane {
    std::string name;
    std::uint32_t channel_count = 1;
    std::vector<float> values; ///< Rows bottom to top; a pixel's channels side by side.
};

/// Sums of samples. Pixels are independent: threads may add to different ones. Samples of a pixel come in order.
class DataSums {
public:
    /// Throws InvalidInput for settings out of their range.
    DataSums(std::size_t pixel_count, std::uint32_t pixel_samples, const Scene& scene, const DataPassConfig& config);
    void add(std::size_t pixel, const PathData& data);
    /// Once a pixel, of the surface that a ray found.
    void set_indices(std::size_t pixel, const PathData& data);
    /// So far, in the order of DataPass; a pixel without a sample is 0.
    [[nodiscard]] std::vector<NamedPlane> resolve(const Progress& progress) const;

private:
    /// An id, and the sum of its shares; an id of 0 is nothing, as in Cycles.
    struct Rank {
        float id = 0.0f, cover = 0.0f;
    };
    [[nodiscard]] float id_of(std::size_t kind, const PathData::Layer& layer) const;
    void add_matte(Rank* ranks, float id, float cover) const;
    [[nodiscard]] NamedPlane matte_plane(std::size_t kind, std::uint32_t plane, const Progress& progress) const;
    [[nodiscard]] NamedPlane aov_plane(std::size_t index, const Progress& progress) const;
    [[nodiscard]] NamedPlane plane_of(DataPass pass, const Progress& progress) const;

    std::size_t pixel_count_;
    float pixel_samples_;
    const Scene& scene_;
    DataPassConfig config_;
    std::uint32_t rank_count_;                             ///< Even.
    std::array<std::vector<float>, matte_kind_count> ids_; ///< By name or material.
    std::array<std::vector<Rank>, matte_kind_count> mattes_;
    std::vector<float> material_indices_;
    std::vector<float> object_index_, material_index_, near_cover_;
    std::vector<vec4> motion_; ///< And how many samples show a surface:
    std::vector<std::uint32_t> surface_counts_;
    std::vector<vec3> uv_;
    std::vector<vec4> aovs_; ///< Pixel by pixel.
    std::vector<DenoisingFeatures> features_;
    std::vector<std::uint32_t> sample_counts_;
};
} // namespace tyndall::render
