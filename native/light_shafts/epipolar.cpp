// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by the epipolar raster, see slope_rows_raster.hpp.
// Error:    first order in the spacing of lines and slices: a lit interval's end is off by at most half a line, and a
//           shaft by at most half a slice.
#include "light_shafts/coloured_rows.hpp"
#include "light_shafts/slope_rows_partial.hpp"
#include "light_shafts/slope_rows_traced.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// Lines for a relative RMS error of radiance: measured 8 / 43 over the lines in an atrium and in a forest of leaves.
static slope_rows::LayoutConfig layout_of(const Config& config) {
    const float lines = config.resolution > 0 ? static_cast<float>(config.resolution) : 20.0f / config.error_target;
    // Half as many slices as lines: slices cost a cut per triangle each, lines next to nothing.
    return {.lines = static_cast<std::uint32_t>(std::clamp(lines, 16.0f, 16384.0f)),
            .slices_per_line = 0.5f,
            .room = config.room};
}

std::unique_ptr<Visibility> make_epipolar(const Scene& scene, const View& view, const LightSample& light,
                                          std::span<const ViewRay> rays, const Config& config, Progress& progress) {
    return make_alone(make_epipolar_beam, scene, view, light, rays, config, progress);
}

std::unique_ptr<Visibility> make_epipolar_beam(const Scene& scene, const Occluders& occluders, const View& view,
                                               const LightSample& light, std::span<const RaySpan> outline,
                                               std::shared_ptr<const StripOnDemand> strip, const Config& config,
                                               Progress& progress) {
    const Preparation preparation{scene, occluders, view, light, outline, std::move(strip), progress};
    PreparedRows prepared = prepare_rows(preparation, sharing_memory(layout_of(config), occluders), "EPIPOLAR");
    if (prepared.instead)
        return std::move(prepared.instead);
    KeepAs keep_as{CastKind::EpipolarRows, in_rows(prepared.rows->layout, light)};
    return fill_rows(preparation, std::move(prepared), config.seed, std::move(keep_as),
                     [&](slope_rows::Rows& rows, const PartialShading& partial,
                         Statistics& statistics) -> std::shared_ptr<const Visibility> {
                         const StageTimer timer(statistics, "slope rows: raster");
                         slope_rows::fill(rows, scene, occluders, progress);
                         slope_rows::raster_partial(rows, partial, progress);
                         return nullptr;
                     });
}
} // namespace tyndall::light_shafts
