// SPDX-License-Identifier: GPL-3.0-or-later
// The light map fit: its matrix is what shafts are made of and is one with its transpose; its solver finds the map where
// strokes determine it, leaves alone what they do not see, and never makes things worse.
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "light_shafts/light_map_fit.hpp"
#include "scene/light_texture.hpp"
#include "support/soup.hpp"
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr float side_m = 8.0f;

Medium fog(const Rgb& sigma_s, const Rgb& sigma_a) {
    return {.name = "fog", .lobes = {{sigma_s, 0.3f}}, .sigma_a_per_m = sigma_a};
}
const Medium grey_fog = fog(Rgb(0.06f), Rgb(0.02f)), coloured_fog = fog({0.06f, 0.04f, 0.02f}, {0.01f, 0.03f, 0.05f});

/// A cube of fog with triangles in it, under a sun.
std::unique_ptr<Scene> soup_in_fog(const Medium& medium, std::size_t triangle_count = 120) {
    return support::make_scene(
        {{.mesh = support::soup_mesh(triangle_count, {.min = vec3(-7.0f), .max = vec3(7.0f)}, 2.5f, 21)},
         {.mesh = support::cube(),
          .world_from_object = glm::scale(mat4(1.0f), vec3(side_m)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
        {medium},
        {{.name = "Sun",
          .kind = LightKind::Sun,
          .strength = Rgb(3.0f, 2.0f, 1.0f),
          .position = {1.0f, 2.0f, 30.0f},
          .towards_light = glm::normalize(vec3(0.4f, 0.3f, 0.8f))}});
}
/// Rays of a camera that looks at the fog's middle from outside, painted one colour.
Strokes strokes_from(const vec3& position, int side_px, const Rgb& desired = Rgb(1.0f)) {
    Strokes strokes{.view = {.position = position}, .pixels = {}};
    const vec3 forward = glm::normalize(-position), right = glm::normalize(glm::cross(forward, vec3(0, 0, 1)));
    const vec3 up = glm::cross(right, forward);
    for (int y = 0; y < side_px; ++y)
        for (int x = 0; x < side_px; ++x) {
            const vec2 place = 0.55f * ((vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f) * 2.0f /
                                            static_cast<float>(side_px) -
                                        1.0f);
            const vec3 direction = glm::normalize(forward + place.x * right + place.y * up);
            strokes.pixels.push_back({{position, direction, 0.0f, 60.0f}, desired, 1.0f});
        }
    return strokes;
}
struct Fitted {
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Media> media;
    std::unique_ptr<LightMapFit> fit;
};
Fitted begin_fit(const Medium& medium, std::span<const Strokes> strokes, const LightMapFitConfig& config,
                 const LightMap& current = {}) {
    Progress progress;
    Fitted made{.scene = soup_in_fog(medium), .media = {}, .fit = {}};
    made.media = std::make_unique<Media>(*made.scene, progress);
    made.fit = std::make_unique<LightMapFit>(*made.scene, *made.media, strokes, current, config, progress);
    return made;
}
LightMapFitConfig config_of(std::uint32_t resolution, float regularisation = 1e-3f) {
    return {.resolution = resolution, .regularisation = regularisation, .shafts = {.method = Method::Exact}};
}
std::vector<vec4> random_colours(std::size_t count, std::uint64_t seed) {
    support::SceneRandom random(seed);
    std::vector<vec4> colours(count);
    for (vec4& colour : colours)
        colour = {random.uniform(), random.uniform(), random.uniform(), 0.0f};
    return colours;
}
std::vector<vec4> product(const LightMapMatrix& t, const std::vector<vec4>& texels) {
    LightMapMatrix::Scratch scratch;
    std::vector<vec4> radiance(t.ray_count());
    t.multiply(texels, radiance, scratch, Progress());
    return radiance;
}
double inner_product(std::span<const vec4> a, std::span<const vec4> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += glm::dot(glm::dvec3(a[i]), glm::dvec3(b[i]));
    return sum;
}
double relative_rms(std::span<const vec4> a, std::span<const vec4> b) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]), v(b[i]);
        difference += glm::dot(d, d);
        size += glm::dot(v, v);
    }
    return std::sqrt(difference / size);
}
} // namespace

TEST_CASE("light map fit: T and its transpose are one matrix, grey and coloured, on every SIMD target") {
    for (const SimdTarget target : available_simd_targets())
        for (const Medium& medium : {grey_fog, coloured_fog}) {
            const ForcedSimdTarget forced(target);
            const std::array strokes{strokes_from({20, -9, 3}, 40), strokes_from({-14, 16, 9}, 24)};
            const Fitted made = begin_fit(medium, strokes, config_of(96));
            const LightMapMatrix& t = made.fit->matrix();
            CHECK(t.is_coloured() == (medium.lobes[0].sigma_s_per_m.x != medium.lobes[0].sigma_s_per_m.y));
            const Progress progress;
            const std::vector<vec4> x = random_colours(t.texel_count(), 3), y = random_colours(t.ray_count(), 4);
            const std::vector<vec4> t_x = product(t, x);
            std::vector<vec4> t_y(x.size());
            t.multiply_transposed(y, t_y, progress);
            // Both add up the same products of floats; only the order differs.
            CHECK(std::abs(inner_product(t_x, y) / inner_product(x, t_y) - 1.0) < 1e-6);
        }
}

TEST_CASE("light map fit: under a white map the matrix scatters what the shafts do without one") {
    for (const Medium& medium : {grey_fog, coloured_fog})
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
        parts[0].add_ray(goes_along_y, 2, 1.25f, 0.5f, std::array{0.0f, 1.0f, 2.0f, 0.0f, 3.0f}, 1);
        const LightMapMatrix t(8, false, std::move(parts), progress);
        const std::vector<vec4> radiance = product(t, texels);
        glm::dvec3 expected(0.0);
        for (const auto& [line, weight] : {std::pair{1, 1.0}, {2, 2.0}, {4, 3.0}}) {
            const double across = 1.25 + 0.5 * line, share = across - std::floor(across);
            const int low = static_cast<int>(across);
            expected += weight * (goes_along_y ? glm::mix(at(low, 2 + line), at(low + 1, 2 + line), share)
                                               : glm::mix(at(2 + line, low), at(2 + line, low + 1), share));
        }
        CHECK(glm::length(glm::dvec3(vec3(radiance[0])) - expected) < 1e-6 * glm::length(expected));
    }
}

TEST_CASE("light map fit: strokes that show a map's shafts from all sides give the map back") {
    // 12 texels a side, 4 cameras of 2,500 rays each: far more equations than unknowns.
    std::vector<Strokes> strokes;
    for (const vec3& position : {vec3(20, -9, 3), vec3(-14, 16, 9), vec3(2, -21, -4), vec3(-19, -3, 6)})
        strokes.push_back(strokes_from(position, 50));
    const Fitted made = begin_fit(grey_fog, strokes, config_of(16));
    const LightMapMatrix& t = made.fit->matrix();
    const Progress progress;
    const std::vector<vec4> known = random_colours(t.texel_count(), 9);
    const std::vector<vec4> target = product(t, known);
    LightMapSolver solver(t, target, std::vector<float>(target.size(), 1.0f), MapTexels(known.size(), vec4(1.0f)),
                          MapTexels(known.size(), vec4(1.0f)), 1e-9f);
    for (int step = 0; step < 400 && solver.step(); ++step) {
    }
    std::vector<vec4> seen(known.size(), vec4(0.0f)), squares(known.size());
    t.square_columns(std::vector<vec4>(target.size(), vec4(1.0f)), squares, progress);
    float most = 0.0f;
    for (const vec4& square : squares)
        most = std::max(most, square.x);
    double worst = 0.0;
    std::size_t determined_count = 0;
    for (std::size_t texel = 0; texel < known.size(); ++texel)
        if (squares[texel].x > 0.05f * most) { // those at the fog's corners are hardly seen
            ++determined_count;
            worst = std::max(worst, glm::length(glm::dvec3(vec3(solver.texels()[texel] - known[texel]))));
        }
    CHECK(determined_count > 60);
    CHECK(worst < 5e-3);
    CHECK(solver.history().back().residual < 1e-4);
}

TEST_CASE("light map fit: no step makes any channel's objective worse, nor a texel negative") {
    std::array strokes{strokes_from({20, -9, 3}, 40, {0.0f, 0.2f, 2.0f}),
                       strokes_from({-14, 16, 9}, 40, {1.5f, 0.0f, 0.1f})};
    for (const float regularisation : {0.0f, 1e-6f, 1e-3f, 1.0f}) {
        const Fitted made = begin_fit(grey_fog, strokes, config_of(64, regularisation));
        Progress progress;
        made.fit->iterate(60, progress);
        const std::span<const FitStep> history = made.fit->history();
        REQUIRE(history.size() > 10);
        for (std::size_t step = 1; step < history.size(); ++step)
            for (std::size_t channel = 0; channel < 3; ++channel)
                CHECK(history[step].objective[channel] <= history[step - 1].objective[channel]);
        std::size_t black_count = 0;
        for (const Rgb& texel : made.fit->map().texels) {
            CHECK(glm::all(glm::greaterThanEqual(texel, Rgb(0.0f))));
            black_count += texel.x == 0.0f;
        }
        CHECK(black_count > (regularisation < 1.0f ? 50u : 0u)); // some are held at 0: there is something to test
        CHECK(history.back().residual < 0.9 * history.front().residual);
    }
}

namespace {
/// As the matrix reads it.
std::vector<vec4> padded(const LightMap& map) {
    const std::size_t side = map.place.resolution, pitch = LightMapMatrix::pitch_of(map.place.resolution);
    std::vector<vec4> result(side * pitch, vec4(0.0f));
    for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
        result[texel / side * pitch + texel % side] = vec4(map.texels[texel], 0.0f);
    return result;
}
const std::array red_and_blue{strokes_from({20, -9, 3}, 32, {2.0f, 0.1f, 0.0f}),
                              strokes_from({-14, 16, 9}, 32, {0.1f, 0.3f, 1.5f})};
} // namespace

TEST_CASE("light map fit: what no stroke sees stays as it was, and a heavy prior keeps the rest, too") {
    Progress progress;
    const std::array one_corner{strokes_from({20, -9, 3}, 6, {4.0f, 0.0f, 0.0f})};
    LightMap current{.place = begin_fit(grey_fog, one_corner, config_of(64)).fit->map().place, .texels = {}};
    for (const vec4& texel : random_colours(64 * 64, 7))
        current.texels.emplace_back(texel);
    const Fitted made = begin_fit(grey_fog, one_corner, config_of(64, 1e-4f), current);
    made.fit->iterate(20, progress);
    const LightMap map = made.fit->map();
    REQUIRE(map.place == current.place); // it covers what is seen: it does not swim
    std::vector<vec4> seen(made.fit->matrix().texel_count());
    made.fit->matrix().multiply_transposed(std::vector<vec4>(made.fit->matrix().ray_count(), vec4(1.0f)), seen,
                                           progress);
    std::size_t unseen_count = 0, changed_count = 0;
    for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
        if (seen[texel / 64 * made.fit->matrix().pitch() + texel % 64] == vec4(0.0f)) {
            ++unseen_count;
            CHECK(map.texels[texel] == current.texels[texel]);
        } else
            changed_count += map.texels[texel] != current.texels[texel];
    CHECK(unseen_count > 500);
    CHECK(changed_count > 100);
    const Fitted held = begin_fit(grey_fog, one_corner, config_of(64, 1e6f), current);
    held.fit->iterate(20, progress);
    CHECK(relative_rms(padded(held.fit->map()), padded(current)) < 1e-4);
}

TEST_CASE("light map fit: steps taken in two calls are the steps of one") {
    Progress progress;
    const Fitted once = begin_fit(grey_fog, red_and_blue, config_of(48)),
                 twice = begin_fit(grey_fog, red_and_blue, config_of(48));
    once.fit->iterate(24, progress);
    twice.fit->iterate(8, progress);
    twice.fit->iterate(16, progress);
    CHECK(once.fit->map().texels == twice.fit->map().texels);
}

TEST_CASE("light map fit: a cancelled call leaves the map of its last whole step") {
    const Fitted made = begin_fit(grey_fog, red_and_blue, config_of(48));
    Progress progress, cancelled;
    made.fit->iterate(5, progress);
    const std::vector<Rgb> before = made.fit->map().texels;
    cancelled.cancel();
    CHECK_THROWS_AS(made.fit->iterate(5, cancelled), Cancelled);
    CHECK(made.fit->map().texels == before);
    CHECK(made.fit->history().size() == 6);
    CHECK(made.fit->iterate(5, progress));
    CHECK(made.fit->history().size() == 11);
}

TEST_CASE("light map fit: its bits do not depend on the number of threads, nor its map on the order of the strokes") {
    const auto fitted = [](std::span<const Strokes> strokes, int thread_count) {
        return with_threads(thread_count, [&] {
            Progress progress;
            const Fitted made = begin_fit(grey_fog, strokes, config_of(48, 1e-2f));
            made.fit->iterate(40, progress);
            return padded(made.fit->map());
        });
    };
    const std::vector<vec4> one = fitted(red_and_blue, 1), two = fitted(red_and_blue, 2);
    CHECK(one == two);
    std::array turned{red_and_blue[1], red_and_blue[0]};
    for (Strokes& view : turned)
        std::ranges::reverse(view.pixels);
    // Sums in another order: after 40 steps towards the same minimum.
    CHECK(relative_rms(fitted(turned, 2), one) < 1e-3);
}

TEST_CASE("light map fit: a channel's map depends on what was painted in that channel alone") {
    Progress progress;
    std::array other(red_and_blue);
    for (Strokes& view : other)
        for (StrokePixel& pixel : view.pixels)
            pixel.desired.x = 0.7f;
    const Fitted a = begin_fit(grey_fog, red_and_blue, config_of(48)), b = begin_fit(grey_fog, other, config_of(48));
    a.fit->iterate(20, progress);
    b.fit->iterate(20, progress);
    std::size_t red_differs = 0;
    for (std::size_t texel = 0; texel < a.fit->map().texels.size(); ++texel) {
        const Rgb of_a = a.fit->map().texels[texel], of_b = b.fit->map().texels[texel];
        red_differs += of_a.x != of_b.x;
        CHECK(std::abs(of_a.y - of_b.y) <= 1e-5f);
        CHECK(std::abs(of_a.z - of_b.z) <= 1e-5f);
    }
    CHECK(red_differs > 100);
}

TEST_CASE("light map fit: a heavier stroke gets closer to its colour") {
    Progress progress;
    const auto error_of_first = [&](float weight) { // where two strokes over the same pixels contradict each other
        std::array strokes{strokes_from({20, -9, 3}, 24, Rgb(2.0f)), strokes_from({20, -9, 3}, 24, Rgb(0.5f))};
        for (StrokePixel& pixel : strokes[0].pixels)
            pixel.weight = weight;
        const Fitted made = begin_fit(grey_fog, strokes, config_of(32, 1e-6f));
        made.fit->iterate(60, progress);
        const LightMapMatrix& t = made.fit->matrix();
        const std::vector<vec4> found = product(t, padded(made.fit->map())),
                                white = product(t, MapTexels(t.texel_count(), vec4(1.0f)));
        double sum = 0.0, whole = 0.0;
        for (std::size_t ray = 0; ray < t.ray_count(); ++ray)
            if (made.fit->pixel_of_ray()[ray] < t.ray_count() / 2) {
                sum += found[ray].x;
                whole += white[ray].x;
            }
        return sum / whole;
    };
    // Least squares of two contradicting equations is their weighted mean.
    CHECK(std::abs(error_of_first(1.0f) - 1.25) < 0.02);
    CHECK(std::abs(error_of_first(3.0f) - 1.625) < 0.02);
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
    const auto with_lamp = support::make_scene(
        {{.mesh = support::cube(), .material = {.name = "fog", .medium_index = 0, .has_surface = false}}}, {grey_fog},
        {{.name = "Lamp", .kind = LightKind::Point, .position = {0, 0, 3}}});
    CHECK(message_of(*with_lamp, red_and_blue) == "Light \"Lamp\" is no sun: a light map is fitted to suns only");
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
    for (std::uint32_t texel = 0; texel < place.resolution * place.resolution; ++texel) {
        const vec2 at(static_cast<float>(texel % place.resolution), static_cast<float>(texel / place.resolution));
        // Waves of some 15 texels: between texels, two ways to interpolate differ by their curvature.
        map.texels.push_back(0.5f +
                             0.4f * Rgb(std::sin(0.4f * at.x), std::cos(0.3f * at.y), std::sin(0.2f * (at.x + at.y))));
        image->floats.insert(image->floats.end(),
                             {map.texels.back().x, map.texels.back().y, map.texels.back().z, 1.0f});
    }
    SceneDescription description = made.scene->description();
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
