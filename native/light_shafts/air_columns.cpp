// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/air_columns.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "light_shafts/air_columns_kernel.hpp"
#include "light_shafts/heterogeneity_kernel.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
namespace {
constexpr std::size_t columns_per_block = 32;

ViewRay endless(const Ray& ray) { return {ray.origin, ray.direction, 0.0f, std::numeric_limits<float>::infinity()}; }

/// Where media begin and end along rays all over the picture.
std::pair<float, float> find_ends(const Media& media, const Camera& camera, float most_depth) {
    float first_m = std::numeric_limits<float>::infinity(), last_m = 0.0f;
    std::vector<MediumSegment> segments;
    constexpr std::uint32_t rays_per_side = 48;
    const auto at = [](std::uint32_t i, std::uint32_t size_px) {
        return static_cast<float>(i) * static_cast<float>(size_px) / rays_per_side;
    };
    for (std::uint32_t y = 0; y <= rays_per_side; ++y)
        for (std::uint32_t x = 0; x <= rays_per_side; ++x) {
            segments.clear();
            clip_to_media(media, endless(camera.ray(at(x, camera.width_px), at(y, camera.height_px))), segments);
            float depth = 0.0f;
            for (const MediumSegment& segment : segments) {
                const Rgb sigma_t = media.sigma_t_per_m(segment.set);
                const float least = std::min({sigma_t.x, sigma_t.y, sigma_t.z});
                float length_m = segment.far_m - segment.near_m;
                if (least * length_m > most_depth - depth)
                    length_m = std::max(0.0f, most_depth - depth) / least;
                depth += least * length_m;
                if (length_m > 0.0f) {
                    first_m = std::min(first_m, segment.near_m);
                    last_m = std::max(last_m, segment.near_m + length_m);
                }
            }
        }
    return {first_m, last_m};
}

float px_per_window_m(const Camera& camera) {
    return static_cast<float>(camera.width_px) / (camera.window_right - camera.window_left);
}
} // namespace

AirGrid make_air_grid(const Media& media, const Camera& camera, const AirTexture& air, float most_depth) {
    const auto [first_m, last_m] = find_ends(media, camera, most_depth);
    const std::uint32_t step_count = air.most_points();
    const float step_m = first_m < last_m ? (last_m - first_m) / static_cast<float>(step_count) : 0.0f;
    const bool is_orthographic = camera.kind == CameraKind::Orthographic;
    const float cell_px =
        std::clamp(std::abs(px_per_window_m(camera)) * step_m / (is_orthographic ? 1.0f : last_m), 1.0f, 32.0f);
    const auto columns = [&](std::uint32_t size_px) {
        return static_cast<std::uint32_t>(std::ceil(static_cast<float>(size_px) / cell_px)) + 1;
    };
    const float per_x = px_per_window_m(camera) / cell_px,
                per_y = static_cast<float>(camera.height_px) / (camera.window_top - camera.window_bottom) / cell_px;
    const vec3 right(camera.world_from_camera[0]), up(camera.world_from_camera[1]);
    AirGrid grid{.is_orthographic = is_orthographic,
                 .x = per_x * right,
                 .y = per_y * up,
                 .depth = camera.forward(),
                 .offset = -vec2(per_x * camera.window_left, per_y * camera.window_bottom),
                 .plane_m = glm::dot(camera.forward(), camera.ray(0, 0).origin),
                 .width = columns(camera.width_px),
                 .height = columns(camera.height_px),
                 .cell_px = cell_px,
                 .first_m = first_m,
                 .step_m = step_m,
                 .step_count = step_count};
    if (is_orthographic)
        grid.offset -= vec2(glm::dot(grid.x, camera.position()), glm::dot(grid.y, camera.position()));
    return grid;
}

void AirNeeds::add(std::span<const ViewRay> rays) {
    constexpr std::size_t capacity = 256;
    std::array<std::uint32_t, capacity> cells, steps;
    for (std::size_t start = 0; start < rays.size(); start += capacity) {
        const auto some = rays.subspan(start, std::min(capacity, rays.size() - start));
        air_columns::find_cells(grid_, some, cells, steps);
        for (std::size_t ray = 0, next; ray < some.size(); ray = next) {
            std::uint32_t most = 0;
            for (next = ray; next < some.size() && cells[next] == cells[ray]; ++next)
                most = std::max(most, steps[next]);
            std::atomic<std::uint32_t>& of_cell = steps_[cells[ray]];
            std::uint32_t before = of_cell.load(std::memory_order_relaxed);
            while (before < most && !of_cell.compare_exchange_weak(before, most, std::memory_order_relaxed))
                ;
        }
    }
}

std::vector<std::uint32_t> AirNeeds::of_columns() const {
    static constexpr std::size_t before = static_cast<std::size_t>(most_span) + 2, after = before - 1;
    const auto most_around = [](std::size_t at, std::size_t count, const auto& value_at) {
        std::uint32_t most = 0;
        for (std::size_t i = at - std::min(at, before); i < std::min(at + after + 1, count); ++i)
            most = std::max(most, value_at(i));
        return most;
    };
    std::vector<std::uint32_t> along_x(steps_.size()), most(steps_.size());
    for (std::size_t cell = 0; cell < steps_.size(); ++cell) {
        const std::size_t row = cell / grid_.width * grid_.width;
        along_x[cell] = most_around(cell - row, grid_.width, [&](std::size_t x) { return steps_[row + x].load(); });
    }
    for (std::size_t cell = 0; cell < steps_.size(); ++cell) {
        const std::size_t x = cell % grid_.width;
        most[cell] =
            most_around(cell / grid_.width, grid_.height, [&](std::size_t y) { return along_x[y * grid_.width + x]; });
        // Blocks of lines lie a little farther along a neighbour that is closer to the sun.
        most[cell] = std::min((most[cell] + most[cell] / 8 + 15) / 16 * 16, grid_.step_count);
    }
    return most;
}

AirColumns::AirColumns(const Media& media, const Camera& camera, const AirGrid& grid, const AirNeeds& needs,
                       const AirTexture& air, float offset, const Progress& progress)
    : media_(media), camera_(camera), grid_(grid), steps_(needs.of_columns()),
      texture_(std::make_unique_for_overwrite<float[]>(grid.column_count() * grid.step_count)) {
    prefer_large(texture_.get());
    for (std::uint32_t step = 0; step < grid.step_count; ++step)
        at_m_.push_back(grid.first_m + (static_cast<float>(step) + offset) * grid.step_m);
    parallel_blocks(grid.column_count(), columns_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<MediumSegment> segments;
        thread_local std::vector<float> weights;
        for (std::size_t column = begin; column < end; ++column) {
            const std::size_t steps = steps_[column];
            if (steps == 0)
                continue;
            segments.clear();
            const ViewRay along = ray(column);
            clip_to_media(media_, along, segments);
            weights.assign(steps, 0.0f);
            for (const MediumSegment& segment : segments) {
                const auto step_at = [&](float t) {
                    return std::clamp((t - grid_.first_m) / grid_.step_m, 0.0f, static_cast<float>(steps));
                };
                std::fill(weights.begin() + static_cast<std::ptrdiff_t>(step_at(segment.near_m)),
                          weights.begin() + static_cast<std::ptrdiff_t>(std::ceil(step_at(segment.far_m))), 1.0f);
            }
            air.find({.origin = along.origin,
                      .direction = along.direction,
                      .at_m = std::span<const float>(at_m_).first(steps),
                      .weights = weights,
                      .step_m = grid_.step_m},
                     {texture_.get() + column * grid_.step_count, steps});
        }
    });
}

void AirColumns::prefer_large(float* values) const {
    // Where few columns are asked, small pages leave out what lies between them.
    if (2 * std::ranges::count(steps_, 0u) < std::ssize(steps_))
        prefer_huge_pages(values, grid_.column_count() * grid_.step_count * sizeof(float));
}

ViewRay AirColumns::ray(std::size_t column) const {
    return endless(camera_.ray(grid_.cell_px * static_cast<float>(column % grid_.width),
                               grid_.cell_px * static_cast<float>(column / grid_.width)));
}

ColumnLight AirColumns::find(const DirectionalScatter& light, const Progress& progress) const {
    const std::size_t size = grid_.column_count() * grid_.step_count;
    ColumnLight columns{std::make_unique_for_overwrite<float[]>(size), std::make_unique_for_overwrite<float[]>(size)};
    prefer_large(columns.light.get());
    prefer_large(columns.textured.get());
    parallel_blocks(grid_.column_count(), columns_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<MediumSegment> segments;
        thread_local std::vector<ScatterPiece> pieces;
        thread_local std::vector<float> shares, weights;
        for (std::size_t column = begin; column < end; ++column) {
            const std::size_t steps = steps_[column];
            if (steps == 0)
                continue;
            segments.clear(), pieces.clear();
            const MediaRay clipped = clip_to_media(media_, ray(column), segments);
            light.append_pieces(clipped.clipped, segments, pieces);
            shares.resize(steps);
            weights.assign(steps, 0.0f);
            const auto step_at = [&](float t) {
                return std::clamp((t - grid_.first_m) / grid_.step_m, 0.0f, static_cast<float>(steps));
            };
            for (const ScatterPiece& piece : pieces) {
                const float from = step_at(piece.near_m), to = step_at(piece.far_m);
                if (!(from < to))
                    continue;
                const auto first = static_cast<std::size_t>(from), past = static_cast<std::size_t>(std::ceil(to));
                for (std::size_t step = first; step < past; ++step)
                    shares[step] =
                        std::min(to, static_cast<float>(step + 1)) - std::max(from, static_cast<float>(step));
                air_steps::add_piece(piece, grid_.step_m,
                                     {.at_m = at_m_.data() + first,
                                      .shares = shares.data() + first,
                                      .weights = weights.data() + first,
                                      .count = past - first});
            }
            float sum = 0.0f, textured = 0.0f;
            for (std::size_t step = 0; step < steps; ++step) {
                const std::size_t at = column * grid_.step_count + step;
                sum += weights[step];
                textured += weights[step] * texture_[at];
                columns.light[at] = sum;
                columns.textured[at] = textured;
            }
        }
    });
    return columns;
}
} // namespace tyndall::light_shafts
