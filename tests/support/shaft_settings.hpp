// SPDX-License-Identifier: GPL-3.0-or-later
// Views, lights and soups that tests of slope rows share: every light kind under every camera kind.
#pragma once
#include "light_shafts/shadow_map.hpp"
#include "support/shaft_oracle.hpp"
#include <string>

namespace tyndall::support {
using namespace light_shafts;

/// A view, a light and what stands between.
struct Setting {
    std::string name;
    View view;
    LightSample light;
    vec3 towards{0, 1, 0}; ///< The middle of a perspective view.
    float scale_m = 1.0f;  ///< Size of everything.
    vec3 centre{0.0f};     ///< Of the soup.
};

inline LightSample sun(const vec3& towards_light) {
    LightSample light;
    light.towards_light = glm::normalize(towards_light);
    return light;
}
inline LightSample lamp(const vec3& position) {
    LightSample light;
    light.is_directional = false;
    light.position = position;
    return light;
}
inline View perspective(const vec3& position) { return {.position = position}; }
inline View orthographic(const vec3& direction) {
    return {.is_orthographic = true, .direction = glm::normalize(direction)};
}

inline std::vector<ViewRay> make_rays(const Setting& setting, int side) {
    std::vector<ViewRay> rays;
    const vec3 forward = setting.view.is_orthographic ? setting.view.direction : glm::normalize(setting.towards);
    const auto [right, up] = orthonormal_basis(forward);
    SceneRandom random(7);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(side) - 0.5f;
            const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(side) - 0.5f;
            const float far_m = setting.scale_m * random.uniform(6.0f, 12.0f);
            if (setting.view.is_orthographic)
                rays.push_back({setting.centre + setting.scale_m * (6.0f * (u * right + v * up) - 5.0f * forward),
                                forward, 0.0f, far_m});
            else
                rays.push_back({setting.view.position, glm::normalize(forward + 0.9f * (u * right + v * up)),
                                0.01f * setting.scale_m, far_m});
        }
    return rays;
}

struct Soup {
    TriangleSoup soup;
    mat4 identity{1.0f};
    Occluders occluders;
    explicit Soup(TriangleSoup triangles) : soup(std::move(triangles)) {
        occluders.add(make_occluder_mesh(soup.positions, soup.triangles), &identity);
    }
};

inline slope_rows::Rows make_rows(const Setting& setting, const Soup& soup, std::span<const ViewRay> rays,
                                  std::uint32_t lines, bool from_map = false) {
    Progress progress;
    const auto frame = slope_rows::make_frame(setting.view, setting.light);
    require(frame.has_value(), setting.name, " has no slices");
    slope_rows::Rows rows(slope_rows::make_layout(*frame, rays, {.lines = lines}, progress));
    if (from_map)
        rectify(raster_shadow_map(rows.layout, setting.light, lines, soup.occluders, progress), rows, progress);
    else
        slope_rows::raster(rows, soup.occluders, progress);
    return rows;
}

inline std::vector<Setting> settings() {
    const vec3 eye(0, -6, 0.5f);
    std::vector<Setting> all{
        {"perspective, sun from the side", perspective(eye), sun({1, 0.3f, 1})},
        {"perspective, sun in the picture", perspective(eye), sun({0.1f, 1, 0.15f})},
        {"perspective, sun in the back", perspective(eye), sun({0.1f, -1, 0.15f})},
        {"perspective, lamp aside", perspective(eye), lamp({4, 1, 3})},
        {"perspective, lamp in the picture", perspective(eye), lamp({0.4f, 0.5f, 0.3f})},
        {"perspective, lamp behind the camera", perspective(eye), lamp({1, -9, 2})},
        {"orthographic, sun from the side", orthographic({0, 1, 0}), sun({1, 0.3f, 1})},
        {"orthographic, sun across", orthographic({0, 1, 0}), sun({1, 0, 0})},
        {"orthographic, lamp in the picture", orthographic({0, 1, 0}), lamp({0.4f, 0.5f, 0.3f})},
        {"orthographic, lamp behind", orthographic({0, 1, 0}), lamp({0.4f, 9.0f, 0.3f})},
    };
    return all;
}
} // namespace tyndall::support
