// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_partial.hpp"
#include "core/parallel.hpp"
#include "light_shafts/slope_rows_placed_instance.hpp"

namespace tyndall::light_shafts::slope_rows {
namespace {
/// Adds to the slices [first, end).
class PartialSlices {
public:
    PartialSlices(Rows& rows, const PartialShading& shading, std::int32_t first, std::int32_t end)
        : rows_(rows), shading_(shading), first_(first), end_(end) {}

    void add(const Culling& culling, std::uint32_t index) {
        const PartialOccluderInstance& instance = shading_.instances[index];
        const OccluderMesh& mesh = *instance.mesh->geometry;
        const PlacedInstance at(rows_.layout.frame, *instance.scene_from_object, mesh.bounds);
        if (at.needs(culling, mesh.bounds, first_, end_).is_empty())
            return;
        for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
            const OccluderBlock& block = mesh.blocks[b];
            const SliceNeeds needs = at.needs(culling, block.bounds, first_, end_);
            if (needs.is_empty())
                continue;
            make_room(block.count);
            const std::size_t before = placed_.count;
            place_triangles(rows_.layout, needs,
                            {block.columns, block.stride, block.count, at.frame_from_object, at.origin}, placed_,
                            placed_.triangle.data());
            name_triangles(index, b, before);
        }
    }
    void add(const PartialPlacer& place, std::uint32_t index) {
        const PartialOccluderInstance& instance = shading_.instances[index];
        const std::vector<OccluderBlock>& blocks = instance.mesh->geometry->blocks;
        placed_.has_weights = true;
        for (std::size_t b = 0; b < blocks.size(); ++b)
            for (std::size_t start = 0; start < blocks[b].count;) {
                make_room(PlacedTriangles::capacity / 2);
                const std::size_t before = placed_.count;
                start = place(instance, blocks[b], start, first_, end_, placed_);
                name_triangles(index, b, before);
            }
    }
    void finish() {
        raster_partials(rows_, first_, end_, shading_, placed_);
        if (has_placed_)
            summarise_slices(rows_, first_, end_);
    }

private:
    void make_room(std::size_t count) {
        if (placed_.count + count > PlacedTriangles::capacity)
            raster_partials(rows_, first_, end_, shading_, placed_);
    }
    void name_triangles(std::uint32_t instance, std::size_t block, std::size_t first) {
        const std::vector<std::uint32_t>& triangles = shading_.instances[instance].mesh->triangles;
        for (std::size_t i = first; i < placed_.count; ++i) {
            const std::size_t place = block * OccluderBlock::capacity + static_cast<std::size_t>(placed_.triangle[i]);
            placed_.triangle[i] = static_cast<std::int32_t>(triangles[place]);
            placed_.instance[i] = instance;
        }
        has_placed_ |= placed_.count > first;
    }

    Rows& rows_;
    const PartialShading& shading_;
    std::int32_t first_, end_;
    bool has_placed_ = false;
    PlacedPartials placed_;
};

bool may_shade(const Layout& layout, const Culling& culling, const PartialOccluderInstance& instance) {
    const Bounds3& bounds = instance.mesh->geometry->bounds;
    const PlacedInstance at(layout.frame, *instance.scene_from_object, bounds);
    return !at.needs(culling, bounds, 0, layout.slice_count()).is_empty();
}
} // namespace

std::vector<PartialOccluderInstance> that_may_shade(const Layout& layout,
                                                    std::span<const PartialOccluderInstance> instances) {
    const Culling culling(layout);
    std::vector<PartialOccluderInstance> result;
    for (const PartialOccluderInstance& instance : instances)
        if (may_shade(layout, culling, instance))
            result.push_back(instance);
    return result;
}

void raster_partial(Rows& rows, const PartialShading& shading, const Progress& progress, const PartialPlacer& placer) {
    if (rows.layout.rows.empty() || shading.instances.empty())
        return;
    const Culling culling(rows.layout);
    std::vector<std::uint32_t> needed;
    for (std::uint32_t i = 0; i < shading.instances.size(); ++i)
        if (placer || may_shade(rows.layout, culling, shading.instances[i]))
            needed.push_back(i);
    if (needed.empty())
        return;
    parallel_blocks(
        rows.layout.rows.size(), slices_per_range(rows.layout), progress, [&](std::size_t begin, std::size_t end) {
            PartialSlices slices(rows, shading, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
            for (std::size_t i = 0; i < needed.size(); ++i) {
                if (i % 16 == 0)
                    progress.poll();
                if (placer)
                    slices.add(placer, needed[i]);
                else
                    slices.add(culling, needed[i]);
            }
            slices.finish();
        });
}
} // namespace tyndall::light_shafts::slope_rows
