// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strand_bands.hpp"
#include "core/parallel.hpp"
#include "light_shafts/strand_bands_kernel.hpp"
#include "scene/strand_bends.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
static constexpr float thinnest_m = 1e-30f; // of a ring: a zero has no sign to compare

LightPlace LightPlace::in_object(const mat4& scene_from_object) const {
    const glm::dmat4 object_from_scene = glm::inverse(glm::dmat4(scene_from_object));
    return {vec3(object_from_scene * glm::dvec4(at, is_directional ? 0.0 : 1.0)), is_directional};
}

static std::vector<std::uint32_t> order_of(const Strands& strands) {
    std::vector<vec3> positions;
    std::vector<uvec3> triples;
    Bounds3 bounds;
    for (std::uint32_t strand = 0; strand < strands.strand_count(); ++strand) {
        const std::span<const vec4> points = strands.points_of(strand);
        const auto first = static_cast<std::uint32_t>(positions.size());
        triples.emplace_back(first, first + 1, first + 2);
        for (const std::size_t at : {std::size_t{0}, points.size() / 2, points.size() - 1})
            bounds.grow(positions.emplace_back(points[at]));
    }
    return order_in_space(positions, triples, bounds);
}

StrandBands::StrandBands(const Strands& strands) {
    const auto push = [&](const vec3& centre, float radius_m) {
        rings_[X].push_back(centre.x);
        rings_[Y].push_back(centre.y);
        rings_[Z].push_back(centre.z);
        rings_[Radius].push_back(radius_m);
    };
    push(vec3(0.0f), -thinnest_m);
    StrandBends bends(strands);
    for (const std::uint32_t strand : order_of(strands)) {
        float sign = -1.0f;
        for (const StrandPoint& at : bends.of(strand)) {
            push(at.centre, sign * std::max(at.radius_m, thinnest_m));
            sign = 1.0f;
        }
    }
    ring_count_ = rings_[X].size() - 1;
    const vec3 last(rings_[X].back(), rings_[Y].back(), rings_[Z].back());
    for (std::size_t i = 0; i < pieces_per_block + 17; ++i)
        push(last, -thinnest_m);
}

OccluderBlock StrandBands::block(std::size_t index) const {
    OccluderBlock block;
    block.stride = block.count = OccluderBlock::capacity;
    const std::size_t first = index * pieces_per_block, end = std::min(first + pieces_per_block + 1, ring_count_);
    for (std::size_t ring = first + 1; ring < end + 1; ++ring) {
        const vec3 centre(rings_[X][ring], rings_[Y][ring], rings_[Z][ring]);
        block.bounds.grow(centre - std::abs(rings_[Radius][ring]));
        block.bounds.grow(centre + std::abs(rings_[Radius][ring]));
    }
    return block;
}

OccluderBlock StrandBands::written(const OccluderBlock& block, std::size_t index, const LightPlace& light,
                                   Columns& columns) const {
    const std::size_t first = index * pieces_per_block + 1;
    write_bands({&rings_[X][first], &rings_[Y][first], &rings_[Z][first], &rings_[Radius][first]}, light,
                columns.data());
    OccluderBlock result = block;
    result.columns = columns.data();
    return result;
}

std::unique_ptr<const OccluderMesh> make_band_mesh(const Strands& strands) {
    auto mesh = std::make_unique<OccluderMesh>();
    mesh->bands = std::make_shared<const StrandBands>(strands);
    mesh->blocks.resize(mesh->bands->block_count());
    parallel_for(
        mesh->blocks.size(), Progress(), [&](std::size_t b) { mesh->blocks[b] = mesh->bands->block(b); }, 16);
    for (const OccluderBlock& block : mesh->blocks)
        mesh->bounds.grow(block.bounds);
    return mesh;
}
} // namespace tyndall::light_shafts
