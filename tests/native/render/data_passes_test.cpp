// SPDX-License-Identifier: GPL-3.0-or-later
// What pixels show, by name and number, where each pixel's shares are known in closed form.
#include "core/errors.hpp"
#include "render/data_passes.hpp"
#include "render/frame.hpp"
#include "render/matte_id.hpp"
#include "support/close_to.hpp"
#include "support/scenes.hpp"
#include <bit>
#include <cmath>
#include <doctest/doctest.h>
#include <map>

namespace data_passes_test {
using namespace tyndall;
using namespace tyndall::support;
using render::DataPassConfig;
using render::Film;
using render::FrameConfig;
using render::matte_hash;
using render::matte_id;

namespace {
Camera camera_above(std::uint32_t size_px) {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.45f;
    camera.window_right = camera.window_top = 0.45f;
    camera.width_px = camera.height_px = size_px;
    return camera;
}
Material covering(const char* name, float share) {
    Material material{.name = name};
    material.constant = {.diffuse_albedo = Rgb(0.5f * share), .transparent = Rgb(1.0f - share), .emission = Rgb(share)};
    return material;
}
/// A pane that covers a quarter above another square, and nothing beside them.
std::unique_ptr<Scene> pane_over_floor() {
    return make_scene(
        {{.mesh = square(), .world_from_object = translation({0, 0, 1}), .material = covering("pane", 0.25f)},
         {.mesh = square(), .material = covering("floor", 1.0f)}},
        {}, {});
}
FrameConfig config_with(std::initializer_list<std::string_view> names, std::uint32_t samples = 4) {
    FrameConfig config;
    config.pixel_samples = samples;
    for (const std::string_view name : names)
        config.data.add(name);
    return config;
}
Film film_of(const Scene& scene, const FrameConfig& config) {
    Progress progress;
    return render::render(scene, camera_above(16), config, progress);
}
const render::NamedPlane& plane_of(const Film& film, std::string_view name) {
    for (const render::NamedPlane& plane : film.data_planes)
        if (plane.name == name)
            return plane;
    throw InvalidInput("no such plane");
}
/// Shares of a pixel by id.
std::map<float, float> matte_at(const Film& film, const std::string& kind, std::size_t pixel, int planes) {
    std::map<float, float> shares;
    for (int index = 0; index < planes; ++index) {
        const float* values = &plane_of(film, kind + "0" + std::to_string(index)).values[4 * pixel];
        for (const int rank : {0, 2})
            if (values[rank + 1] > 0.0f)
                shares[values[rank]] += values[rank + 1];
    }
    return shares;
}
constexpr std::size_t middle = 8 * 16 + 8;
} // namespace

TEST_CASE("names have the hashes of MurmurHash3_x86_32, of any length of rest") {
    CHECK(matte_hash("") == 0u);
    CHECK(matte_hash("hello") == 0x248bfa47u);
    CHECK(matte_hash("hello, world") == 0x149bbb7fu);
    CHECK(matte_hash("The quick brown fox jumps over the lazy dog") == 0x2e4ff723u);
    CHECK(matte_hash("Cube") == 0xa8fce865u);  // of a file that Cycles wrote
    CHECK(matte_hash("Plane") == 0x4159b52au); // likewise
}

TEST_CASE("no hash makes an id that is denormal, infinite or no number, and sign and mantissa stay") {
    for (const std::uint32_t hash :
         {0u, 0x80000000u, 0x7f800000u, 0xff812345u, 0x00012345u, 0x3f800000u, 0xa8fce865u}) {
        const float id = matte_id(hash);
        CHECK(std::isnormal(id));
        CHECK((std::bit_cast<std::uint32_t>(id) & 0x807fffffu) == (hash & 0x807fffffu));
    }
    CHECK(std::bit_cast<std::uint32_t>(matte_id(0xa8fce865u)) == 0xa8fce865u);
}

TEST_CASE("layers share a pixel by what each covers, and the largest share comes first") {
    const auto scene = pane_over_floor();
    const Film film = film_of(*scene, config_with({"CryptoMaterial"}));
    const auto shares = matte_at(film, "CryptoMaterial", middle, 3);
    REQUIRE(shares.size() == 2);
    CHECK(shares.at(matte_id("pane")) == close_to(0.25, 1e-5));
    CHECK(shares.at(matte_id("floor")) == close_to(0.75, 1e-5));
    CHECK(plane_of(film, "CryptoMaterial00").values[4 * middle] == matte_id("floor"));
}

TEST_CASE("mattes of a picture add up to its alpha") {
    const auto scene = pane_over_floor();
    FrameConfig config = config_with({"CryptoObject"}, 16);
    config.is_film_transparent = true;
    const Film film = film_of(*scene, config);
    const std::vector<float>& combined = film.find(render::Pass::Combined)->values;
    for (std::size_t pixel = 0; pixel < 256; ++pixel) {
        double sum = 0.0;
        for (const auto& [id, share] : matte_at(film, "CryptoObject", pixel, 3))
            sum += share;
        REQUIRE(sum == close_to(combined[4 * pixel + 3], 1e-5));
    }
}

TEST_CASE("more names than ranks: the last rank takes what is left, and nothing is lost") {
    std::vector<Part> parts;
    for (int index = 0; index < 5; ++index)
        parts.push_back({.mesh = square(),
                         .world_from_object = translation({0, 0, -0.1f * static_cast<float>(index)}),
                         .material = covering(("layer " + std::to_string(index)).c_str(), index < 4 ? 0.4f : 1.0f)});
    const auto scene = make_scene(parts, {}, {});
    FrameConfig config = config_with({"CryptoMaterial"});
    config.data.matte_ranks = 3; // rounded up to 4: two planes
    const Film film = film_of(*scene, config);
    CHECK(film.data_planes.size() == 2);
    const auto shares = matte_at(film, "CryptoMaterial", middle, 2);
    CHECK(shares.size() == 4);
    double sum = 0.0;
    for (const auto& [id, share] : shares)
        sum += share;
    CHECK(sum == close_to(1.0, 1e-5));
    CHECK(shares.at(matte_id("layer 0")) == close_to(0.4, 1e-5));
}

TEST_CASE("assets and indices go by the names that they are given for") {
    const auto scene = pane_over_floor();
    FrameConfig config = config_with({"CryptoAsset", "IndexMA", "CryptoMaterial"});
    for (const std::string& name : scene->description().object_names)
        config.data.asset_of[name] = "house";
    config.data.material_index["floor"] = 7.0f;
    config.data.material_alias["pane"] = "window";
    const Film film = film_of(*scene, config);
    const auto assets = matte_at(film, "CryptoAsset", middle, 3);
    REQUIRE(assets.size() == 1);
    CHECK(assets.at(matte_id("house")) == close_to(1.0, 1e-5));
    CHECK(plane_of(film, "IndexMA").values[middle] == 7.0f); // the pane covers less than half
    CHECK(matte_at(film, "CryptoMaterial", middle, 3).count(matte_id("window")) == 1);
}

TEST_CASE("mist rises with the distance of what covers, from 0 at its start to 1 at its end and beyond") {
    const auto scene = make_scene({{.mesh = square(), .material = covering("floor", 1.0f)}}, {}, {});
    FrameConfig config = config_with({"Mist"}, 1);
    const auto mist = [&](float start_m, float depth_m, float exponent) {
        config.data.mist = {.start_m = start_m, .depth_m = depth_m, .exponent = exponent};
        return plane_of(film_of(*scene, config), "Mist").values;
    };
    // A pixel in the middle of 16 is off the axis by half a pixel.
    const double side = 0.5 * 0.9 / 16, distance_m = 5.0 * std::sqrt(1.0 + 2.0 * side * side);
    CHECK(mist(4, 4, 1.0f)[middle] == close_to((distance_m - 4) / 4, 1e-5));
    CHECK(mist(4, 4, 2.0f)[middle] == close_to(std::pow((distance_m - 4) / 4, 2), 1e-5));
    CHECK(mist(6, 4, 1.0f)[middle] == 0.0f);
    CHECK(mist(1, 2, 2.0f)[middle] == 1.0f);
    CHECK(mist(6, 0, 2.0f)[middle] == 0.0f);
}

TEST_CASE("the picture has the same bits with data passes and without, and they on one thread and on four") {
    const auto scene = pane_over_floor();
    FrameConfig config = config_with({}, 16);
    const Film plain = film_of(*scene, config);
    CHECK(plain.data_planes.empty());
    config = config_with({"CryptoObject", "CryptoMaterial", "CryptoAsset", "IndexOB", "UV", "Mist"}, 16);
    config.thread_count = 1;
    const Film one = film_of(*scene, config);
    config.thread_count = 4;
    const Film four = film_of(*scene, config);
    CHECK(one.find(render::Pass::Combined)->values == plain.find(render::Pass::Combined)->values);
    REQUIRE(one.data_planes.size() == 3 * 3 + 3);
    for (std::size_t index = 0; index < one.data_planes.size(); ++index)
        CHECK(one.data_planes[index].values == four.data_planes[index].values);
}

TEST_CASE("a region of the frame is a crop of it in its data passes, too") {
    const auto scene = pane_over_floor();
    FrameConfig config = config_with({"CryptoMaterial"}, 16);
    const Film whole = film_of(*scene, config);
    config.region = render::Region{3, 2, 13, 15};
    const Film part = film_of(*scene, config);
    const std::vector<float>& of_whole = plane_of(whole, "CryptoMaterial00").values;
    const std::vector<float>& of_part = plane_of(part, "CryptoMaterial00").values;
    REQUIRE(of_part.size() == 4 * 10 * 13);
    for (std::size_t y = 0; y < 13; ++y)
        for (std::size_t value = 0; value < 40; ++value)
            REQUIRE(of_part[y * 40 + value] == of_whole[(y + 2) * 64 + 12 + value]);
}

TEST_CASE("settings out of their range are refused by name") {
    const auto scene = pane_over_floor();
    FrameConfig config = config_with({"CryptoObject"});
    config.data.matte_ranks = 17;
    CHECK_THROWS_AS(film_of(*scene, config), InvalidInput);
    CHECK_THROWS_AS(config.data.add("Crypto"), InvalidInput);
}
} // namespace data_passes_test
