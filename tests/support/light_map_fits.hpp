// SPDX-License-Identifier: GPL-3.0-or-later
// Light map fits of triangles in a cube of fog under a sun, and products of their matrix.
#pragma once
#include "light_shafts/light_map_fit.hpp"
#include "support/soup.hpp"
#include <array>

namespace tyndall::support {
using namespace light_shafts;

inline constexpr float side_m = 8.0f;

inline Medium fog(const Rgb& sigma_s, const Rgb& sigma_a) {
    return {.name = "fog", .lobes = {{sigma_s, 0.3f}}, .sigma_a_per_m = sigma_a};
}
/// The dense one swallows what is 10 m away: the map ends where next to nothing is left.
inline const Medium grey_fog = fog(Rgb(0.06f), Rgb(0.02f)),
                    coloured_fog = fog({0.06f, 0.04f, 0.02f}, {0.01f, 0.03f, 0.05f}),
                    dense_fog = fog(Rgb(0.6f), Rgb(0.4f));

inline const Light fit_sun{.name = "Sun",
                           .kind = LightKind::Sun,
                           .strength = Rgb(3.0f, 2.0f, 1.0f),
                           .position = {1.0f, 2.0f, 30.0f},
                           .towards_light = glm::normalize(vec3(0.4f, 0.3f, 0.8f))};
/// A cube of fog with triangles in it, under a sun.
inline std::unique_ptr<Scene> soup_in_fog(const Medium& medium, std::size_t triangle_count = 120,
                                          const Light& light = fit_sun) {
    return make_scene({{.mesh = soup_mesh(triangle_count, {.min = vec3(-7.0f), .max = vec3(7.0f)}, 2.5f, 21)},
                       {.mesh = cube(),
                        .world_from_object = glm::scale(mat4(1.0f), vec3(side_m)),
                        .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
                      {medium}, {light});
}
/// Rays of a camera that looks at the fog's middle from outside, painted one colour.
inline Strokes strokes_from(const vec3& position, int side_px, const Rgb& desired = Rgb(1.0f)) {
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
inline Fitted begin_fit(const Medium& medium, std::span<const Strokes> strokes, const LightMapFitConfig& config,
                        const LightMap& current = {}) {
    Progress progress;
    Fitted made{.scene = soup_in_fog(medium), .media = {}, .fit = {}};
    made.media = std::make_unique<Media>(*made.scene, progress);
    made.fit = std::make_unique<LightMapFit>(*made.scene, *made.media, strokes, current, config, progress);
    return made;
}
inline LightMapFitConfig config_of(std::uint32_t resolution, float regularisation = 1e-3f) {
    return {.resolution = resolution, .regularisation = regularisation, .shafts = {.method = Method::Exact}};
}
inline std::vector<vec4> random_colours(std::size_t count, std::uint64_t seed) {
    SceneRandom random(seed);
    std::vector<vec4> colours(count);
    for (vec4& colour : colours)
        colour = {random.uniform(), random.uniform(), random.uniform(), 0.0f};
    return colours;
}
inline std::vector<vec4> product(const LightMapMatrix& t, const std::vector<vec4>& texels) {
    LightMapMatrix::Scratch scratch;
    std::vector<vec4> radiance(t.ray_count());
    t.multiply(texels, radiance, scratch, Progress());
    return radiance;
}
inline double inner_product(std::span<const vec4> a, std::span<const vec4> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += glm::dot(glm::dvec3(a[i]), glm::dvec3(b[i]));
    return sum;
}
/// How far <Tx, y> is off <x, T'y>, relative, for colours at random.
inline double transpose_error(const LightMapMatrix& t) {
    const std::vector<vec4> x = random_colours(t.texel_count(), 3), y = random_colours(t.ray_count(), 4);
    const std::vector<vec4> t_x = product(t, x);
    std::vector<vec4> t_y(x.size());
    t.multiply_transposed(y, t_y, Progress());
    return std::abs(inner_product(t_x, y) / inner_product(x, t_y) - 1.0);
}
inline double relative_rms(std::span<const vec4> a, std::span<const vec4> b) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]), v(b[i]);
        difference += glm::dot(d, d);
        size += glm::dot(v, v);
    }
    return std::sqrt(difference / size);
}

/// As the matrix reads it.
inline std::vector<vec4> padded(const LightMap& map) {
    const std::size_t side = map.place.resolution, pitch = LightMapMatrix::pitch_of(map.place.resolution);
    std::vector<vec4> result(side * pitch, vec4(0.0f));
    for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
        result[texel / side * pitch + texel % side] = vec4(map.texels[texel], 0.0f);
    return result;
}
inline const std::array red_and_blue{strokes_from({20, -9, 3}, 32, {2.0f, 0.1f, 0.0f}),
                                     strokes_from({-14, 16, 9}, 32, {0.1f, 0.3f, 1.5f})};
} // namespace tyndall::support
