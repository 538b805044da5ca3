// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strand_bands.hpp"
#include "core/parallel.hpp"
#include "light_shafts/strand_bands_kernel.hpp"
#include "scene/strands.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
/// Between two rings a strand may leave their straight line by this share of its radius.
static constexpr float bend_in_radii = 0.1f;
static constexpr float swell_in_radii = 0.02f; // and be wider or thinner by this, which its shadow is then, too
static constexpr float most_pieces_per_segment = 16.0f;
static constexpr float thinnest_m = 1e-30f; // of a ring: a zero has no sign to compare

LightPlace LightPlace::in_object(const mat4& scene_from_object) const {
    const glm::dmat4 object_from_scene = glm::inverse(glm::dmat4(scene_from_object));
    return {vec3(object_from_scene * glm::dvec4(at, is_directional ? 0.0 : 1.0)), is_directional};
}

bool StrandBands::can_draw(const Strands& strands) {
    return strands.form() == StrandForm::Ribbon || strands.form() == StrandForm::Round;
}

/// Of a segment between the second and the third of four points.
static std::size_t pieces_of_segment(const vec4* p) {
    const vec4 square = p[0] - 2.5f * p[1] + 2.0f * p[2] - 0.5f * p[3],
               cube = 0.5f * (3.0f * (p[1] - p[2]) + p[3] - p[0]);
    // What a curve leaves its chord by is at most an eighth of its second derivative, which is linear.
    const float bend_m = 0.25f * std::max(glm::length(square), glm::length(square + 3.0f * cube));
    const float allowed_m = bend_in_radii * std::max({p[1].w, p[2].w, thinnest_m});
    const float pieces = std::ceil(std::sqrt(bend_m / allowed_m));
    return static_cast<std::size_t>(std::clamp(pieces, 1.0f, most_pieces_per_segment));
}

/// Of a strand, so dense that it is straight between them.
static void find_rings(const Strands& strands, std::uint32_t strand, std::uint32_t first_segment,
                       std::vector<StrandPoint>& rings) {
    const std::span<const vec4> points = strands.points_of(strand);
    const auto segments = static_cast<std::uint32_t>(points.size() - 3);
    rings.clear();
    for (std::uint32_t segment = 0; segment < segments; ++segment) {
        const std::size_t pieces = pieces_of_segment(&points[segment]);
        for (std::size_t piece = 0; piece < pieces; ++piece)
            rings.push_back(
                strands.on_spline(first_segment + segment, static_cast<float>(piece) / static_cast<float>(pieces)));
    }
    rings.push_back(strands.on_spline(first_segment + segments - 1, 1.0f));
}

/// Whether those between lie on one piece from the first to the last, as wide as it is there.
static bool are_on_one_piece(std::span<const StrandPoint> rings) {
    const StrandPoint &first = rings.front(), &last = rings.back();
    const vec3 way = last.centre - first.centre;
    const float squared = glm::dot(way, way), widest_m = std::max(first.radius_m, last.radius_m);
    float reached = 0.0f;
    return std::ranges::all_of(rings, [&](const StrandPoint& ring) {
        const vec3 from_first = ring.centre - first.centre;
        const float along = glm::dot(from_first, way) / std::max(squared, 1e-36f);
        const bool goes_on = along >= reached && along <= 1.0f + 1e-5f;
        reached = along - 1e-5f;
        return goes_on && glm::length(from_first - along * way) <= bend_in_radii * widest_m &&
               std::abs(first.radius_m + along * (last.radius_m - first.radius_m) - ring.radius_m) <=
                   swell_in_radii * widest_m;
    });
}

/// All but the first, without those that lie on one piece.
static void for_bends(std::span<const StrandPoint> rings, const auto& visit) {
    if (rings.size() <= 2 || are_on_one_piece(rings)) {
        visit(rings.back());
        return;
    }
    const std::size_t middle = rings.size() / 2;
    for_bends(rings.first(middle + 1), visit);
    for_bends(rings.subspan(middle), visit);
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
    std::vector<std::uint32_t> first_segment(strands.strand_count(), 0);
    for (std::uint32_t strand = 0; strand + 1 < first_segment.size(); ++strand)
        first_segment[strand + 1] =
            first_segment[strand] + static_cast<std::uint32_t>(strands.points_of(strand).size() - 3);
    const auto push = [&](const vec3& centre, float radius_m) {
        rings_[X].push_back(centre.x);
        rings_[Y].push_back(centre.y);
        rings_[Z].push_back(centre.z);
        rings_[Radius].push_back(radius_m);
    };
    push(vec3(0.0f), -thinnest_m);
    std::vector<StrandPoint> rings;
    for (const std::uint32_t strand : order_of(strands)) {
        find_rings(strands, strand, first_segment[strand], rings);
        push(rings.front().centre, -std::max(rings.front().radius_m, thinnest_m));
        for_bends(rings, [&](const StrandPoint& at) { push(at.centre, std::max(at.radius_m, thinnest_m)); });
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
