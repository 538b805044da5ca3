// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_space.hpp"
#include "scene/light_axes.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace light_space_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

/// Where a texel's column lies along the light's own axes, in double precision: along the stratum's direction onto the plane
/// through the light's origin.
static dvec2 place_in_double(const Light& light, const DepthMap& face, const MapWindow& window, dvec2 texels,
                             dvec2 column_and_row) {
    const mat3 axes = light_axes(light);
    const dvec2 at = dvec2(window.min) + (column_and_row + 0.5) / texels * dvec2(window.max - window.min);
    const dvec3 start = dvec3(face.origin) + at.x * dvec3(face.x_axis) + at.y * dvec3(face.y_axis);
    const dvec3 direction(face.z_axis), normal(axes[2]);
    const dvec3 p = start - direction * (glm::dot(start, normal) / glm::dot(direction, normal));
    return {glm::dot(p, dvec3(axes[0])), glm::dot(p, dvec3(axes[1]))};
}

// Seen to fail, by one and a half texels and by others in each row, when the step from one texel to the next was the
// difference of two rounded places.
TEST_CASE("the last texels of a wide map lie where their own columns say: holes have straight edges, and stay") {
    const Light light{.name = "Sun", .kind = LightKind::Sun, .towards_light = glm::normalize(vec3(-0.5f, 0.2f, 0.8f))};
    const LightSpace space(light, vec3(0.0f), 1.0f);
    DepthMap face;
    face.z_axis = glm::normalize(light.towards_light + vec3(0.004f, -0.003f, 0.0f)); // a stratum
    std::tie(face.x_axis, face.y_axis) = space.across(face.z_axis);
    const MapWindow window{vec2(-17.3f, -11.1f), vec2(15.4f, 21.6f)};
    constexpr std::uint32_t side = 8192;
    lay_out_texels(face, window, glm::uvec2(side));
    std::vector<float> x, y, z;
    const double texel_m = double{window.max.x - window.min.x} / side;
    for (const std::int32_t row : {0, 1, 2, 3, 4095, 8190, 8191}) {
        CAPTURE(row);
        space.place_row(face, row, x, y, z);
        REQUIRE(x.size() == side);
        for (const std::size_t column : {std::size_t{0}, std::size_t{1}, std::size_t{4096}, std::size_t{side - 1}}) {
            CAPTURE(column);
            const dvec2 expected = place_in_double(light, face, window, dvec2(side), dvec2(column, row));
            // Coordinates of up to 32 m are rounded by 2 um, a few times over.
            CHECK(std::abs(double{x[column]} - expected.x) < 2e-5);
            CHECK(std::abs(double{y[column]} - expected.y) < 2e-5);
        }
    }
    REQUIRE(2e-5 < 0.01 * texel_m);
}
} // namespace light_space_test
