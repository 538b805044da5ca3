// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces and media that media light, which glow: furnaces, and what stands between.
#include "render/indirect_light.hpp"
#include "support/whole_and_part.hpp"
#include <doctest/doctest.h>

namespace media_glow_test {
using namespace tyndall;
using namespace tyndall::support;
using render::FrameConfig;

namespace {
const Rgb glow(0.2f, 0.1f, 0.05f), absorption(0.1f, 0.2f, 0.4f), albedo(0.25f, 0.5f, 0.75f);

FrameConfig samples(std::uint32_t count) {
    FrameConfig config;
    config.pixel_samples = count;
    return config;
}

/// Parts in air that fills the world.
Rgb seen_in_glowing_air(const std::vector<Part>& parts, std::vector<ScatterLobe> lobes = {}) {
    const Medium air{
        .name = "glow", .lobes = std::move(lobes), .sigma_a_per_m = absorption, .emission_w_per_m3_sr = glow};
    SceneDescription description = description_of(*make_scene(parts, {air}));
    description.world_medium_index = 0;
    const Scene scene(std::move(description), Progress());
    return pixel(film_of(scene, camera_on(vec3(0.0f), 0.05f), samples(4096)));
}
} // namespace

// Wherever one looks from within, endless air shows emission over absorption. Seen to fail where no ray asks for it, and
// where its own light on the floor goes to the viewer undimmed.
TEST_CASE("a floor of albedo a in endless air that glows shows a times what that shows everywhere") {
    const Rgb everywhere = glow / absorption;
    const Rgb found = seen_in_glowing_air({floor_at(vec3(0.0f), 1e4f, diffuse(albedo))});
    const Rgb none = seen_in_glowing_air({floor_at(vec3(0.0f), 1e4f, diffuse(Rgb(0.0f)))});
    const Rgb passing = 1.0f - none / everywhere; // the air before a black floor
    CHECK(relative_error(found - none, passing * albedo * everywhere) < 1e-2);
}

// Seen to fail where no draw asks for what media emit.
TEST_CASE(
    "endless air that glows and scatters shows itself, and what of that it scatters once, whichever way it does") {
    const Rgb scattering(0.3f, 0.1f, 0.2f), sigma_t = absorption + scattering, everywhere = glow / sigma_t;
    for (const float anisotropy : {0.0f, 0.7f}) {
        const Rgb found = seen_in_glowing_air({}, {{scattering, anisotropy}});
        CHECK(relative_error(found, everywhere * (1.0f + scattering / sigma_t)) < 1e-2);
    }
}

TEST_CASE("what stands near a floor hides the air behind it, and glass as clear as c lets c of that pass") {
    const float height = 1e-3f;
    const auto below = [&](const Rgb& clear) {
        Part lid{.mesh = disc(100.0f),
                 .world_from_object = translation({0, 0, height}),
                 .material = diffuse(Rgb(0.0f), Rgb(0.0f))};
        lid.material.constant.transparent = clear;
        lid.is_camera_visible = false;
        const Rgb none = seen_in_glowing_air({floor_at(vec3(0.0f), 1e4f, diffuse(Rgb(0.0f))), lid});
        return seen_in_glowing_air({floor_at(vec3(0.0f), 1e4f, diffuse(albedo)), lid}) - none;
    };
    const Rgb closed = below(Rgb(0.0f)), half = below(Rgb(0.5f)), open = below(Rgb(1.0f));
    CHECK(relative_error(closed + Rgb(1.0f), Rgb(1.0f)) < 0.01);
    CHECK(relative_error(half, 0.5f * open) < 0.02);
    CHECK(open.x > 0.1f);
}
} // namespace media_glow_test
