// SPDX-License-Identifier: GPL-3.0-or-later
// Full HD asked of slope rows: grey light of one medium that is not attenuated on its way to it.
#pragma once
#include "light_shafts/row_query_scatter.hpp"
#include "support/shaft_scenes.hpp"
#include <algorithm>
#include <array>

namespace tyndall::bench {
using namespace light_shafts;
inline constexpr std::size_t rays_per_call = 256; // as light_shafts_scatter.cpp asks

inline slope_rows::LayoutConfig layout_config(std::uint32_t lines) {
    return {.lines = lines, .slices_per_line = 0.5f, .memory_limit_bytes = std::size_t{4} << 30};
}

/// Piece `index` of `count` equal ones; coloured if they are several.
inline ScatterPiece make_piece(const ShaftScene& scene, const ViewRay& ray, int index, int count) {
    const Rgb sigma = scene.sigma_t_per_m * (count > 1 ? Rgb(0.8f, 1.0f, 1.2f) : Rgb(1.0f));
    ScatterPiece piece{};
    piece.near_m = ray.far_m * static_cast<float>(index) / static_cast<float>(count);
    piece.far_m = ray.far_m * static_cast<float>(index + 1) / static_cast<float>(count);
    piece.source_per_m = Rgb(scene.sigma_t_per_m);
    piece.depth_per_m = sigma;
    piece.depth_at_near = sigma * piece.near_m;
    return piece;
}

/// One grey piece, as long as any ray, for each ray of a call: light that is not attenuated on its way to the fog.
inline PieceRows make_grey_pieces(const ShaftScene& scene) {
    ViewRay longest{};
    longest.far_m = 1e6f;
    PieceRows rows;
    for (std::size_t ray = 0; ray < rays_per_call; ++ray) {
        rows.pieces.push_back(make_piece(scene, longest, 0, 1));
        rows.end_ray();
    }
    return rows;
}

/// What rays in the picture's order scatter.
inline void query_by_wedge(const slope_rows::Rows& rows, const ShaftScene& scene, const PieceRows& pieces,
                           std::span<Rgb> radiance) {
    const std::span<const ViewRay> rays = scene.rays;
    Progress progress;
    const std::vector<std::uint32_t> order = row_query::by_wedge(rows.layout, rays, progress);
    parallel_blocks(rays.size(), rays_per_call, progress, [&](std::size_t begin, std::size_t end) {
        thread_local row_query::Unanswered unanswered;
        std::array<ViewRay, rays_per_call> some;
        std::array<Rgb, rays_per_call> of_some;
        of_some.fill(Rgb(0.0f));
        for (std::size_t i = begin; i < end; ++i) {
            __builtin_prefetch(&rays[order[i]]);
            __builtin_prefetch(&radiance[order[i]], 1);
        }
        for (std::size_t i = begin; i < end; ++i)
            some[i - begin] = rays[order[i]];
        row_query::add_scattered(rows, std::span(some).first(end - begin), pieces,
                                 std::span(of_some).first(end - begin), {}, unanswered);
        for (std::size_t i = begin; i < end; ++i)
            radiance[order[i]] = of_some[i - begin];
    });
}

} // namespace tyndall::bench
