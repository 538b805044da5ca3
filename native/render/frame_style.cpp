// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame_style.hpp"

namespace tyndall::render {
FrameStyle::FrameStyle(const Scene& scene, const Camera& camera, const FrameConfig& config, std::uint32_t width_px,
                       std::uint32_t height_px)
    : camera_(camera), config_(config), parameters_(scene, camera, config.transfer_functions, config.reference_light),
      shafts_(width_px, height_px, parameters_.function_count(),
              config.heterogeneity && !is_neutral(*config.heterogeneity)),
      seen_(std::size_t{width_px} * height_px) {
    for (const auto& [function, weight] : config.transfer_functions)
        transfer_functions::require_usable(function);
}

void FrameStyle::add(std::size_t pixel, vec2 place_px, const SeenShafts& shafts) {
    thread_local std::vector<vec2> parameters;
    parameters.clear();
    for (std::size_t function = 0; function < parameters_.function_count() && shafts.meets_medium; ++function)
        parameters.push_back(parameters_.at(function, place_px, seen_[pixel], shafts));
    shafts_.add(pixel, seen_[pixel], shafts, parameters);
}

void FrameStyle::see_shafts(const ViewPath& path, const light_shafts::Shafts& shafts, const Progress& progress) {
    fit_visibility(path, shafts, camera_, parameters_, progress);
    points_ = place_points(path, shafts, parameters_, camera_, config_.transfer_functions, progress);
}

Film FrameStyle::apply(Film film, const Progress& progress) const {
    const auto unstyled = std::make_shared<const UnstyledFilm>(
        UnstyledFilm{.film = std::move(film), .entries = shafts_.resolve(progress), .points = points_});
    Film result = styled(*unstyled, config_.transfer_functions, progress);
    if (config_.keeps_unstyled)
        result.unstyled = unstyled;
    return result;
}
} // namespace tyndall::render
