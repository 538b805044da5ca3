// SPDX-License-Identifier: GPL-3.0-or-later
// Where the picture before a light lies.
#include "core/errors.hpp"
#include "scene/light_axes.hpp"
#include "scene/light_texture.hpp"
#include "support/area_lights.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace light_texture_test {
using namespace tyndall;

static std::shared_ptr<const FilteredTexture> grey() {
    auto texture = std::make_shared<Texture>();
    texture->width = texture->height = 1;
    texture->floats = {0.5f, 0.5f, 0.5f, 1.0f};
    return std::make_shared<const FilteredTexture>(texture);
}
static Light textured(LightKind kind, LightTexture texture) {
    Light light{.name = "light", .kind = kind, .position = {1, 2, 3}};
    texture.image = grey();
    light.texture = std::make_shared<const LightTexture>(texture);
    return light;
}

TEST_CASE("a gobo's middle is on the line through the sun's origin, and it goes and turns with the sun") {
    for (const float turn_rad : {0.0f, 0.7f}) {
        Light sun = textured(LightKind::Sun, {.size_m = {4.0f, 2.0f}});
        const mat3 world_from_light = mat3(glm::rotate(mat4(1.0f), turn_rad, glm::normalize(vec3(1, 2, 3))));
        sun.light_from_world_directions = glm::transpose(world_from_light);
        sun.towards_light = world_from_light[2];
        const auto uv = [&](const vec3& in_light) {
            return texture_uv(sun, sun.position, sun.position + world_from_light * in_light);
        };
        CHECK(glm::length(uv({0, 0, 0}) - vec2(0.5f)) < 1e-6f);
        CHECK(glm::length(uv({0, 0, -70}) - vec2(0.5f)) < 1e-5f);
        CHECK(glm::length(uv({2, 0, 5}) - vec2(1.0f, 0.5f)) < 1e-5f);
        CHECK(glm::length(uv({0, -1, 0}) - vec2(0.5f, 0.0f)) < 1e-5f);
        LightTexture moved = *sun.texture;
        moved.centre_m = {1.0f, -0.5f};
        sun.texture = std::make_shared<const LightTexture>(moved);
        CHECK(glm::length(uv({1, -0.5f, 3}) - vec2(0.5f)) < 1e-5f);
    }
}
TEST_CASE("a slide is thrown: what is twice as far is twice as large") {
    const Light spot = textured(LightKind::Spot, {.projection = LightProjection::Perspective});
    const vec2 near_uv = texture_uv(spot, spot.position, spot.position + vec3(0.1f, 0.2f, -1.0f));
    const vec2 far_uv = texture_uv(spot, spot.position, spot.position + vec3(0.2f, 0.4f, -2.0f));
    CHECK(glm::length(near_uv - vec2(-0.1f, -0.2f)) < 1e-6f);
    CHECK(glm::length(near_uv - far_uv) < 1e-6f);
}
TEST_CASE("a sphere that emits shows its picture by its normal, a disc by the way the light goes") {
    Light lamp = textured(LightKind::Point, {.projection = LightProjection::Direct, .follows_normal = true});
    lamp.radius_m = 0.5f;
    const vec3 emitter = lamp.position + vec3(0.0f, 0.5f, 0.0f), point = emitter + vec3(3.0f, 0.0f, 4.0f);
    CHECK(glm::length(texture_uv(lamp, emitter, point) - vec2(0.0f, 1.0f)) < 1e-6f);
    lamp.body = LightBody::FacingDisc;
    CHECK(glm::length(texture_uv(lamp, emitter, point) - vec2(0.6f, 0.0f)) < 1e-6f);
}
TEST_CASE("on a sphere the picture's middle row is the horizon, and its upper edge the zenith") {
    const Light lamp = textured(LightKind::Point, {.projection = LightProjection::Sphere});
    const auto uv = [&](const vec3& way) { return texture_uv(lamp, lamp.position, lamp.position + way); };
    CHECK(glm::length(uv({0, 1, 0}) - vec2(0.5f, 0.5f)) < 1e-6f);
    CHECK(glm::length(uv({1, 0, 0}) - vec2(0.25f, 0.5f)) < 1e-6f);
    CHECK(std::abs(uv({0, 0, 2}).y - 1.0f) < 1e-6f);
    CHECK(std::abs(uv({0, 0, -2}).y) < 1e-6f);
}
TEST_CASE("offset and gain mix the picture's channels; a light without one stays white") {
    LightTexture texture{.offset = {0.1f, 0.0f, 0.0f}, .gain = mat3(vec3(1, 0, 0), vec3(1, 0, 0), vec3(0, 0, 2))};
    Light lamp = textured(LightKind::Sun, texture);
    CHECK(glm::length(texture_colour(lamp, vec3(0.0f), vec3(0.0f)) - Rgb(1.1f, 0.0f, 1.0f)) < 1e-6f);
    lamp.texture = nullptr;
    CHECK(texture_colour(lamp, vec3(0.0f), vec3(0.0f)) == Rgb(1.0f));
}
TEST_CASE("a picture that cannot be laid out is named") {
    const auto with = [](auto change) {
        LightTexture texture{.image = grey()};
        change(texture);
        require_usable(texture);
    };
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_NOTHROW(with([](LightTexture&) {}));
    CHECK_THROWS_WITH_AS(with([](LightTexture& t) { t.image = nullptr; }), "it has no image", InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.size_m.x = 0.0f; }), InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.size_m.y = nan; }), InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.centre_m.x = nan; }), InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.place_from_axes[3].y = nan; }), InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.gain[1].z = nan; }), InvalidInput);
    CHECK_THROWS_AS(with([](LightTexture& t) { t.projection = static_cast<LightProjection>(9); }), InvalidInput);
}
TEST_CASE(
    "a picture on an area light goes from corner to corner of it, wherever it stands, and has the mean of its parts") {
    Light panel = support::area_light({0.6f, 0.2f});
    auto halves = std::make_shared<Texture>();
    halves->width = 8, halves->height = 2;
    halves->extension = TextureExtension::Extend;
    std::vector<float> texels;
    for (int texel = 0; texel < 16; ++texel) {
        const float value = texel % 8 < 4 ? 0.0f : 1.0f;
        texels.insert(texels.end(), {value, 0.5f, 1.0f - value, 1.0f});
    }
    halves->floats = std::move(texels);
    LightTexture texture{.image = std::make_shared<const FilteredTexture>(halves),
                         .projection = LightProjection::Emitter,
                         .gain = mat3(2.0f)};
    panel.texture = std::make_shared<const LightTexture>(texture);
    const mat3 axes = light_axes(panel);
    const auto place = [&](float x, float y) { return panel.position + x * axes[0] + y * axes[1]; };
    const auto uv = [&](float x, float y) { return texture_uv(panel, place(x, y), vec3(9.0f)); };
    CHECK(glm::length(uv(-0.6f, -0.2f) - vec2(0.0f)) < 1e-6f);
    CHECK(glm::length(uv(0.6f, 0.1f) - vec2(1.0f, 0.75f)) < 1e-6f);
    CHECK(glm::length(texture_colour(panel, place(-0.5f, 0.0f), vec3(9.0f)) - Rgb(0, 1, 2)) < 1e-6f);
    CHECK(glm::length(texture_colour(panel, place(0.5f, 0.0f), vec3(9.0f)) - Rgb(2, 1, 0)) < 1e-6f);
    CHECK(glm::length(mean_colour(panel, place(0.5f, 0.1f), 1) - Rgb(1.0f)) < 1e-6f);
    CHECK(glm::length(mean_colour(panel, place(0.5f, 0.0f), 16) - Rgb(2, 1, 0)) < 1e-6f);
    texture.uv_from_projected = mat3(vec3(1, 0, 0), vec3(0, -1, 0), vec3(0, 1, 1)); // of a mirrored light
    panel.texture = std::make_shared<const LightTexture>(texture);
    CHECK(glm::length(uv(0.6f, 0.1f) - vec2(1.0f, 0.25f)) < 1e-6f);
}
} // namespace light_texture_test
