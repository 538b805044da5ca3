// SPDX-License-Identifier: GPL-3.0-or-later
// The light map fit of spots and point lights: their matrix is what their shafts are made of, under a white map and under any
// other, one with its transpose; and maps are found again.
#include "core/simd.hpp"
#include "scene/light_texture.hpp"
#include "support/light_map_fits.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace light_map_fit_lamp_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// Above the fog, or in its middle; a spot's cone covers the most of it, with a soft edge.
Light lamp(LightKind kind, SpotFalloff falloff = SpotFalloff::Blender4) {
    const mat3 world_from_light = mat3(glm::rotate(mat4(1.0f), 0.4f, glm::normalize(vec3(1, 2, 3))));
    return {.name = "Lamp",
            .kind = kind,
            .strength = {300.0f, 200.0f, 100.0f},
            .position = kind == LightKind::Spot ? vec3(-2.0f, 1.0f, 9.0f) : vec3(0.7f, -0.4f, 0.9f),
            .spot_axis = -world_from_light[2],
            .spot_half_angle_rad = 0.6f,
            .spot_blend = 0.5f,
            .spot_falloff = falloff,
            .light_from_world_directions = glm::transpose(world_from_light)};
}
constexpr std::array kinds{LightKind::Spot, LightKind::Point};

Fitted begin_lamp_fit(const Light& light, const Medium& medium, std::span<const Strokes> strokes,
                      const LightMapFitConfig& config) {
    Progress progress;
    Fitted made{.scene = soup_in_fog(medium, 120, light), .media = {}, .fit = {}};
    made.media = std::make_unique<Media>(*made.scene, progress);
    made.fit = std::make_unique<LightMapFit>(*made.scene, *made.media, strokes, LightMap{}, config, progress);
    return made;
}
/// Past each other, so that the two views have nothing in common but the lamp. The second camera is near it.
const std::array views{strokes_from({20, -9, 3}, 40), strokes_from({-3, 4, 9.5f}, 24)};

std::vector<vec4> shafts_of(const Scene& scene, const LightMapFit& fit, std::span<const Strokes> strokes,
                            const Config& config) {
    Progress progress;
    std::vector<Rgb> radiance;
    for (const Strokes& view : strokes) {
        std::vector<ViewRay> rays;
        for (const StrokePixel& pixel : view.pixels)
            rays.push_back(pixel.ray);
        const Result shafts = run(scene, view.view, rays, config, progress);
        radiance.insert(radiance.end(), shafts.radiance.begin(), shafts.radiance.end());
    }
    std::vector<vec4> result;
    for (const std::uint32_t pixel : fit.pixel_of_ray())
        result.emplace_back(radiance[pixel] / scene.lights()[0].strength, 0.0f);
    return result;
}
} // namespace

TEST_CASE("light map fit: a lamp's T and its transpose are one matrix, grey and coloured, on every SIMD target") {
    for (const SimdTarget target : available_simd_targets())
        for (const LightKind kind : kinds)
            for (const Medium& medium : {grey_fog, coloured_fog}) {
                const ForcedSimdTarget forced(target);
                const Fitted made = begin_lamp_fit(lamp(kind), medium, views, config_of(96));
                const LightMapMatrix& t = made.fit->matrix();
                CHECK(t.is_coloured() == (medium.lobes[0].sigma_s_per_m.x != medium.lobes[0].sigma_s_per_m.y));
                // Both add up the same products of floats; only the order differs.
                CHECK(transpose_error(t) < 1e-6);
            }
}

TEST_CASE("light map fit: under a white map a lamp's matrix scatters what its shafts do without one") {
    std::vector<Light> lamps{lamp(LightKind::Point), lamp(LightKind::Spot),
                             lamp(LightKind::Spot, SpotFalloff::Blender3)};
    // Stretched along its own x: so is its cone, and so is what it throws.
    lamps.push_back(lamps[1]);
    lamps.back().light_from_world_directions =
        mat3(glm::scale(mat4(1.0f), vec3(0.5f, 1, 1))) * lamps.back().light_from_world_directions;
    lamps.push_back(lamps[0]);
    lamps.back().position = {30, 2, 5}; // outside of the fog
    for (const Light& light : lamps)
        for (const Medium& medium : {grey_fog, coloured_fog, dense_fog})
            for (const bool attenuates_light : {true, false}) {
                LightMapFitConfig config = config_of(64);
                config.shafts.attenuates_light = attenuates_light;
                const Fitted made = begin_lamp_fit(light, medium, views, config);
                const LightMapMatrix& t = made.fit->matrix();
                const std::vector<vec4> said = product(t, MapTexels(t.texel_count(), vec4(1.0f)));
                const std::vector<vec4> expected = shafts_of(*made.scene, *made.fit, views, config.shafts);
                // Each piece is integrated to 1e-5 by the shafts, which have fewer and longer ones.
                CHECK(relative_rms(said, expected) < 2e-5);
                CHECK(relative_rms(t.white(), expected) < 2e-5);
            }
}

TEST_CASE("light map fit: what a lamp's matrix says of a map is what its shafts look like under it") {
    constexpr std::uint32_t side = 256;
    for (const LightKind kind : kinds) {
        const Light light = lamp(kind);
        const Fitted made = begin_lamp_fit(light, grey_fog, views, config_of(side));
        const LightMapPlace place = made.fit->place();
        CHECK(place == thrown_place(side));
        auto image = std::make_shared<Texture>();
        image->width = image->height = place.resolution;
        image->is_srgb = false;
        image->extension = kind == LightKind::Spot ? TextureExtension::Extend : TextureExtension::Repeat;
        LightMap map{.place = place, .texels = {}};
        std::vector<float> texels;
        constexpr float per_texel =
            2.0f * std::numbers::pi_v<float> / static_cast<float>(side); // whole waves around a point light
        for (std::uint32_t texel = 0; texel < place.resolution * place.resolution; ++texel) {
            const float x = per_texel * static_cast<float>(texel % place.resolution),
                        y = per_texel * static_cast<float>(texel / place.resolution);
            map.texels.push_back(0.5f +
                                 0.4f * Rgb(std::sin(4.0f * x), std::cos(3.0f * y), std::sin(2.0f * x + 3.0f * y)));
            texels.insert(texels.end(), {map.texels.back().x, map.texels.back().y, map.texels.back().z, 1.0f});
        }
        image->floats = std::move(texels);
        LightTexture thrown = thrown_by(light);
        thrown.image = std::make_shared<const FilteredTexture>(std::move(image));
        SceneDescription description = description_of(*made.scene);
        description.lights[0].texture = std::make_shared<const LightTexture>(std::move(thrown));
        Progress progress;
        const Scene under_map(std::move(description), progress);
        const std::vector<vec4> said = product(made.fit->matrix(), padded(map));
        CAPTURE(static_cast<int>(kind));
        // The shafts read 64 means of the picture along a ray: that is where they differ.
        CHECK(relative_rms(said, shafts_of(under_map, *made.fit, views, {.method = Method::Exact})) < 3e-3);
    }
}

TEST_CASE("light map fit: strokes that show a lamp's shafts from all sides give its map back") {
    std::vector<Strokes> strokes;
    // Beside the lamp, where a ray stays within few texels, and across its light.
    for (const vec3& position : {vec3(-2.6f, 1.4f, 9.6f), vec3(-1.2f, 0.2f, 9.8f), vec3(20, -9, 3), vec3(-14, 16, 9)})
        strokes.push_back(strokes_from(position, 50));
    for (const LightKind kind : kinds) {
        Light above_fog = lamp(kind);
        above_fog.position = {-2.0f, 1.0f, 9.0f};
        const Fitted made = begin_lamp_fit(above_fog, grey_fog, strokes, config_of(16));
        const LightMapMatrix& t = made.fit->matrix();
        const Progress progress;
        const std::vector<vec4> known = random_colours(t.texel_count(), 9), target = product(t, known);
        LightMapSolver solver(t, target, std::vector<float>(target.size(), 1.0f), MapTexels(known.size(), vec4(1.0f)),
                              MapTexels(known.size(), vec4(1.0f)), 1e-9f);
        for (int step = 0; step < 400 && solver.step(); ++step) {
        }
        std::vector<vec4> squares(known.size());
        t.square_columns(std::vector<vec4>(target.size(), vec4(1.0f)), squares, progress);
        const float most = std::ranges::max(squares, {}, &vec4::x).x;
        double worst = 0.0;
        std::size_t determined_count = 0;
        for (std::size_t texel = 0; texel < known.size(); ++texel)
            if (squares[texel].x > 0.05f * most) {
                ++determined_count;
                worst = std::max(worst, glm::length(glm::dvec3(vec3(solver.texels()[texel] - known[texel]))));
            }
        CAPTURE(static_cast<int>(kind));
        CHECK(determined_count > 40);
        CHECK(worst < 5e-3);
        CHECK(solver.history().back().residual < 1e-4);
    }
}

TEST_CASE("light map fit: strokes beside a spot's cone see nothing of it") {
    Progress progress;
    Light narrow = lamp(LightKind::Spot);
    narrow.spot_half_angle_rad = 0.05f;
    const auto scene = soup_in_fog(grey_fog, 0, narrow);
    const Media media(*scene, progress);
    std::array beside{strokes_from({20, -9, 3}, 8)};
    for (StrokePixel& pixel : beside[0].pixels)
        pixel.ray.far_m = 16.0f; // the fog's near corner
    CHECK_THROWS_WITH_AS(LightMapFit(*scene, media, beside, {}, config_of(32), progress),
                         "no painted pixel sees air that light \"Lamp\" reaches: paint where its shafts are",
                         InvalidInput);
}
} // namespace light_map_fit_lamp_test
