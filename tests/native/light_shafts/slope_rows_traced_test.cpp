// SPDX-License-Identifier: GPL-3.0-or-later
// Rays from the light and rastered triangles put the same slopes into rows, and rays answer only where they may.
#include "light_shafts/slope_rows_raster.hpp"
#include "light_shafts/slope_rows_traced.hpp"
#include "support/placed_boxes.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace slope_rows_traced_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
slope_rows::Layout layout_of(const Setting& setting, std::uint32_t lines) {
    Progress progress;
    const auto rays = make_rays(setting, 24);
    return slope_rows::make_layout(*slope_rows::make_frame(setting.view, setting.light), rays, {.lines = lines},
                                   progress);
}

Occluders occluders_of(const std::vector<Part>& parts) {
    return gather_occluders(make_scene(parts)->description(), Progress());
}

const Material pane{.name = "pane", .constant = {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(0.5f)}};
const Material air{.name = "air", .has_surface = false};
} // namespace

TEST_CASE("rows that rays fill hold what the raster puts into them, for suns and lamps, in every view") {
    Progress progress;
    for (const Setting& setting : settings()) {
        CAPTURE(setting.name);
        const auto scene = placed_boxes(setting).scene(boxes_of(), true);
        const Occluders occluders = gather_occluders(scene->description(), progress);
        slope_rows::Rows traced(layout_of(setting, 192)), rastered(layout_of(setting, 192));
        slope_rows::trace(traced, *scene, progress);
        slope_rows::raster(rastered, occluders, progress);
        std::size_t occluded = 0, open = 0, different = 0;
        const slope_rows::Layout& layout = traced.layout;
        for (const slope_rows::RowExtent& row : layout.rows)
            for (std::int32_t line = row.first; line < std::min(row.end, layout.line_count); ++line) {
                const std::size_t sample = row.offset + static_cast<std::size_t>(line - row.first);
                // What no view ray reaches is not drawn of triangles.
                const auto seen = [&](float slope) {
                    return slope < row.smallest_slope ? slope_rows::no_occluder : slope;
                };
                const float a = seen(traced.slopes[sample]), b = seen(rastered.slopes[sample]);
                occluded += std::isfinite(b);
                open += !std::isfinite(b);
                different += !(a == b || std::abs(a - b) < 2e-4f * std::max(std::abs(a), std::abs(b)));
            }
        CHECK(occluded > 1000);
        CHECK(open > 1000);
        CHECK(different < occluded / 500 + 2); // on an edge, rounding decides
        // The blocks that queries skip by, too.
        for (std::size_t block = 0; block < layout.sample_count / slope_rows::block_lines; ++block) {
            const auto samples =
                std::span(traced.slopes.get() + block * slope_rows::block_lines, std::size_t{slope_rows::block_lines});
            REQUIRE(traced.lowest[block] == *std::ranges::min_element(samples));
            REQUIRE(traced.highest[block] == *std::ranges::max_element(samples));
        }
    }
}

TEST_CASE("occluders are whole where a shadow ray meets nothing else, and no light passes what it meets") {
    const Part opaque{.mesh = cube()}, fog_box{.mesh = cube(), .material = air},
        glazed{.mesh = square(), .material = pane};
    CHECK(occluders_of({opaque}).are_whole);
    CHECK(occluders_of({opaque, fog_box}).are_whole);
    CHECK_FALSE(occluders_of({opaque, glazed}).are_whole);

    Progress progress;
    const auto boxes = std::make_shared<const BoxShape>(scattered_cells(8, 4, 7), 0.4f);
    CHECK_FALSE(gather_occluders(BoxScene{}.description(boxes, false), progress).are_whole);
    CHECK(gather_occluders(BoxScene{.casts_shadow = false}.description(boxes, false), progress).are_whole);

    const auto scene = make_scene({opaque, opaque});
    const Occluders all = gather_occluders(scene->description(), progress);
    CHECK_FALSE(blocking(*scene, all, LightLinks{}, progress)->are_whole);
}

TEST_CASE("rays fill coarse rows of many triangles, and neither fine ones nor those of a few") {
    const Setting setting = settings().front();
    const auto cubes = placed_boxes(setting).scene(boxes_of(), true);
    Occluders occluders = gather_occluders(cubes->description(), Progress());
    const std::size_t triangles = occluders.triangle_count;
    const slope_rows::Rows coarse(layout_of(setting, 16)), fine(layout_of(setting, 256));
    REQUIRE(8 * coarse.layout.sample_count > triangles); // 1,920
    CHECK_FALSE(slope_rows::are_better_traced(coarse, occluders));
    for (std::size_t copy = 0; copy < 16; ++copy) // they only stand there once more each
        for (std::size_t i = 0; i < 2; ++i)
            occluders.add(occluders.instances[i].mesh, occluders.instances[i].scene_from_object);
    REQUIRE(8 * coarse.layout.sample_count < occluders.triangle_count);
    CHECK(slope_rows::are_better_traced(coarse, occluders));
    CHECK_FALSE(slope_rows::are_better_traced(fine, occluders));
    occluders.are_whole = false;
    CHECK_FALSE(slope_rows::are_better_traced(coarse, occluders));
}
} // namespace slope_rows_traced_test
