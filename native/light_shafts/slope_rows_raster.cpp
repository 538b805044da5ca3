// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_raster.hpp"
#include "core/parallel.hpp"
#include "light_shafts/shape_faces.hpp"
#include "light_shafts/slope_rows_placed_instance.hpp"
#include <algorithm>

namespace tyndall::light_shafts::slope_rows {
namespace {
/// Fills the slices [first, end).
class SlicesRaster {
public:
    SlicesRaster(Rows& rows, std::int32_t first, std::int32_t end) : rows_(rows), first_(first), end_(end) {
        clear_slices(rows, first, end);
    }
    void add(const Culling& culling, const OccluderInstance& instance) {
        const PlacedInstance at(rows_.layout.frame, *instance.scene_from_object, instance.mesh->bounds);
        if (at.needs(culling, instance.mesh->bounds, first_, end_).is_empty())
            return;
        for (const OccluderBlock& block : instance.mesh->blocks) {
            const SliceNeeds needs = at.needs(culling, block.bounds, first_, end_);
            if (needs.is_empty())
                continue;
            make_room(block.count);
            place_triangles(rows_.layout, needs,
                            {block.columns, block.stride, block.count, at.frame_from_object, at.origin}, placed_);
        }
    }
    void add(const Placer& place, const OccluderInstance& instance) {
        for (const OccluderBlock& block : instance.mesh->blocks)
            for (std::size_t start = 0; start < block.count;) {
                make_room(PlacedTriangles::capacity / 2);
                start = place(instance, block, start, first_, end_, placed_);
            }
    }
    void finish(const Tracer& trace) {
        raster_triangles(rows_, first_, end_, placed_);
        trace(first_, end_);
        summarise_slices(rows_, first_, end_);
    }

private:
    void make_room(std::size_t count) {
        if (placed_.count + count > PlacedTriangles::capacity)
            raster_triangles(rows_, first_, end_, placed_);
    }

    Rows& rows_;
    std::int32_t first_, end_;
    PlacedTriangles placed_;
};
} // namespace

/// Slices per task: what is traced takes long enough to be shared out in small parts.
static std::size_t slices_per_task(const Rows& rows, const Occluders& occluders) {
    const std::size_t slices = slices_per_range(rows.layout);
    return occluders.traced ? std::min<std::size_t>(slices, 16) : slices;
}

void raster(Rows& rows, const Occluders& occluders, const Progress& progress, const MapDrawing* map) {
    if (rows.layout.rows.empty())
        return;
    const Culling culling(rows.layout);
    const float highest = occluders.traced ? above(rows.layout.frame, occluders.traced->bounds()) : 0.0f;
    const Tracer trace = [&](std::int32_t first, std::int32_t end) {
        if (occluders.traced && map != nullptr)
            map->tracer(first, end);
        else if (occluders.traced)
            trace_shapes(rows, first, end, *occluders.traced, [&](std::int32_t slice, std::int32_t line) {
                return light_line(rows.layout, highest, slice, line);
            });
    };
    parallel_blocks(rows.layout.rows.size(), slices_per_task(rows, occluders), progress,
                    [&](std::size_t begin, std::size_t end) {
                        SlicesRaster slices(rows, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
                        for (std::size_t i = 0; i < occluders.instances.size(); ++i) {
                            if (i % 64 == 0)
                                progress.poll();
                            if (map != nullptr)
                                slices.add(map->placer, occluders.instances[i]);
                            else
                                slices.add(culling, occluders.instances[i]);
                        }
                        slices.finish(trace);
                    });
}
} // namespace tyndall::light_shafts::slope_rows
