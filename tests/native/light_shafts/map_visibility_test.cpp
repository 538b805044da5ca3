// SPDX-License-Identifier: GPL-3.0-or-later
// Walking along the texels of a map: slow, and with no error but the map's.
#include "light_shafts/map_visibility.hpp"
#include "support/shaft_settings.hpp"
#include <algorithm>
#include <doctest/doctest.h>

namespace map_visibility_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

TEST_CASE("lit stretches of a map are those of the points on the ray, each asked for its own texel") {
    const Soup soup(make_soup(60, 3.0f, 0.8f, vec3(0.0f), 3));
    Progress progress;
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto rays = make_rays(setting, 12);
        const slope_rows::Layout layout = slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light),
                                                                  rays, {.lines = 128}, progress);
        const MapVisibility walk(raster_shadow_map(layout, setting.light, 128, soup.occluders, progress));
        LitRows lit;
        walk.lit_intervals(rays, lit);
        REQUIRE(lit.first.size() == rays.size() + 1);
        constexpr int steps = 2000;
        int wrong = 0;
        for (std::size_t r = 0; r < rays.size(); ++r) {
            const ViewRay& ray = rays[r];
            const auto intervals = std::span(lit.intervals).subspan(lit.first[r], lit.first[r + 1] - lit.first[r]);
            float last = ray.near_m;
            for (const LitInterval& interval : intervals) {
                CHECK(interval.near_m >= last);
                CHECK(interval.far_m > interval.near_m);
                last = interval.far_m;
            }
            CHECK(last <= ray.far_m);
            for (int i = 0; i < steps; ++i) {
                const float t = ray.near_m + (static_cast<float>(i) + 0.5f) / steps * (ray.far_m - ray.near_m);
                const bool is_in = std::any_of(intervals.begin(), intervals.end(), [&](const LitInterval& part) {
                    return part.near_m <= t && t <= part.far_m;
                });
                const vec3 point = ray.origin + t * ray.direction;
                bool is_lit = false;
                if (setting.light.is_directional) {
                    const DepthMap& face = walk.map().faces.front();
                    const vec3 p = face.axes_of(point - face.origin);
                    is_lit = p.z >= face.depth_at(p.x, p.y);
                } else {
                    const FacePoint p = face_point(walk.map(), point - setting.light.position);
                    is_lit = 1.0f / p.z >= p.face->depth_at(p.x, p.y);
                }
                wrong += is_in != is_lit;
            }
        }
        // Points that rounding puts on the other side of a texel's border or of a surface.
        CHECK(wrong < static_cast<int>(rays.size()) * steps / 20000);
    }
}
} // namespace map_visibility_test
