// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_raster.hpp"
#include "core/parallel.hpp"
#include "light_shafts/shape_faces.hpp"
#include "light_shafts/slope_rows_placed_instance.hpp"
#include "light_shafts/strand_bands.hpp"
#include <algorithm>

namespace tyndall::light_shafts::slope_rows {
/// Where the light stands that the rows of a frame are of.
static LightPlace light_of(const Frame& frame) {
    return {.at = frame.is_angular ? frame.origin + frame.light_axial() * frame.axis : frame.axis,
            .is_directional = !frame.is_angular};
}

namespace {
/// Fills the slices [first, end).
class SlicesRaster {
public:
    SlicesRaster(Rows& rows, std::int32_t first, std::int32_t end, const LightPlace& light)
        : rows_(rows), first_(first), end_(end), light_(light) {
        clear_slices(rows, first, end);
        bands_.overlap = 0.0f; // it would be a large share of a hair, which is much thinner than a line
    }
    void add(const Culling& culling, const OccluderInstance& instance) {
        const OccluderMesh& mesh = *instance.mesh;
        const PlacedInstance at(rows_.layout.frame, *instance.scene_from_object, mesh.bounds);
        if (at.needs(culling, mesh.bounds, first_, end_).is_empty())
            return;
        PlacedTriangles& placed = placed_of(mesh);
        const LightPlace light = light_on(instance);
        for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
            const SliceNeeds needs = at.needs(culling, mesh.blocks[b].bounds, first_, end_);
            if (needs.is_empty())
                continue;
            const OccluderBlock block = written(mesh, b, light);
            make_room(placed, block.count);
            place_triangles(rows_.layout, needs,
                            {block.columns, block.stride, block.count, at.frame_from_object, at.origin}, placed);
        }
    }
    void add(const Placer& place, const OccluderInstance& instance) {
        const OccluderMesh& mesh = *instance.mesh;
        PlacedTriangles& placed = placed_of(mesh);
        const LightPlace light = light_on(instance);
        for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
            const OccluderBlock block = written(mesh, b, light);
            for (std::size_t start = 0; start < block.count;) {
                make_room(placed, PlacedTriangles::capacity / 2);
                start = place(instance, block, start, first_, end_, placed);
            }
        }
    }
    void finish(const Tracer& trace) {
        raster_triangles(rows_, first_, end_, placed_);
        raster_triangles(rows_, first_, end_, bands_);
        trace(first_, end_);
        summarise_slices(rows_, first_, end_);
    }

private:
    PlacedTriangles& placed_of(const OccluderMesh& mesh) { return mesh.bands ? bands_ : placed_; }
    [[nodiscard]] LightPlace light_on(const OccluderInstance& instance) const {
        return instance.mesh->bands ? light_.in_object(*instance.scene_from_object) : light_;
    }
    /// With its triangles; `light` in the object's space.
    OccluderBlock written(const OccluderMesh& mesh, std::size_t block, const LightPlace& light) {
        return mesh.bands ? mesh.bands->written(mesh.blocks[block], block, light, columns_) : mesh.blocks[block];
    }
    void make_room(PlacedTriangles& placed, std::size_t count) {
        if (placed.count + count > PlacedTriangles::capacity)
            raster_triangles(rows_, first_, end_, placed);
    }

    Rows& rows_;
    std::int32_t first_, end_;
    LightPlace light_;
    PlacedTriangles placed_, bands_;
    StrandBands::Columns columns_;
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
    const LightPlace light =
        map != nullptr ? LightPlace{.at = map->lamp, .is_directional = false} : light_of(rows.layout.frame);
    parallel_blocks(
        rows.layout.rows.size(), slices_per_task(rows, occluders), progress, [&](std::size_t begin, std::size_t end) {
            SlicesRaster slices(rows, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end), light);
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
