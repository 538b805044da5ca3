// SPDX-License-Identifier: GPL-3.0-or-later
// Slope rows at full HD under a sun: what each step costs, and what error the whole has against brute-force marching.
//   layout   slices and lines that the view rays need        query_grey   grey, unattenuated, rays sorted by slice
//   raster   triangles to rows (EPIPOLAR)                     query_full   RGB, attenuated, three pieces per ray, HG
//   map, rectify   depth map to rows (SHADOW_MAP)             sun_moved    everything anew, the rays' order, too
// Arguments: the scene (0: S, Sponza-LowPoly; 1: F, the forest) and the lines of a row. Counters: relative RMSE and
// bias of the scattered light in percent over 1500 random rays; light/dark transitions per ray; slices.
#include "light_shafts/shadow_map.hpp"
#include "support/machine.hpp"
#include "support/row_frames.hpp"
#include <algorithm>
#include <array>
#include <map>

namespace tyndall::bench {
using namespace light_shafts;
namespace {
struct Prepared {
    ShaftScene* scene = nullptr;
    std::unique_ptr<slope_rows::Rows> rows;
    std::vector<std::uint32_t> order; ///< Rays by slice.
    std::vector<ViewRay> sorted;
};

/// Rows of a scene, kept from benchmark to benchmark. Null where the scene's file is absent.
Prepared* prepared(benchmark::State& state) {
    static const bool has_machine = (add_machine_to_context(), true);
    static std::map<std::pair<std::int64_t, std::int64_t>, Prepared> all;
    ShaftScene* scene = state.range(0) == 0 ? sponza_scene() : &forest_scene();
    if (scene == nullptr || !has_machine) {
        state.SkipWithError("Sponza-LowPoly is absent: set TYNDALL_SHARED_DATA");
        return nullptr;
    }
    Prepared& made = all[{state.range(0), state.range(1)}];
    if (made.scene != nullptr)
        return &made;
    made.scene = scene;
    Progress progress;
    made.rows = std::make_unique<slope_rows::Rows>(
        slope_rows::make_layout(*slope_rows::make_frame(scene->view, scene->sun), scene->rays,
                                layout_config(static_cast<std::uint32_t>(state.range(1))), progress));
    slope_rows::raster(*made.rows, scene->occluders, progress);
    made.order = row_query::by_wedge(made.rows->layout, scene->rays, progress);
    for (const std::uint32_t ray : made.order)
        made.sorted.push_back(scene->rays[ray]);
    return &made;
}

/// Three coloured pieces per ray, as a fog box and its light-side crossings make them.
std::vector<PieceRows> make_coloured_pieces(const ShaftScene& scene, std::span<const ViewRay> rays) {
    std::vector<PieceRows> blocks;
    for (std::size_t start = 0; start < rays.size(); start += rays_per_call) {
        PieceRows& block = blocks.emplace_back();
        for (const ViewRay& ray : rays.subspan(start, std::min(rays_per_call, rays.size() - start))) {
            for (int p = 0; p < 3; ++p)
                block.pieces.push_back(make_piece(scene, ray, p, 3));
            block.end_ray();
        }
    }
    return blocks;
}

/// `pieces` of each call, or of all of them.
void query(const slope_rows::Rows& rows, std::span<const ViewRay> rays, std::span<const PieceRows> pieces,
           std::span<Rgb> radiance) {
    Progress progress;
    parallel_blocks(rays.size(), rays_per_call, progress, [&](std::size_t begin, std::size_t end) {
        thread_local row_query::Unanswered unanswered;
        const std::span<Rgb> of_call = radiance.subspan(begin, end - begin);
        std::ranges::fill(of_call, Rgb(0.0f));
        row_query::add_scattered(rows, rays.subspan(begin, end - begin),
                                 pieces.size() == 1 ? pieces[0] : pieces[begin / rays_per_call], of_call, {},
                                 unanswered);
    });
}

/// Error against marching; `radiance` in the picture's order.
void report_error(benchmark::State& state, const ShaftScene& scene, const std::vector<Rgb>& radiance) {
    double square_sum = 0.0, sum = 0.0, truth_sum = 0.0;
    for (std::size_t i = 0; i < scene.truth.size(); ++i) {
        const double difference = double{radiance[scene.truth_rays[i]].y} - scene.truth[i];
        square_sum += difference * difference;
        sum += difference;
        truth_sum += scene.truth[i];
    }
    state.counters["relative_rmse_percent"] =
        100.0 * std::sqrt(square_sum * static_cast<double>(scene.truth.size())) / truth_sum;
    state.counters["bias_percent"] = 100.0 * sum / truth_sum;
}

void report_transitions(benchmark::State& state, const Prepared& made) {
    LitRows lit;
    row_query::Uncovered uncovered;
    std::vector<ViewRay> some;
    for (std::size_t i = 0; i < made.scene->rays.size(); i += 101)
        some.push_back(made.scene->rays[i]);
    row_query::lit_intervals(*made.rows, some, lit, uncovered);
    state.counters["transitions_per_ray"] =
        2.0 * static_cast<double>(lit.intervals.size()) / static_cast<double>(some.size());
    state.counters["slices"] = made.rows->layout.slice_count();
}
} // namespace

static void layout(benchmark::State& state) {
    Progress progress;
    if (Prepared* made = prepared(state))
        for (auto _ : state)
            benchmark::DoNotOptimize(slope_rows::make_layout(made->rows->layout.frame, made->scene->rays,
                                                             layout_config(static_cast<std::uint32_t>(state.range(1))),
                                                             progress));
}
static void raster(benchmark::State& state) {
    Progress progress;
    if (Prepared* made = prepared(state))
        for (auto _ : state)
            slope_rows::raster(*made->rows, made->scene->occluders, progress);
}
static void map_and_rectify(benchmark::State& state) {
    Progress progress;
    if (Prepared* made = prepared(state)) {
        slope_rows::Rows rows(made->rows->layout);
        for (auto _ : state)
            rectify(raster_shadow_map(rows.layout, made->scene->sun, static_cast<std::uint32_t>(state.range(1)),
                                      made->scene->occluders, progress),
                    rows, progress);
    }
}
static void query_sorted(benchmark::State& state, bool is_full) {
    if (Prepared* made = prepared(state)) {
        const std::vector<PieceRows> pieces =
            is_full ? make_coloured_pieces(*made->scene, made->sorted) : std::vector{make_grey_pieces(*made->scene)};
        std::vector<Rgb> radiance(made->sorted.size()), in_order(radiance.size());
        for (auto _ : state)
            query(*made->rows, made->sorted, pieces, radiance);
        for (std::size_t i = 0; i < in_order.size(); ++i)
            in_order[made->order[i]] = radiance[i];
        report_error(state, *made->scene, in_order); // the middle channel of the full case is the grey one
        report_transitions(state, *made);
    }
}
static void query_grey(benchmark::State& state) { query_sorted(state, false); }
static void query_full(benchmark::State& state) { query_sorted(state, true); }

/// All of a frame after the sun has moved; at many lines the row of the error target.
static void sun_moved(benchmark::State& state, bool by_map) {
    Progress progress;
    Prepared* made = prepared(state);
    if (made == nullptr)
        return;
    const ShaftScene& scene = *made->scene;
    std::vector<Rgb> radiance(scene.rays.size());
    const PieceRows pieces = make_grey_pieces(scene);
    for (auto _ : state) {
        slope_rows::Rows rows(slope_rows::make_layout(*slope_rows::make_frame(scene.view, scene.sun), scene.rays,
                                                      layout_config(static_cast<std::uint32_t>(state.range(1))),
                                                      progress));
        if (by_map)
            rectify(raster_shadow_map(rows.layout, scene.sun, static_cast<std::uint32_t>(state.range(1)),
                                      scene.occluders, progress),
                    rows, progress);
        else
            slope_rows::raster(rows, scene.occluders, progress);
        query_by_wedge(rows, scene, pieces, radiance);
    }
    report_error(state, scene, radiance);
}
static void sun_moved_epipolar(benchmark::State& state) { sun_moved(state, false); }
static void sun_moved_shadow_map(benchmark::State& state) { sun_moved(state, true); }

#define TYNDALL_ROWS_BENCHMARK(name)                                                                                   \
    BENCHMARK(name)                                                                                                    \
        ->ArgNames({"scene", "lines"})                                                                                 \
        ->Args({0, 2048})                                                                                              \
        ->Args({1, 2048})                                                                                              \
        ->MeasureProcessCPUTime()                                                                                      \
        ->UseRealTime()                                                                                                \
        ->Unit(benchmark::kMillisecond)
TYNDALL_ROWS_BENCHMARK(layout);
TYNDALL_ROWS_BENCHMARK(raster);
TYNDALL_ROWS_BENCHMARK(map_and_rectify);
TYNDALL_ROWS_BENCHMARK(query_grey);
TYNDALL_ROWS_BENCHMARK(query_full);
TYNDALL_ROWS_BENCHMARK(sun_moved_shadow_map);
TYNDALL_ROWS_BENCHMARK(sun_moved_epipolar)->Args({0, 8192})->Args({1, 8192})->Args({0, 16384})->Args({1, 16384});
} // namespace tyndall::bench
