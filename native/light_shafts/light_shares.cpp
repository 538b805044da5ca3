// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_shares.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
static double luminance(const Rgb& radiance) { // Rec. 709
    const double value = 0.2126 * radiance.x + 0.7152 * radiance.y + 0.0722 * radiance.z;
    return std::isfinite(value) ? value : 0.0;
}

LightShares::LightShares(const Media& media, std::span<const ViewRay> rays) {
    constexpr std::size_t ray_count = 256;
    const std::size_t step = std::max<std::size_t>(1, rays.size() / ray_count);
    for (std::size_t index = step / 2; index < rays.size(); index += step) {
        const ViewRay& ray = rays[index];
        rays_.push_back(ray);
        media.segments({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = ray.far_m},
                       segments_);
        if (!media.grids().is_empty())
            append_steps(media, {ray.origin, ray.direction, ray.near_m, ray.far_m},
                         std::span(segments_).subspan(first_segment_.back()), {}, steps_);
        first_segment_.push_back(static_cast<std::uint32_t>(segments_.size()));
    }
    has_grids_ = !media.grids().is_empty();
    local_rays_.assign(media, rays_, first_segment_, segments_);
}

void LightShares::add(const DirectionalScatter& light) {
    double sum = 0.0;
    std::vector<ScatterPiece> pieces;
    for (std::size_t ray = 0; ray < rays_.size(); ++ray) {
        pieces.clear();
        const auto segments =
            std::span(segments_).subspan(first_segment_[ray], first_segment_[ray + 1] - first_segment_[ray]);
        if (has_grids_)
            light.append_grid_pieces(rays_[ray], segments, steps_, ray, pieces);
        else
            light.append_pieces(rays_[ray], segments, pieces);
        for (const ScatterPiece& piece : pieces)
            sum += luminance(scattered(piece, piece.near_m, piece.far_m));
    }
    luminance_.push_back(sum);
    sum_ += sum;
}

void LightShares::add(const LocalScatter& light) {
    std::vector<Rgb> radiance(rays_.size(), Rgb(0.0f));
    if (has_grids_) {
        std::vector<std::uint32_t> rows(rays_.size());
        std::iota(rows.begin(), rows.end(), 0u);
        light.scatter_in_grids(local_rays_, steps_, rows, nullptr, radiance, {});
    } else {
        light.add_scattered(local_rays_, nullptr, radiance, {}, {});
    }
    double sum = 0.0;
    for (const Rgb& of_ray : radiance)
        sum += luminance(of_ray);
    luminance_.push_back(sum);
    sum_ += sum;
}

float LightShares::share(std::size_t sample) const {
    return sum_ > 0.0 ? static_cast<float>(luminance_[sample] / sum_) : 1.0f;
}

float error_of_share(float error_target, float share) {
    constexpr float coarsest = 0.3f;
    return share > 0.0f ? std::clamp(error_target / std::sqrt(share), error_target, std::max(coarsest, error_target))
                        : std::max(coarsest, error_target);
}
} // namespace tyndall::light_shafts
