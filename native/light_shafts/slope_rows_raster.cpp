// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_raster.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::light_shafts::slope_rows {
static TriangleSource source_of(const Frame& frame, const OccluderPiece& piece, std::size_t start) {
    const mat4& scene_from_object = *piece.scene_from_object;
    const mat3 frame_from_scene = glm::transpose(mat3(frame.u, frame.v, frame.axis));
    // The offset in double: an instance 60 km out, before a camera beside it, keeps its millimetres.
    const dvec3 offset = dvec3(vec3(scene_from_object[3])) - dvec3(frame.origin);
    const dvec3 origin(glm::dot(dvec3(frame.u), offset), glm::dot(dvec3(frame.v), offset),
                       glm::dot(dvec3(frame.axis), offset));
    return {piece.positions.data(), piece.triangles.data() + start,
            std::min(PlacedTriangles::capacity, piece.triangles.size() - start),
            frame_from_scene * mat3(scene_from_object), vec3(origin)};
}

/// Triangles of consecutive pieces, with the bands that they touch.
struct TaskTriangles {
    struct Touch {
        std::uint32_t band, triangle;
        std::uint16_t first_slice, last_slice;
    };
    std::vector<std::array<float, 9>> triangles;
    std::vector<Touch> touches;
    std::vector<std::uint32_t> band_counts;
};

static void touch_bands(TaskTriangles& task, std::int32_t first, std::int32_t last, std::int32_t slice_count) {
    first = std::max(first, 0);
    last = std::min(last, slice_count - 1);
    const auto triangle = static_cast<std::uint32_t>(task.triangles.size());
    for (std::int32_t band = first / band_slices; first <= last && band <= last / band_slices; ++band) {
        const std::int32_t band_first = band * band_slices;
        task.touches.push_back({static_cast<std::uint32_t>(band), triangle,
                                static_cast<std::uint16_t>(std::max(first - band_first, 0)),
                                static_cast<std::uint16_t>(std::min(last - band_first, band_slices - 1))});
        ++task.band_counts[static_cast<std::size_t>(band)];
    }
}

static void touch(const Layout& layout, const PlacedTriangles& placed, std::size_t count, TaskTriangles& task) {
    const std::int32_t slice_count = layout.slice_count();
    for (std::size_t i = 0; i < count; ++i) {
        const auto first = static_cast<std::int32_t>(std::clamp(placed.first_slice[i], -1.0f, 1e8f));
        const auto last = static_cast<std::int32_t>(std::clamp(placed.last_slice[i], -1.0f, 1e8f));
        const std::size_t touch_count = task.touches.size();
        touch_bands(task, first, last, slice_count);
        if (layout.slices_per_turn > 0 && last >= layout.slices_per_turn)
            touch_bands(task, 0, std::min(last - layout.slices_per_turn, first - 1), slice_count);
        if (task.touches.size() == touch_count)
            continue;
        auto& axy = task.triangles.emplace_back();
        for (std::size_t c = 0; c < 9; ++c)
            axy[c] = placed.axy[c][i];
    }
}

BandTriangles bin_triangles(const Layout& layout, const Occluders& occluders, const Progress& progress,
                            const Placer& placer) {
    const Placer place =
        placer ? placer : [&](const OccluderPiece& piece, std::size_t& start, PlacedTriangles& placed) {
            const TriangleSource source = source_of(layout.frame, piece, start);
            place_triangles(layout, source, placed);
            start += source.count;
            return source.count;
        };
    const auto band_count = static_cast<std::size_t>((layout.slice_count() + band_slices - 1) / band_slices);
    const std::size_t pieces_per_task = std::max<std::size_t>(4, occluders.pieces.size() / 128);
    std::vector<TaskTriangles> tasks((occluders.pieces.size() + pieces_per_task - 1) / pieces_per_task);
    parallel_blocks(occluders.pieces.size(), pieces_per_task, progress, [&](std::size_t begin, std::size_t end) {
        TaskTriangles& task = tasks[begin / pieces_per_task];
        task.band_counts.assign(band_count, 0);
        PlacedTriangles placed;
        for (std::size_t p = begin; p < end; ++p)
            for (std::size_t start = 0; start < occluders.pieces[p].triangles.size();)
                touch(layout, placed, place(occluders.pieces[p], start, placed), task);
    });
    BandTriangles bands;
    bands.first.assign(band_count + 1, 0);
    std::vector<std::vector<std::size_t>> next(tasks.size(), std::vector<std::size_t>(band_count));
    std::size_t total = 0;
    for (std::size_t b = 0; b < band_count; ++b) {
        bands.first[b] = total;
        for (std::size_t t = 0; t < tasks.size(); ++t) {
            next[t][b] = total;
            total += tasks[t].band_counts[b];
        }
    }
    bands.first[band_count] = total;
    bands.triangles.resize(total);
    parallel_for(
        tasks.size(), progress,
        [&](std::size_t t) {
            for (const auto& touch : tasks[t].touches)
                bands.triangles[next[t][touch.band]++] = {tasks[t].triangles[touch.triangle], touch.first_slice,
                                                          touch.last_slice};
            tasks[t] = {};
        },
        1);
    return bands;
}

void raster(Rows& rows, const BandTriangles& triangles, const Progress& progress) {
    parallel_for(
        triangles.first.size() - 1, progress,
        [&](std::size_t band) {
            const auto first_slice = static_cast<std::int32_t>(band) * band_slices;
            clear_band(rows, first_slice);
            raster_band(rows, first_slice, triangles.band(band));
            summarise_band(rows, first_slice);
        },
        1);
}
} // namespace tyndall::light_shafts::slope_rows
