// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_place.hpp"
#include "light_shafts/light_space.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
LightMapAxes::LightMapAxes(const Light& sun) : origin_(sun.position) {
    std::tie(x_axis_, y_axis_) = LightSpace(sun, sun.position, 1.0f).across(sun.towards_light);
}

bool covers(const LightMapPlace& place, const Focus& focus) {
    const vec2 low = texel_at(place, focus.min_m), high = texel_at(place, focus.max_m);
    const float last = static_cast<float>(place.resolution) - 1.0f - light_map_margin_texels;
    return low.x >= light_map_margin_texels && low.y >= light_map_margin_texels && high.x <= last && high.y <= last;
}

LightMapPlace snapped(const Focus& focus, std::uint32_t resolution) {
    const vec2 extent = focus.max_m - focus.min_m;
    // A texel more on either side, for the centre's own rounding.
    const float texels = static_cast<float>(resolution) - 2.0f * light_map_margin_texels - 2.0f;
    const float needed_m = std::max({extent.x, extent.y, 1e-3f}) * static_cast<float>(resolution) / texels;
    LightMapPlace place{.resolution = resolution, .size_m = std::exp2(std::ceil(4.0f * std::log2(needed_m)) / 4.0f)};
    const float texel_m = place.texel_m();
    place.centre_m = glm::round(0.5f * (focus.min_m + focus.max_m) / texel_m) * texel_m;
    return place;
}

std::vector<Rgb> resampled(const LightMap& map, const LightMapPlace& place) {
    const std::size_t side = place.resolution;
    if (map.texels.empty())
        return std::vector<Rgb>(side * side, Rgb(1.0f));
    if (map.place == place)
        return map.texels;
    const auto last = static_cast<float>(map.place.resolution - 1);
    const auto first_of = [&](float position) { return std::min(std::floor(position), std::max(last - 1.0f, 0.0f)); };
    std::vector<Rgb> texels(side * side);
    for (std::size_t row = 0; row < side; ++row)
        for (std::size_t column = 0; column < side; ++column) {
            const vec2 here(static_cast<float>(column), static_cast<float>(row));
            const vec2 point_m = place.centre_m + (here + 0.5f - 0.5f * static_cast<float>(side)) * place.texel_m();
            const vec2 at = glm::clamp(texel_at(map.place, point_m), 0.0f, last);
            const vec2 first(first_of(at.x), first_of(at.y)), share = at - first;
            const auto texel = [&](float x, float y) {
                return map.texels[static_cast<std::size_t>(std::min(y, last)) * map.place.resolution +
                                  static_cast<std::size_t>(std::min(x, last))];
            };
            texels[row * side + column] =
                glm::mix(glm::mix(texel(first.x, first.y), texel(first.x + 1, first.y), share.x),
                         glm::mix(texel(first.x, first.y + 1), texel(first.x + 1, first.y + 1), share.x), share.y);
        }
    return texels;
}
} // namespace tyndall::light_shafts
