// SPDX-License-Identifier: GPL-3.0-or-later
// The picture: named float planes, and the sums of samples that they are resolved from.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "core/statistics.hpp"
#include "render/caught_light.hpp"
#include "render/data_passes.hpp"
#include "render/light_paths.hpp"
#include "render/shared_irradiance.hpp"
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tyndall::render {
/// What a plane holds. Colours are mean over the samples; the others follow Cycles, see PathSample.
enum class Pass : std::uint8_t {
    Combined = 0,
    Depth = 1,
    Normal = 2,
    Position = 3,
    DiffuseColour = 4,
    Emission = 5,
    Shadow = 6,
    Shafts = 7,
    ShaftsVisibility = 8,
    Transmittance = 9,
    AmbientOcclusion = 10,
    Unshadowed = 11,    ///< What Shadow is a share of: films that are averaged weigh it by this.
    ShadowCatcher = 12, ///< What the shadows on catchers leave of what lies behind; then Combined does without it.
    DiffuseDirect = 13, ///< This and the next ones: LightPaths, light not divided by its colour.
    DiffuseIndirect = 14,
    GlossyDirect = 15,
    GlossyIndirect = 16,
    TransmissionDirect = 17,
    TransmissionIndirect = 18,
    Environment = 19,
    GlossyColour = 20,
    TransmissionColour = 21,
};
inline constexpr std::size_t pass_count = 22;
struct PassLayout {
    std::string_view name; ///< As Blender names the pass.
    std::uint32_t channel_count;
};
inline constexpr std::array<PassLayout, pass_count> pass_layouts{
    {{"Combined", 4}, {"Depth", 1},      {"Normal", 3},         {"Position", 3},          {"DiffCol", 3},
     {"Emit", 3},     {"Shadow", 3},     {"Shafts", 3},         {"Shafts Visibility", 1}, {"Transmittance", 3},
     {"AO", 3},       {"Unshadowed", 3}, {"Shadow Catcher", 3}, {"DiffDir", 3},           {"DiffInd", 3},
     {"GlossDir", 3}, {"GlossInd", 3},   {"TransDir", 3},       {"TransInd", 3},          {"Env", 3},
     {"GlossCol", 3}, {"TransCol", 3}}};
[[nodiscard]] constexpr const PassLayout& layout(Pass pass) { return pass_layouts[static_cast<std::size_t>(pass)]; }
/// The pass of this name; throws InvalidInput that lists the names there are.
[[nodiscard]] Pass pass_named(std::string_view name);

/// Passes that a frame computes; Combined always.
class PassSet {
public:
    void add(Pass pass) { bits_ |= bit(pass); }
    [[nodiscard]] bool has(Pass pass) const { return (bits_ & bit(pass)) != 0; }
    /// One of those that LightPaths are for.
    [[nodiscard]] bool tells_paths() const { return bits_ >= bit(Pass::DiffuseDirect); }

private:
    static constexpr std::uint32_t bit(Pass pass) { return 1u << static_cast<unsigned>(pass); }
    std::uint32_t bits_ = bit(Pass::Combined);
};

struct Plane {
    Pass pass = Pass::Combined;
    std::vector<float> values; ///< Rows bottom to top; a pixel's channels side by side.
};
struct UnstyledFilm;
struct Film {
    std::uint32_t width_px = 0, height_px = 0;
    std::vector<Plane> planes;                ///< In the order of Pass; those that were asked for.
    std::vector<NamedPlane> data_planes = {}; ///< Those of data passes.
    Statistics statistics;
    std::shared_ptr<const UnstyledFilm> unstyled = {}; ///< For styled(); where the frame's settings ask for it.
    [[nodiscard]] const Plane* find(Pass pass) const;
};

/// What one camera ray brings home.
struct PathSample {
    Rgb radiance{0.0f};
    float alpha = 1.0f;
    /// Of the first surface that covers at least half of what is behind it, as Cycles' alpha threshold of 0.5 says.
    float depth_m = 0.0f; ///< Along the camera's -Z; 0: no such surface. The film holds the pixel's centre's.
    vec3 normal{0.0f};    ///< Shading normal in world space, on the viewer's side; the mean over samples.
    vec3 position{0.0f};  ///< In the scene's space. The film holds the centre's, in world space.
    Rgb diffuse_colour{0.0f}, emission{0.0f}; ///< Through what lies in front.
    Rgb lit{0.0f}, unshadowed{0.0f};          ///< Irradiance from lights with and without occluders.
    Rgb transmittance{1.0f};                  ///< Through the media before that surface.
    Rgb ambient{0.0f};                        ///< Share of the world that surfaces see, through what lies in front.
    WorldLit world_lit;                       ///< Its light is in `radiance`, too.
    /// Of `radiance`, what comes from the lights of each group; empty where nobody asks.
    std::span<Rgb> by_group = {};
    /// Of shadow catchers, none of which is in what stands above; nothing: the scene has none.
    CaughtLight* caught = nullptr;
    /// Of `radiance`, by what sent it; nothing: nobody asks.
    LightPaths* paths = nullptr;

    [[nodiscard]] Rgb& light_of(LightOf of) {
        return of == LightOf::Picture ? radiance : of == LightOf::CatcherAmongAll ? caught->lit : caught->alone;
    }
    /// By itself a sample of the shadow on catchers, in no colour: whether a pixel's samples agree.
    [[nodiscard]] Rgb shadow() const {
        return caught == nullptr ? Rgb(0.0f) : Rgb(caught->weight * (1.0f - caught->kept_as_seen()));
    }
    /// To no group. As in Cycles, light of catchers is in no group, and comes no way that passes tell.
    void add_light(const Rgb& light, LightOf of, const LightWay& way) {
        light_of(of) += light;
        if (paths != nullptr && of == LightOf::Picture)
            paths->add(way, light);
    }
    void add_light(const Rgb& light, std::uint8_t group, LightOf of, const LightWay& way) {
        add_light(light, of, way);
        if (of == LightOf::Picture && group < by_group.size())
            by_group[group] += light;
    }
};

/// Whether there are shadow catchers, and what is to be seen behind them.
enum class CatcherFilm : std::uint8_t { None = 0, Transparent = 1, World = 2 };

/// Sums of samples. Pixels are independent: threads may add to different ones. Samples of a pixel come in order.
class FilmSums {
public:
    FilmSums(std::uint32_t width_px, std::uint32_t height_px, const PassSet& passes, const dvec3& origin_in_world,
             CatcherFilm catchers = CatcherFilm::None);
    [[nodiscard]] bool wants(Pass pass) const { return offsets_[static_cast<std::size_t>(pass)].has_value(); }
    void add(std::size_t pixel, const PathSample& sample);
    /// Once a pixel: what Depth and Position show; see PathSample.
    void set_place(std::size_t pixel, float depth_m, const vec3& position);
    /// More of what Lambert's share sends back of the world, of the sample that was added last to this pixel.
    void add_world_light(std::size_t pixel, const Rgb& radiance) {
        add_colour(pixel, Pass::Combined, radiance);
        add_colour(pixel, Pass::DiffuseDirect, radiance);
    }
    /// The light shafts of the sample that was added last to this pixel.
    void add_shafts(std::size_t pixel, const Rgb& radiance, float visibility);
    /// The film so far; a pixel without a sample is 0.
    [[nodiscard]] Film resolve(const Progress& progress) const;

private:
    [[nodiscard]] float* channels(std::size_t pixel, Pass pass) {
        return &sums_[pixel * stride_ + *offsets_[static_cast<std::size_t>(pass)]];
    }
    [[nodiscard]] float resolved(std::size_t pixel, Pass pass, std::uint32_t channel) const;
    void add_colour(std::size_t pixel, Pass pass, const Rgb& colour);
    void add_paths(std::size_t pixel, const LightPaths& paths);
    /// What shadow catchers add to a pixel's picture.
    [[nodiscard]] vec4 caught_colour(std::size_t pixel) const;
    [[nodiscard]] Rgb shadow_catcher(std::size_t pixel) const;

    std::uint32_t width_px_, height_px_;
    dvec3 origin_in_world_;
    std::array<std::optional<std::uint32_t>, pass_count> offsets_{};
    std::uint32_t shadow_weight_offset_ = 0; ///< Of the unshadowed irradiance; the pass is a ratio.
    std::uint32_t stride_ = 0;
    std::vector<float> sums_;
    std::vector<std::uint32_t> sample_counts_;
    CatcherFilm catchers_;
    std::vector<CaughtLight> caught_; ///< Per pixel; empty without a catcher.
};
} // namespace tyndall::render
