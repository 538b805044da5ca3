// SPDX-License-Identifier: GPL-3.0-or-later
// The light map fit: its matrix is what shafts are made of and is one with its transpose, it lies where it lay, and it says
// what it cannot do.
#include "core/simd.hpp"
#include "scene/light_texture.hpp"
#include "support/density_grids.hpp"
#include "support/light_map_fits.hpp"
#include <doctest/doctest.h>

namespace light_map_fit_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

TEST_CASE("light map fit: T and its transpose are one matrix, grey and coloured, on every SIMD target") {
    for (const SimdTarget target : available_simd_targets())
        for (const Medium& medium : {grey_fog, coloured_fog}) {
            const ForcedSimdTarget forced(target);
            const std::array strokes{strokes_from({20, -9, 3}, 40), strokes_from({-14, 16, 9}, 24)};
            const Fitted made = begin_fit(medium, strokes, config_of(96));
            const LightMapMatrix& t = made.fit->matrix();
            CHECK(t.is_coloured() == (medium.lobes[0].sigma_s_per_m.x != medium.lobes[0].sigma_s_per_m.y));
            // Both add up the same products of floats; only the order differs.
            CHECK(transpose_error(t) < 1e-6);
        }
}

TEST_CASE("light map fit: under a white map the matrix scatters what the shafts do without one") {
    for (const Medium& medium : {grey_fog, coloured_fog, dense_fog})
        for (const bool attenuates_light : {true, false}) {
            const std::array strokes{strokes_from({20, -9, 3}, 30)};
            LightMapFitConfig config = config_of(64);
            config.shafts.attenuates_light = attenuates_light;
            const Fitted made = begin_fit(medium, strokes, config);
            const LightMapMatrix& t = made.fit->matrix();
            Progress progress;
            const std::vector<vec4> white = product(t, MapTexels(t.texel_count(), vec4(1.0f)));
            std::vector<ViewRay> rays;
            for (const StrokePixel& pixel : strokes[0].pixels)
                rays.push_back(pixel.ray);
            const Result shafts = run(*made.scene, strokes[0].view, rays, config.shafts, progress);
            double worst = 0.0;
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                const glm::dvec3 expected(shafts.radiance[made.fit->pixel_of_ray()[ray]]),
                    found(Rgb(white[ray]) * Rgb(3, 2, 1));
                if (glm::length(expected) > 1e-6)
                    worst = std::max(worst, glm::length(found - expected) / glm::length(expected));
            }
            CHECK(worst < 2e-5); // some hundred sums of floats, each in [0, 1]
        }
}

TEST_CASE("light map fit: a ray reads the map bilinearly where it crosses the middle of a line of texels") {
    const Progress progress;
    constexpr int pitch = LightMapMatrix::pitch_of(8);
    const std::vector<vec4> texels = random_colours(8 * pitch, 1);
    const auto at = [&](int x, int y) { return glm::dvec3(vec3(texels[static_cast<std::size_t>(pitch * y + x)])); };
    for (const bool goes_along_y : {false, true}) {
        std::vector<LightMapMatrix::Part> parts(1);
        parts[0].add_stretches(goes_along_y, 2, 1.25f, 0.5f, std::array{0.0f, 1.0f, 2.0f, 0.0f, 3.0f});
        parts[0].end_ray();
        const LightMapMatrix t(8, false, std::move(parts), progress);
        const std::vector<vec4> radiance = product(t, texels);
        glm::dvec3 expected(0.0);
        for (const auto& [line, weight] : {std::pair{1, 1.0}, {2, 2.0}, {4, 3.0}}) {
            const double across = 1.25 + 0.5 * line, share = across - std::floor(across);
            const int low = static_cast<int>(across);
            expected += weight * (goes_along_y ? glm::mix(at(low, 2 + line), at(low + 1, 2 + line), share)
                                               : glm::mix(at(2 + line, low), at(2 + line, low + 1), share));
        }
        // Two of the weights are rounded to 1 / 65534 of the third.
        CHECK(glm::length(glm::dvec3(vec3(radiance[0])) - expected) < 2.0 * 3.0 / 65534.0);
    }
}

TEST_CASE("light map fit: rays that share a line of the map read it no farther from their own than they may") {
    const std::array strokes{strokes_from({20, -9, 3}, 60)};
    LightMapFitConfig config = config_of(128);
    config.shared_texels = 0.0f;
    const Fitted alone = begin_fit(grey_fog, strokes, config);
    const LightMapMatrix& t = alone.fit->matrix();
    // Ramps of one per texel: what is read is the mean place of a ray's light, of which a shared line changes no more.
    std::vector<vec4> ramps(t.texel_count());
    for (std::size_t texel = 0; texel < ramps.size(); ++texel)
        ramps[texel] = vec4(static_cast<float>(texel % t.pitch()), static_cast<float>(texel / t.pitch()), 1.0f, 0.0f);
    const std::vector<vec4> own = product(t, ramps);
    std::size_t samples = t.sample_count();
    for (const float shared_texels : {0.1f, 0.4f}) {
        config.shared_texels = shared_texels;
        const Fitted together = begin_fit(grey_fog, strokes, config);
        CHECK(together.fit->matrix().sample_count() < (shared_texels < 0.2f ? samples : samples / 2));
        samples = together.fit->matrix().sample_count();
        const std::vector<vec4> shared = product(together.fit->matrix(), ramps);
        for (std::size_t ray = 0; ray < own.size(); ++ray) {
            if (own[ray].z == 0.0f)
                continue;
            CHECK(std::abs(shared[ray].z / own[ray].z - 1.0f) < 1e-4f);
            const vec2 moved = vec2(shared[ray]) / shared[ray].z - vec2(own[ray]) / own[ray].z;
            CHECK(std::max(std::abs(moved.x), std::abs(moved.y)) < shared_texels + 2e-3f);
        }
    }
}

TEST_CASE("light map fit: what cannot be fitted is named") {
    Progress progress;
    const auto message_of = [&](const Scene& scene, std::span<const Strokes> strokes) -> std::string {
        const Media media(scene, progress);
        try {
            const LightMapFit fit(scene, media, strokes, {}, config_of(32), progress);
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "nothing was wrong";
    };
    const auto scene = soup_in_fog(grey_fog);
    CHECK(message_of(*scene, {}) == "nothing is painted: no stroke image has a pixel with an alpha above 0");
    const std::array unpainted{Strokes{}};
    CHECK(message_of(*scene, unpainted) == "nothing is painted: no stroke image has a pixel with an alpha above 0");
    std::array past_the_fog{strokes_from({20, -9, 3}, 4)};
    for (StrokePixel& pixel : past_the_fog[0].pixels)
        pixel.ray.direction = -pixel.ray.direction;
    CHECK(message_of(*scene, past_the_fog) ==
          "no painted pixel sees air that light \"Sun\" reaches: paint where its shafts are");
    const auto with_globe = support::make_scene(
        {{.mesh = support::cube(), .material = {.name = "fog", .medium_index = 0, .has_surface = false}}}, {grey_fog},
        {{.name = "Lamp", .kind = LightKind::Point, .position = {0, 0, 3}, .radius_m = 0.2f}});
    CHECK(message_of(*with_globe, red_and_blue) ==
          "Light \"Lamp\" glows as a sphere, each of its points in one colour: switch its Soft Falloff on, or set its "
          "Radius to 0");
    for (const LightKind kind : {LightKind::Sun, LightKind::Spot}) {
        SceneDescription smoke = description_of(
            *support::make_scene({{.mesh = support::square()}}, {grey_fog},
                                 {{.name = "Light", .kind = kind, .position = {0, 0, 4}, .towards_light = {0, 0, 1}}}));
        smoke.volumes = {{.name = "smoke", .grid = unit_grid(16, [](int, int, int) { return 1.0f; })}};
        CHECK(message_of(Scene(std::move(smoke), progress), red_and_blue) ==
              (kind == LightKind::Sun
                   ? "nothing was wrong"
                   : "no painted pixel sees air that light \"Light\" reaches: paint where its shafts "
                     "are; of a lamp, volumes with density grids are not fitted, only even air is"));
    }
    const auto clear = support::make_scene({{.mesh = support::square()}}, {}, {{.name = "Sun"}});
    CHECK(message_of(*clear, red_and_blue) == "nothing scatters: no medium in the scene");
}

TEST_CASE("light map fit: a place is kept while it covers what is seen, and moves by whole texels") {
    const Focus focus{.min_m = {-3.2f, 1.0f}, .max_m = {4.9f, 6.0f}};
    const LightMapPlace place = snapped(focus, 128);
    CHECK(covers(place, focus));
    CHECK(place.size_m < 1.35f * 8.1f); // a step of sizes is 2^(1/4), margins 6 texels of 128
    Focus moved = focus;
    for (int step = 0; step < 50; ++step) {
        moved.min_m += vec2(0.013f, -0.007f);
        moved.max_m += vec2(0.013f, -0.007f);
        const LightMapPlace next = snapped(moved, 128);
        CHECK(next.size_m == place.size_m);
        CHECK(covers(next, moved));
        const vec2 texels = (next.centre_m - place.centre_m) / place.texel_m();
        CHECK(glm::length(texels - glm::round(texels)) < 1e-3f);
    }
    LightMap map{.place = place, .texels = std::vector<Rgb>(128 * 128, Rgb(0.25f))};
    CHECK(resampled(map, snapped(moved, 64)) == std::vector<Rgb>(64 * 64, Rgb(0.25f)));
}

TEST_CASE("light map fit: what the matrix says of a map is what shafts look like under it") {
    const std::array strokes{strokes_from({20, -9, 3}, 24)};
    const Fitted made = begin_fit(grey_fog, strokes, config_of(128));
    const LightMapPlace place = made.fit->place();
    auto image = std::make_shared<Texture>();
    image->width = image->height = place.resolution;
    image->is_srgb = false;
    image->extension = TextureExtension::Extend;
    LightMap map{.place = place, .texels = {}};
    std::vector<float> texels;
    for (std::uint32_t texel = 0; texel < place.resolution * place.resolution; ++texel) {
        const vec2 at(static_cast<float>(texel % place.resolution), static_cast<float>(texel / place.resolution));
        // Waves of some 15 texels: between texels, two ways to interpolate differ by their curvature.
        map.texels.push_back(0.5f +
                             0.4f * Rgb(std::sin(0.4f * at.x), std::cos(0.3f * at.y), std::sin(0.2f * (at.x + at.y))));
        texels.insert(texels.end(), {map.texels.back().x, map.texels.back().y, map.texels.back().z, 1.0f});
    }
    image->floats = std::move(texels);
    SceneDescription description = description_of(*made.scene);
    description.lights[0].texture = std::make_shared<const LightTexture>(
        LightTexture{.image = std::make_shared<const FilteredTexture>(std::move(image)),
                     .size_m = vec2(place.size_m),
                     .centre_m = place.centre_m});
    Progress progress;
    const Scene under_map(std::move(description), progress);
    std::vector<ViewRay> rays;
    for (const StrokePixel& pixel : strokes[0].pixels)
        rays.push_back(pixel.ray);
    const Result shafts = run(under_map, strokes[0].view, rays, {.method = Method::Exact}, progress);
    const std::vector<vec4> said = product(made.fit->matrix(), padded(map));
    std::vector<vec4> expected;
    for (const std::uint32_t pixel : made.fit->pixel_of_ray())
        expected.emplace_back(shafts.radiance[pixel] / Rgb(3, 2, 1), 0.0f);
    CHECK(relative_rms(said, expected) < 3e-3);
}
} // namespace light_map_fit_test
