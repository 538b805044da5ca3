// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/air_columns.hpp"
#include "core/parallel.hpp"
#include "light_shafts/heterogeneity_kernel.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
static PictureGrid make_grid(const Camera& camera, float cell_px) {
    const auto nodes = [&](std::uint32_t size_px) {
        return static_cast<std::uint32_t>(std::ceil(static_cast<float>(size_px) / cell_px)) + 1;
    };
    const float per_x = static_cast<float>(camera.width_px) / (camera.window_right - camera.window_left) / cell_px,
                per_y = static_cast<float>(camera.height_px) / (camera.window_top - camera.window_bottom) / cell_px;
    const vec3 right(camera.world_from_camera[0]), up(camera.world_from_camera[1]), forward = camera.forward();
    PictureGrid grid{.is_orthographic = camera.kind == CameraKind::Orthographic,
                     .x = per_x * right,
                     .y = per_y * up,
                     .depth = forward,
                     .offset = -vec2(per_x * camera.window_left, per_y * camera.window_bottom),
                     .plane_m = glm::dot(forward, camera.ray(0, 0).origin),
                     .width = nodes(camera.width_px),
                     .height = nodes(camera.height_px)};
    if (grid.is_orthographic)
        grid.offset -= vec2(glm::dot(grid.x, camera.position()), glm::dot(grid.y, camera.position()));
    return grid;
}

/// As far apart at their far ends as steps are long, as long as that is some pixels.
static float cell_px(const Camera& camera, float step_m, float last_m) {
    const float px_per_m = static_cast<float>(camera.width_px) / (camera.window_right - camera.window_left) /
                           (camera.kind == CameraKind::Orthographic ? 1.0f : last_m);
    return std::clamp(std::abs(px_per_m) * step_m, 2.0f, 32.0f);
}

AirColumns::AirColumns(const Media& media, const Camera& camera, const AirTexture& air, float offset, float most_depth,
                       const Progress& progress)
    : media_(media), camera_(camera), offset_(offset) {
    // Rays end at surfaces, halfway on average: then they have as many steps as they would have alone.
    step_count_ = air.most_points();
    find_ends(most_depth, progress);
    if (is_empty())
        return;
    cell_px_ = cell_px(camera, step_m_, last_m());
    grid_ = make_grid(camera, cell_px_);
    const std::size_t steps = step_count_;
    texture_.resize(std::size_t{grid_.width} * grid_.height * steps);
    parallel_blocks(std::size_t{grid_.width} * grid_.height, 64, progress, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<MediumSegment> segments;
        thread_local std::vector<float> at_m, weights;
        at_m.resize(steps), weights.resize(steps);
        for (std::size_t step = 0; step < steps; ++step)
            at_m[step] = first_m_ + (static_cast<float>(step) + offset_) * step_m_;
        for (std::size_t column = begin; column < end; ++column) {
            segments.clear();
            const ViewRay along = ray(column);
            clip_to_media(media_, along, segments);
            std::ranges::fill(weights, 0.0f);
            for (const MediumSegment& segment : segments) {
                const auto step_at = [&](float t) {
                    return std::clamp((t - first_m_) / step_m_, 0.0f, static_cast<float>(steps));
                };
                std::fill(weights.begin() + static_cast<int>(step_at(segment.near_m)),
                          weights.begin() + static_cast<int>(std::ceil(step_at(segment.far_m))), 1.0f);
            }
            air.find({.origin = along.origin,
                      .direction = along.direction,
                      .at_m = at_m,
                      .weights = weights,
                      .step_m = step_m_},
                     std::span(texture_).subspan(column * steps, steps));
        }
    });
}

static ViewRay endless(const Ray& ray) {
    return {ray.origin, ray.direction, 0.0f, std::numeric_limits<float>::infinity()};
}

ViewRay AirColumns::ray(std::size_t column) const {
    return endless(camera_.ray(cell_px_ * static_cast<float>(column % grid_.width),
                               cell_px_ * static_cast<float>(column / grid_.width)));
}

void AirColumns::find_ends(float most_depth, const Progress& progress) {
    float first_m = std::numeric_limits<float>::infinity(), last_m = 0.0f;
    std::vector<MediumSegment> segments;
    constexpr std::uint32_t rays_per_side = 48;
    progress.poll();
    for (std::uint32_t y = 0; y <= rays_per_side; ++y)
        for (std::uint32_t x = 0; x <= rays_per_side; ++x) {
            segments.clear();
            const auto at = [](std::uint32_t i, std::uint32_t size_px) {
                return static_cast<float>(i) * static_cast<float>(size_px) / rays_per_side;
            };
            clip_to_media(media_, endless(camera_.ray(at(x, camera_.width_px), at(y, camera_.height_px))), segments);
            float depth = 0.0f;
            for (const MediumSegment& segment : segments) {
                const Rgb sigma_t = media_.sigma_t_per_m(segment.set);
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
    first_m_ = first_m;
    step_m_ = first_m < last_m ? (last_m - first_m) / static_cast<float>(step_count_) : 0.0f;
}

ColumnLight AirColumns::find(const DirectionalScatter& light, const Progress& progress) const {
    ColumnLight columns;
    const std::size_t steps = step_count_;
    columns.light.resize(texture_.size());
    columns.textured.resize(texture_.size());
    parallel_blocks(std::size_t{grid_.width} * grid_.height, 64, progress, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<MediumSegment> segments;
        thread_local std::vector<ScatterPiece> pieces;
        thread_local std::vector<float> at_m, shares, weights;
        at_m.resize(steps), shares.resize(steps), weights.resize(steps);
        for (std::size_t step = 0; step < steps; ++step)
            at_m[step] = first_m_ + (static_cast<float>(step) + offset_) * step_m_;
        const auto step_at = [&](float t) {
            return std::clamp((t - first_m_) / step_m_, 0.0f, static_cast<float>(steps));
        };
        for (std::size_t column = begin; column < end; ++column) {
            segments.clear(), pieces.clear();
            const MediaRay clipped = clip_to_media(media_, ray(column), segments);
            light.append_pieces(clipped.clipped, segments, pieces);
            std::ranges::fill(weights, 0.0f);
            for (const ScatterPiece& piece : pieces) {
                const float from = step_at(piece.near_m), to = step_at(piece.far_m);
                if (!(from < to))
                    continue;
                const auto first = static_cast<std::size_t>(from), past = static_cast<std::size_t>(std::ceil(to));
                for (std::size_t step = first; step < past; ++step)
                    shares[step] =
                        std::min(to, static_cast<float>(step + 1)) - std::max(from, static_cast<float>(step));
                air_steps::add_piece(piece, step_m_,
                                     {.at_m = at_m.data() + first,
                                      .shares = shares.data() + first,
                                      .weights = weights.data() + first,
                                      .count = past - first});
            }
            float sum = 0.0f, textured = 0.0f;
            for (std::size_t step = 0; step < steps; ++step) {
                const std::size_t at = column * steps + step;
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
