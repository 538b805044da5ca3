// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/air_columns.hpp"
#include "core/huge_pages.hpp"
#include "light_shafts/heterogeneity_kernel.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
namespace {
constexpr std::uint32_t steps_at_once = 16;

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

Camera camera_of_columns(const Camera& camera) {
    if (!camera.is_panoramic() || camera.panorama.kind == PanoramaKind::Equirectangular)
        return camera;
    constexpr float most_px = 1 << 14;
    const vec2 turns = camera.panorama.turns({0.0f, 0.0f, -1.0f});
    const float px_per_rad = std::abs(px_per_window_m(camera)) / turns.x;
    const auto pixels = [&](float angle_rad) {
        return static_cast<std::uint32_t>(std::clamp(px_per_rad * angle_rad, 1.0f, most_px));
    };
    Camera around = camera;
    around.panorama = {};
    around.window_left = -pi, around.window_right = pi;
    around.window_bottom = -0.5f * pi, around.window_top = 0.5f * pi;
    around.width_px = pixels(2.0f * pi), around.height_px = pixels(pi);
    return around;
}

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
    AirGrid grid{.kind = camera.kind,
                 .x = per_x * right,
                 .y = per_y * up,
                 .depth = camera.forward(),
                 .per_rad = {per_x, per_y},
                 .offset = -vec2(per_x * camera.window_left, per_y * camera.window_bottom),
                 .plane_m = glm::dot(camera.forward(), camera.ray(0, 0).origin),
                 .width = columns(camera.width_px),
                 .height = columns(camera.height_px),
                 .cell_px = cell_px,
                 .first_m = first_m,
                 .step_m = step_m,
                 .step_count = step_count};
    if (camera.is_panoramic()) { // no seam within the frame: it lies opposite of its middle
        const float middle = 0.5f * (camera.window_left + camera.window_right);
        grid.x = std::cos(middle) * right - std::sin(middle) * camera.forward();
        grid.y = up;
        grid.depth = std::sin(middle) * right + std::cos(middle) * camera.forward();
        grid.offset.x = per_x * (middle - camera.window_left);
    }
    if (is_orthographic)
        grid.offset -= vec2(glm::dot(grid.x, camera.position()), glm::dot(grid.y, camera.position()));
    return grid;
}

AirColumns::AirColumns(const Media& media, const Camera& camera, const AirGrid& grid, const AirTexture& air,
                       float offset, std::vector<const DirectionalScatter*> lights)
    : media_(media), camera_(camera), grid_(grid), air_(air), lights_(std::move(lights)), ready_(grid.column_count()) {
    for (std::uint32_t step = 0; step < grid.step_count; ++step)
        at_m_.push_back(grid.first_m + (static_cast<float>(step) + offset) * grid.step_m);
    const std::size_t size = grid.column_count() * grid.step_count;
    for (std::size_t light = 0; light < lights_.size(); ++light) {
        Sums& sums = sums_.emplace_back(std::make_unique_for_overwrite<float[]>(size),
                                        std::make_unique_for_overwrite<float[]>(size));
        prefer_huge_pages(sums.light.get(), size * sizeof(float));
        prefer_huge_pages(sums.textured.get(), size * sizeof(float));
    }
}

void AirColumns::reach(std::size_t column, std::uint32_t count) {
    constexpr std::uint32_t is_growing = 1;
    count = std::min((count + steps_at_once - 1) / steps_at_once * steps_at_once, grid_.step_count);
    std::atomic<std::uint32_t>& ready = ready_[column];
    std::uint32_t seen = ready.load(std::memory_order_acquire);
    while (seen < count) // a multiple of 16, which the lowest bit does not change
        if ((seen & is_growing) != 0)
            seen = ready.load(std::memory_order_acquire);
        else if (ready.compare_exchange_weak(seen, seen | is_growing, std::memory_order_acquire)) {
            try {
                extend(column, seen, count);
            } catch (...) {
                ready.store(seen, std::memory_order_release);
                throw;
            }
            ready.store(count, std::memory_order_release);
            return;
        }
}

void AirColumns::extend(std::size_t column, std::uint32_t begin, std::uint32_t end) {
    thread_local std::vector<MediumSegment> segments;
    thread_local std::vector<float> is_in_media, texture;
    segments.clear();
    const MediaRay along = clip_to_media(media_,
                                         endless(camera_.ray(grid_.cell_px * static_cast<float>(column % grid_.width),
                                                             grid_.cell_px * static_cast<float>(column / grid_.width))),
                                         segments);
    is_in_media.assign(grid_.step_count, 0.0f);
    texture.resize(end - begin);
    for (const MediumSegment& segment : segments)
        std::fill(is_in_media.begin() + static_cast<std::ptrdiff_t>(step_at(segment.near_m)),
                  is_in_media.begin() + static_cast<std::ptrdiff_t>(std::ceil(step_at(segment.far_m))), 1.0f);
    air_.find({.origin = along.clipped.origin,
               .direction = along.clipped.direction,
               .at_m = std::span<const float>(at_m_).subspan(begin, end - begin),
               .weights = std::span<const float>(is_in_media).subspan(begin, end - begin),
               .step_m = grid_.step_m,
               .first = begin},
              texture);
    const std::size_t first = column * grid_.step_count;
    for (std::size_t light = 0; light < lights_.size(); ++light)
        add_up(*lights_[light], along.clipped, segments, begin, texture, &sums_[light].light[first],
               &sums_[light].textured[first]);
}

void AirColumns::add_up(const DirectionalScatter& light, const ViewRay& clipped,
                        std::span<const MediumSegment> segments, std::uint32_t begin, std::span<const float> texture,
                        float* light_sums, float* textured_sums) const {
    thread_local std::vector<ScatterPiece> pieces;
    pieces.clear();
    light.append_pieces(clipped, segments, pieces);
    float sum = begin > 0 ? light_sums[begin - 1] : 0.0f, textured = begin > 0 ? textured_sums[begin - 1] : 0.0f;
    const auto past = begin + static_cast<std::uint32_t>(texture.size());
    for (std::uint32_t start = begin; start < past; start += steps_at_once) {
        std::array<float, steps_at_once> shares, weights{};
        for (const ScatterPiece& piece : pieces) {
            const float from = std::max(step_at(piece.near_m), static_cast<float>(start)),
                        to = std::min(step_at(piece.far_m), static_cast<float>(start + steps_at_once));
            if (!(from < to))
                continue;
            const std::size_t first = static_cast<std::size_t>(from) - start,
                              end = static_cast<std::size_t>(std::ceil(to)) - start;
            for (std::size_t step = first; step < end; ++step)
                shares[step] = std::min(to, static_cast<float>(start + step + 1)) -
                               std::max(from, static_cast<float>(start + step));
            air_steps::add_piece(piece, grid_.step_m,
                                 {.at_m = at_m_.data() + start + first,
                                  .shares = shares.data() + first,
                                  .weights = weights.data() + first,
                                  .count = end - first});
        }
        for (std::size_t step = 0; step < steps_at_once; ++step) {
            sum += weights[step];
            textured += weights[step] * texture[start - begin + step];
            light_sums[start + step] = sum;
            textured_sums[start + step] = textured;
        }
    }
}
} // namespace tyndall::light_shafts
