// SPDX-License-Identifier: GPL-3.0-or-later
// The strata of a light with a size are dealt out to the samples of a pixel and to neighbouring pixels: no pass pays for
// all, together they have all.
#include "core/simd.hpp"
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/shared_strata.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <random>

namespace turns_test {
using namespace tyndall;
using namespace tyndall::support;

/// A soft lamp over a small blocker in fog: every stratum makes another picture.
struct SoftLamp {
    Progress progress;
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Media> media;
    light_shafts::Config config{.method = light_shafts::Method::Exact};
    light_shafts::View view{.is_orthographic = false, .position = {0, -4, 0}};
    std::vector<light_shafts::ViewRay> rays;

    explicit SoftLamp(std::uint32_t light_samples, bool is_spot = false) {
        Material fog{.name = "fog"};
        fog.has_surface = false;
        fog.medium_index = 0;
        const Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = {0.1f, 0.2f, 0.3f}, .asymmetry_g = 0.5f}}};
        Light lamp;
        lamp.name = "Lamp";
        lamp.kind = LightKind::Point;
        lamp.position = {0.3f, 0.2f, 3.0f};
        lamp.radius_m = 0.5f;
        if (is_spot)
            lamp.kind = LightKind::Spot, lamp.spot_axis = {0, 0, -1};
        scene =
            make_scene({{.mesh = cube(), .material = fog},
                        {.mesh = square(), .world_from_object = glm::scale(translation({0.2f, 0, 1.5f}), vec3(0.4f))}},
                       {medium}, {lamp});
        media = std::make_unique<Media>(*scene, progress);
        config.light_samples = light_samples;
        for (const float x : {-0.15f, 0.0f, 0.1f})
            rays.push_back({view.position, glm::normalize(vec3(x, 1, 0.05f)), 0.0f, 10.0f});
    }
    [[nodiscard]] light_shafts::Shafts shafts() { return {*scene, *media, view, rays, config, progress}; }
};

TEST_CASE("the mean over all turns is the light of all strata, whatever both numbers are") {
    SoftLamp lamp(7);
    const auto& rays = lamp.rays;
    Progress& progress = lamp.progress;
    const light_shafts::Shafts shafts = lamp.shafts();
    std::vector<Rgb> truth(rays.size());
    std::vector<float> true_visibility(rays.size());
    shafts.scatter(rays, truth, true_visibility, progress);
    for (const std::uint32_t count : {1u, 2u, 3u, 6u, 7u, 8u, 14u, 17u}) {
        CAPTURE(count);
        std::vector<glm::dvec3> sum(rays.size(), glm::dvec3(0.0));
        std::vector<double> visibility_sum(rays.size());
        for (std::uint32_t index = 0; index < count; ++index) {
            std::vector<Rgb> radiance(rays.size());
            std::vector<float> visibility(rays.size());
            shafts.scatter(rays, radiance, visibility, progress, {index, count});
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                sum[ray] += glm::dvec3(radiance[ray]) / double(count);
                visibility_sum[ray] += visibility[ray] / double(count);
            }
        }
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
            CHECK(glm::length(sum[ray] - glm::dvec3(truth[ray])) < 1e-6 * glm::length(glm::dvec3(truth[ray])));
            CHECK(std::abs(visibility_sum[ray] - true_visibility[ray]) < 1e-6);
        }
    }
    std::vector<Rgb> radiance(rays.size());
    CHECK_THROWS_AS(shafts.scatter(rays, radiance, {}, progress, {3, 3}), InvalidInput);
}

TEST_CASE(
    "the mean over a square of pixels and all turns is the light of all strata: no cell pays for its neighbours") {
    for (const std::uint32_t strata : {4u, 7u, 16u, 40u}) {
        SoftLamp lamp(strata);
        lamp.rays[0].direction = glm::normalize(vec3(-0.22f, 1, 0.05f)); // half in the blocker's shadow
        const light_shafts::Shafts shafts = lamp.shafts();
        Rgb truth[1];
        const auto ray = std::span(lamp.rays).first(1);
        shafts.scatter(ray, truth, {}, lamp.progress);
        // One view ray, sixteen times: the pixels of a square of 4 x 4 that all see the same.
        const std::vector<light_shafts::ViewRay> square(16, lamp.rays[0]);
        std::vector<std::uint8_t> cells;
        for (std::uint32_t pixel = 0; pixel < 16; ++pixel)
            cells.push_back(light_shafts::cell_of_pixel(pixel % 4, pixel / 4));
        for (const std::uint32_t turns : {1u, 2u, 4u, 5u}) {
            CAPTURE(strata);
            CAPTURE(turns);
            glm::dvec3 sum(0.0);
            std::size_t shared_count = 0;
            for (std::uint32_t turn = 0; turn < turns; ++turn) {
                std::array<std::vector<Rgb>, light_shafts::shared_sides.size()> radiance;
                std::array<light_shafts::Scattered, light_shafts::shared_sides.size()> out;
                for (std::size_t side = 0; side < out.size(); ++side) {
                    radiance[side].resize(square.size());
                    out[side].radiance = radiance[side];
                }
                shafts.scatter(square, cells, out, lamp.progress, {turn, turns});
                for (std::size_t side = 0; side < out.size(); ++side)
                    for (const Rgb& value : radiance[side]) {
                        sum += glm::dvec3(value) / (16.0 * turns);
                        shared_count += side > 0 && value != Rgb(0.0f) ? 1 : 0;
                    }
            }
            CHECK((shared_count > 0) == (strata >= 2 * turns));
            CHECK(glm::length(sum - glm::dvec3(truth[0])) < 1e-6 * glm::length(glm::dvec3(truth[0])));
        }
    }
}

TEST_CASE("a pixel takes in every cell of the square once, and nothing from where the rays end elsewhere") {
    constexpr std::uint32_t width = 13, height = 11;
    Progress progress;
    std::vector<std::uint32_t> first_ray{0};
    std::vector<light_shafts::Air> air;
    std::vector<std::uint8_t> cells;
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
        // Two columns of rays end far behind the others; pixel (5, 5) has no ray.
        const bool is_far = pixel % width >= 11;
        if (pixel != 5 * width + 5)
            air.push_back({0.0f, is_far ? 50.0f : 10.0f + 0.01f * float(pixel % 7), 0.5f});
        // Pixel (2, 3) shares nothing.
        cells.resize(air.size(), pixel == 3 * width + 2 ? light_shafts::alone_cell : 0);
        first_ray.push_back(static_cast<std::uint32_t>(air.size()));
    }
    for (const std::uint32_t side : {2u, 4u})
        for (std::uint32_t cell = 0; cell < side * side; ++cell) {
            std::vector<Rgb> shared(air.size(), Rgb(0.0f)), sum(air.size(), Rgb(0.0f));
            std::vector<float> visibility(air.size(), 0.25f), visibility_sum(air.size(), 0.5f);
            for (std::uint32_t pixel = 0; pixel < width * height; ++pixel)
                if (first_ray[pixel] < first_ray[pixel + 1]) {
                    const bool is_far = pixel % width >= 11;
                    const std::uint32_t of_pixel = light_shafts::cell_of_pixel(pixel % width, pixel / width);
                    const bool is_mine = of_pixel * side * side / 16 == cell;
                    const bool is_alone = cells[first_ray[pixel]] == light_shafts::alone_cell;
                    shared[first_ray[pixel]] = Rgb(is_far || is_alone ? 100.0f : is_mine ? 1.0f : 0.0f);
                }
            light_shafts::add_shared({width, height, first_ray, air, cells}, side, 0, height,
                                     {shared, visibility, {}, {}}, {sum, visibility_sum, {}, {}}, progress);
            const auto at = [&](std::uint32_t x, std::uint32_t y) { return sum[first_ray[y * width + x]].x; };
            CHECK(std::abs(at(2, 8) - 1.0f / float(side * side)) < 1e-6f);
            CHECK(std::abs(at(8, 7) - 1.0f / float(side * side)) < 1e-6f);
            CHECK(at(10, 3) <= 1.0f);   // beside the far rays
            CHECK(at(12, 3) == 100.0f); // among them, at the picture's border
            CHECK(at(2, 3) == 0.0f);    // alone
            CHECK(at(3, 3) <= 1.0f);    // beside it
            for (std::size_t ray = 0; ray < air.size(); ++ray)
                CHECK(std::abs(visibility_sum[ray] - (cells[ray] == 0 ? 0.75f : 0.5f)) < 1e-6f);
        }
}

TEST_CASE("lines of pixels are shared as pixels one by one are, whatever their air, on each instruction set") {
    constexpr std::uint32_t width = 53, height = 21;
    std::mt19937 random(7);
    const auto number = [&] { return std::uniform_real_distribution<float>(0.0f, 1.0f)(random); };
    const auto colour = [&] { return Rgb(number(), number(), number()); };
    struct Picture {
        std::vector<std::uint32_t> first_ray{0};
        std::vector<light_shafts::Air> air;
        std::vector<std::uint8_t> cells;
        std::vector<Rgb> shared, patterned, unshadowed;
        std::vector<float> visibility;
    } one, two; // the same, with a ray more in each pixel, which shares nothing
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
        const float far_m = number() < 0.1f ? std::numeric_limits<float>::infinity() : number() < 0.3f ? 5.0f : 50.0f;
        const light_shafts::Air air{0.1f * number(), far_m * (1.0f + 0.1f * number()), number() - 0.1f};
        const bool has_ray = number() > 0.1f, is_alone = number() < 0.1f;
        const Rgb shared = colour(), patterned = colour(), unshadowed = number() < 0.5f ? Rgb(0.0f) : colour();
        const float visibility = number();
        const auto add = [&](Picture& picture, const light_shafts::Air& of_ray) {
            picture.air.push_back(of_ray);
            picture.cells.push_back(is_alone ? light_shafts::alone_cell : 0);
            picture.shared.push_back(shared), picture.patterned.push_back(patterned);
            picture.unshadowed.push_back(unshadowed), picture.visibility.push_back(visibility);
        };
        if (has_ray)
            add(one, air), add(two, {air.near_m, air.far_m, 0.0f}), add(two, air);
        one.first_ray.push_back(static_cast<std::uint32_t>(one.air.size()));
        two.first_ray.push_back(static_cast<std::uint32_t>(two.air.size()));
    }
    Progress progress;
    for (const SimdTarget target : available_simd_targets())
        for (const std::uint32_t side : {2u, 4u})
            for (const bool has_patterned : {false, true}) {
                const ForcedSimdTarget forced(target);
                CAPTURE(simd_target_name());
                CAPTURE(side);
                const auto shared_of = [&](const Picture& picture, std::vector<Rgb>& sum, std::vector<float>& visible) {
                    const auto apart = [&](const std::vector<Rgb>& values) {
                        return has_patterned ? std::span(values) : std::span<const Rgb>();
                    };
                    sum.assign(picture.air.size(), Rgb(0.25f));
                    visible.assign(picture.air.size(), 0.5f);
                    light_shafts::add_shared(
                        {width, height, picture.first_ray, picture.air, picture.cells}, side, 0, height,
                        {picture.shared, picture.visibility, apart(picture.patterned), apart(picture.unshadowed)},
                        {sum, visible, {}, {}}, progress);
                };
                std::vector<Rgb> by_lines, by_rays;
                std::vector<float> visible_by_lines, visible_by_rays;
                shared_of(one, by_lines, visible_by_lines);
                shared_of(two, by_rays, visible_by_rays);
                double shared_sum = 0.0;
                for (std::size_t ray = 0; ray < one.air.size(); ++ray) {
                    CHECK(glm::length(by_lines[ray] - by_rays[2 * ray + 1]) <= 1e-5f * glm::length(by_lines[ray]));
                    CHECK(std::abs(visible_by_lines[ray] - visible_by_rays[2 * ray + 1]) <= 1e-6f);
                    shared_sum += by_lines[ray].x - 0.25f;
                }
                CHECK(shared_sum > 0.2 * width * height);
            }
}

TEST_CASE("where light is in proportion to the opacity of the air, sharing changes nothing: a cloud keeps its rim") {
    constexpr std::uint32_t width = 9, height = 9;
    Progress progress;
    std::vector<std::uint32_t> first_ray{0};
    std::vector<light_shafts::Air> air;
    std::vector<Rgb> shared;
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
        const float opacity = pixel % width < 3 ? 0.0f : 0.1f * float(pixel % width);
        air.push_back({2.0f, 2.0f + 0.1f * opacity, opacity});
        shared.push_back(3.0f * Rgb(opacity));
        first_ray.push_back(pixel + 1);
    }
    const std::vector<std::uint8_t> cells(air.size(), 0);
    std::vector<Rgb> sum(air.size(), Rgb(0.0f));
    light_shafts::add_shared({width, height, first_ray, air, cells}, 4, 0, height, {shared, {}, {}, {}},
                             {sum, {}, {}, {}}, progress);
    for (std::size_t ray = 0; ray < air.size(); ++ray)
        CHECK(glm::length(sum[ray] - shared[ray]) <= 1e-6f * glm::length(shared[ray]));
}

TEST_CASE("where a light at a point is equally lit, sharing changes nothing: a beam keeps its edge and each colour") {
    constexpr std::uint32_t width = 9, height = 9;
    Progress progress;
    std::vector<std::uint32_t> first_ray{0};
    std::vector<Rgb> lit, unshadowed;
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
        unshadowed.push_back(pixel % width < 4 ? Rgb(0.0f) : Rgb(1.0f, float(pixel / width), 0.01f * float(pixel)));
        lit.push_back(Rgb(0.5f, 0.25f, 1.0f) * unshadowed.back());
        first_ray.push_back(pixel + 1);
    }
    const std::vector<light_shafts::Air> air(lit.size(), light_shafts::Air{2.0f, 3.0f, 0.5f});
    const std::vector<std::uint8_t> cells(lit.size(), 0);
    const std::vector<Rgb> none(lit.size(), Rgb(0.0f));
    std::vector<Rgb> sum = none;
    light_shafts::add_shared({width, height, first_ray, air, cells}, 2, 0, height, {none, {}, lit, unshadowed},
                             {sum, {}, {}, {}}, progress);
    for (std::size_t ray = 0; ray < lit.size(); ++ray)
        CHECK(glm::length(sum[ray] - lit[ray]) <= 1e-6f * glm::length(lit[ray]));
    // In squares of 4 the edge itself is one of several strata: a pixel to each side.
    sum = none;
    light_shafts::add_shared({width, height, first_ray, air, cells}, 4, 0, height, {none, {}, lit, unshadowed},
                             {sum, {}, {}, {}}, progress);
    for (std::uint32_t y = 1; y + 1 < height; ++y)
        for (std::uint32_t x = 0; x + 1 < width; ++x) {
            const Rgb &here = lit[y * width + x], &found = sum[y * width + x];
            if (x < 3 || x > 4)
                CHECK(glm::length(found - here) <= 1e-6f * glm::length(here));
            else
                CHECK(glm::length(found - (x == 3 ? 0.25f : 0.75f) * lit[y * width + 5]) < 0.02f);
        }
}

// Of the cone of a small lamp the pixels' own strata tell where its edge is; else they are noise, up to a fifth of the light
// here: where there is no cone, and where each stratum of a lamp many pixels wide has an edge of its own.
TEST_CASE(
    "pixels that share a lamp each have the light of all of its strata, but for a cone that these have in common") {
    constexpr std::uint32_t width = 12, turns = 4;
    constexpr float spacing_rad = 5e-4f; // a lamp 400 pixels wide
    for (const auto& [is_spot, times_as_far_apart] :
         {std::pair{false, 200.0f}, std::pair{true, 200.0f}, std::pair{true, 1.0f}}) {
        const bool keeps_edge = is_spot && times_as_far_apart > 1.0f;
        SoftLamp lamp(64, is_spot);
        lamp.view.spacing = times_as_far_apart * spacing_rad;
        lamp.rays.clear();
        std::vector<std::uint8_t> cells;
        std::vector<std::uint32_t> first_ray{0};
        for (std::uint32_t pixel = 0; pixel < width * width; ++pixel) {
            const vec2 at(pixel % width, pixel / width);
            lamp.rays.push_back({lamp.view.position,
                                 glm::normalize(vec3(spacing_rad * at.x - 0.2f, 1.0f, spacing_rad * at.y)), 0.0f,
                                 10.0f});
            cells.push_back(light_shafts::cell_of_pixel(pixel % width, pixel / width));
            first_ray.push_back(pixel + 1);
        }
        const light_shafts::Shafts shafts = lamp.shafts();
        const std::vector<light_shafts::Air> air = shafts.find_air(lamp.rays, lamp.progress);
        std::vector<Rgb> truth(lamp.rays.size()), sum(lamp.rays.size(), Rgb(0.0f));
        shafts.scatter(lamp.rays, truth, {}, lamp.progress);
        double apart = 0.0;
        for (std::uint32_t turn = 0; turn < turns; ++turn) {
            using Light = std::vector<Rgb>;
            std::array<std::array<Light, 3>, light_shafts::shared_sides.size()> light;
            std::array<light_shafts::Scattered, light_shafts::shared_sides.size()> out;
            for (std::size_t side = 0; side < out.size(); ++side) {
                for (Light& values : light[side])
                    values.assign(lamp.rays.size(), Rgb(0.0f));
                out[side] = {light[side][0], {}, light[side][1], light[side][2]};
            }
            shafts.scatter(lamp.rays, cells, out, lamp.progress, {turn, turns});
            for (std::size_t side = 1; side < out.size(); ++side)
                light_shafts::add_shared({width, width, first_ray, air, cells}, light_shafts::shared_sides[side], 0,
                                         width, {light[side][0], {}, light[side][1], light[side][2]}, {sum, {}, {}, {}},
                                         lamp.progress);
            for (const auto& [radiance, patterned, unshadowed] : light)
                for (const Rgb& value : patterned)
                    apart += value.x;
        }
        CHECK((apart > 0.0) == keeps_edge);
        for (std::uint32_t y = 2; !keeps_edge && y + 2 < width; ++y)
            for (std::uint32_t x = 2; x + 2 < width; ++x) {
                const std::size_t pixel = y * width + x;
                CHECK(std::abs(sum[pixel].x / (static_cast<float>(turns) * truth[pixel].x) - 1.0f) < 0.01f);
            }
    }
}

TEST_CASE("rays that pass close to a lamp share nothing and ask for all strata themselves") {
    SoftLamp lamp(16);
    const light_shafts::Shafts shafts = lamp.shafts();
    const vec3 at_lamp = glm::normalize(vec3(0.3f, 0.2f, 3.0f) - lamp.view.position);
    constexpr float spacing_rad = 0.001f;
    lamp.view.spacing = spacing_rad;
    std::vector<light_shafts::ViewRay> rays;
    for (const float spacings : {0.0f, 4.0f, 7.5f, 8.5f, 100.0f})
        rays.push_back({lamp.view.position, glm::normalize(at_lamp + vec3(spacings * spacing_rad, 0, 0)), 0.0f, 10.0f});
    rays.push_back({lamp.view.position, -at_lamp, 0.0f, 10.0f}); // the lamp is behind
    std::vector<std::uint8_t> cells(rays.size(), 3);
    shafts.set_alone(rays, lamp.view, 16, cells, lamp.progress);
    for (const std::uint8_t cell : cells)
        CHECK(cell == 3); // as many passes as strata: nothing is shared
    shafts.set_alone(rays, lamp.view, 1, cells, lamp.progress);
    CHECK(cells == std::vector<std::uint8_t>{255, 255, 255, 3, 3, 3});

    std::vector<Rgb> truth(3);
    shafts.scatter(lamp.rays, truth, {}, lamp.progress);
    const std::vector<std::uint8_t> alone(3, light_shafts::alone_cell);
    std::array<std::vector<Rgb>, light_shafts::shared_sides.size()> radiance;
    std::array<light_shafts::Scattered, light_shafts::shared_sides.size()> out;
    for (std::size_t side = 0; side < out.size(); ++side) {
        radiance[side].resize(3);
        out[side].radiance = radiance[side];
    }
    shafts.scatter(lamp.rays, alone, out, lamp.progress, {0, 1});
    for (std::size_t ray = 0; ray < 3; ++ray) {
        CHECK(radiance[0][ray] == truth[ray]);
        CHECK(radiance[1][ray] + radiance[2][ray] == Rgb(0.0f));
    }
}
} // namespace turns_test
