// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by the epipolar raster, see slope_rows_raster.hpp.
// Error:    first order in the spacing of lines and slices: a lit interval's end is off by at most half a line, and a
//           shaft by at most half a slice; resolution_of turns an error target into a spacing.
#include "light_shafts/slope_rows_raster.hpp"
#include "light_shafts/slope_rows_visibility.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// Lines for a relative RMS error of radiance: 1 % takes 2048 in a forest of leaves, the hardest of our scenes.
static std::uint32_t resolution_of(const Config& config) {
    if (config.resolution > 0)
        return config.resolution;
    return static_cast<std::uint32_t>(std::clamp(20.0f / config.error_target, 256.0f, 16384.0f));
}

std::unique_ptr<Visibility> make_epipolar(const Scene& scene, const View& view, const LightSample& light,
                                          std::span<const ViewRay> rays, const Config& config, Progress& progress) {
    const Preparation preparation{scene, view, light, rays, config, progress};
    Statistics statistics;
    const Occluders occluders = gather_occluders(scene.description());
    if (!light.casts_shadow || (occluders.triangle_count == 0 && !occluders.transmitting_material)) {
        statistics.skip("slope rows", light.casts_shadow ? "no occluder" : "the light casts no shadow");
        return make_unshadowed(std::move(statistics));
    }
    if (occluders.transmitting_material)
        return fall_back_to_exact(preparation, "material " + *occluders.transmitting_material +
                                                   " lets light through: EXACT instead of EPIPOLAR");
    const auto frame = slope_rows::make_frame(view, light);
    if (!frame)
        return fall_back_to_exact(preparation, light.is_directional
                                                   ? "the sun shines along the orthographic view: EXACT instead of rows"
                                                   : "the light stands in the camera: EXACT instead of rows");
    std::unique_ptr<slope_rows::Rows> rows;
    {
        const StageTimer timer(statistics, "slope rows: layout");
        rows = std::make_unique<slope_rows::Rows>(
            slope_rows::make_layout(*frame, rays, {.lines = resolution_of(config)}, progress));
    }
    {
        const StageTimer timer(statistics, "slope rows: raster");
        slope_rows::raster(*rows, slope_rows::bin_triangles(rows->layout, occluders, progress), progress);
    }
    statistics.count("slope rows: slices", rows->layout.slice_count());
    statistics.count("slope rows: lines", rows->layout.line_count);
    statistics.count("slope rows: bytes", static_cast<double>(rows->bytes()));
    return std::make_unique<RowsVisibility>(preparation, std::move(*rows), std::move(statistics));
}
} // namespace tyndall::light_shafts
