// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_strokes.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall::light_shafts {
namespace {
/// Painted pixels of one square, together.
struct Dab {
    vec3 weighted_colour{0.0f};
    float alpha = 0.0f;
    vec2 weighted_place{0.0f};
    vec2 nearest{0.0f}; ///< The painted pixel that is nearest to the mean place.
    float nearest_distance = std::numeric_limits<float>::infinity();
};

bool is_painted(const vec4& texel) { return texel.w > 0.0f && std::isfinite(texel.x + texel.y + texel.z + texel.w); }

template <typename Visit>
void for_painted(const StrokePicture& picture, const Visit& visit) {
    for (std::uint32_t y = 0; y < picture.height; ++y)
        for (std::uint32_t x = 0; x < picture.width; ++x)
            if (const vec4& texel = picture.texels[std::size_t{y} * picture.width + x]; is_painted(texel))
                visit(x, y, texel);
}

/// At least as many texels along each side, each of them repeated.
StrokePicture at_least(const StrokePicture& picture, std::uint32_t width, std::uint32_t height) {
    StrokePicture fine{.name = picture.name,
                       .width = std::max(picture.width, width),
                       .height = std::max(picture.height, height),
                       .texels = {}};
    fine.texels.reserve(std::size_t{fine.width} * fine.height);
    for (std::uint64_t y = 0; y < fine.height; ++y)
        for (std::uint64_t x = 0; x < fine.width; ++x)
            fine.texels.push_back(
                picture.texels[y * picture.height / fine.height * picture.width + x * picture.width / fine.width]);
    return fine;
}

std::vector<Dab> take_together(const StrokePicture& picture, std::uint32_t side) {
    const std::size_t columns = (picture.width + side - 1) / side, rows = (picture.height + side - 1) / side;
    std::vector<Dab> dabs(columns * rows);
    const auto dab_of = [&](std::uint32_t x, std::uint32_t y) -> Dab& { return dabs[y / side * columns + x / side]; };
    const auto centre = [](std::uint32_t x, std::uint32_t y) {
        return vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f;
    };
    for_painted(picture, [&](std::uint32_t x, std::uint32_t y, const vec4& texel) {
        Dab& dab = dab_of(x, y);
        dab.weighted_colour += texel.w * vec3(texel);
        dab.weighted_place += texel.w * centre(x, y);
        dab.alpha += texel.w;
    });
    for_painted(picture, [&](std::uint32_t x, std::uint32_t y, const vec4&) {
        Dab& dab = dab_of(x, y);
        const float distance = glm::length(centre(x, y) - dab.weighted_place / dab.alpha);
        if (distance < dab.nearest_distance) {
            dab.nearest = centre(x, y);
            dab.nearest_distance = distance;
        }
    });
    std::erase_if(dabs, [](const Dab& dab) { return dab.alpha == 0.0f; });
    return dabs;
}
} // namespace

Strokes find_strokes(const Scene& scene, const Camera& camera, const StrokePicture& as_painted, std::size_t most_pixels,
                     const Progress& progress) {
    require_usable(camera);
    require(camera.width_px > 0 && camera.height_px > 0, "the camera's frame has no pixels");
    require(as_painted.texels.size() == std::size_t{as_painted.width} * as_painted.height, "strokes \"",
            as_painted.name, "\": ", as_painted.texels.size(), " texels for ", as_painted.width, " x ",
            as_painted.height);
    require(most_pixels > 0, "most_pixels is 0");
    if (std::ranges::none_of(as_painted.texels, is_painted))
        return {.view = view_of(camera), .pixels = {}};
    const bool is_fine = as_painted.width >= camera.width_px && as_painted.height >= camera.height_px;
    const StrokePicture finer = is_fine ? StrokePicture{} : at_least(as_painted, camera.width_px, camera.height_px);
    const StrokePicture& picture = is_fine ? as_painted : finer;
    std::vector<Dab> dabs = take_together(picture, 1);
    for (std::uint32_t side = 2; dabs.size() > most_pixels; ++side)
        dabs = take_together(picture, side);

    Strokes strokes{.view = view_of(camera), .pixels = std::vector<StrokePixel>(dabs.size())};
    const vec2 frame_from_picture(static_cast<float>(camera.width_px) / static_cast<float>(picture.width),
                                  static_cast<float>(camera.height_px) / static_cast<float>(picture.height));
    constexpr std::size_t packet = 16;
    parallel_blocks(dabs.size(), packet, progress, [&](std::size_t begin, std::size_t end) {
        std::array<Ray, packet> rays;
        std::array<Hit, packet> hits;
        const std::size_t count = end - begin;
        for (std::size_t i = 0; i < count; ++i) {
            const vec2 place_px = dabs[begin + i].nearest * frame_from_picture;
            rays[i] = camera.ray(place_px.x, place_px.y);
        }
        scene.closest_hits(std::span(rays).first(count), std::span(hits).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const Dab& dab = dabs[begin + i];
            strokes.pixels[begin + i] = {.ray = {.origin = rays[i].origin,
                                                 .direction = rays[i].direction,
                                                 .near_m = rays[i].near_m,
                                                 .far_m = hits[i].is_hit() ? hits[i].distance_m : rays[i].far_m},
                                         .desired = glm::max(dab.weighted_colour / dab.alpha, 0.0f),
                                         .weight = rays[i].exists() ? dab.alpha : 0.0f};
        }
    });
    std::erase_if(strokes.pixels, [](const StrokePixel& pixel) { return pixel.weight == 0.0f; });
    return strokes;
}
} // namespace tyndall::light_shafts
