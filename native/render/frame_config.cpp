// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "render/frame.hpp"

namespace tyndall::render {
Region checked_region(const FrameConfig& config, const Camera& camera) {
    require(1 <= config.pixel_samples && config.pixel_samples <= 65536, "pixel_samples is ", config.pixel_samples,
            ", outside [1, 65536]");
    require(config.first_sample < config.pixel_samples &&
                config.sample_count <= config.pixel_samples - config.first_sample,
            "samples ", config.first_sample, " to ", config.first_sample + config.sample_count, " are not among the ",
            config.pixel_samples, " of a pixel");
    require_in(config.noise_threshold, 0.0f, 1.0f, "noise_threshold");
    require_usable(config.indirect);
    require_in(config.voxel_detail_px, 0.0f, 64.0f, "voxel_detail_px");
    require_in(config.pass_alpha_threshold, 0.0f, 1.0f, "pass_alpha_threshold");
    require(camera.width_px > 0 && camera.height_px > 0, "the camera's frame has no pixels");
    const Region region = config.region.value_or(Region{0, 0, camera.width_px, camera.height_px});
    require(region.x0 < region.x1 && region.y0 < region.y1 && region.x1 <= camera.width_px &&
                region.y1 <= camera.height_px,
            "region [", region.x0, ", ", region.x1, ") x [", region.y0, ", ", region.y1,
            ") does not lie in the frame of ", camera.width_px, " x ", camera.height_px, " pixels");
    return region;
}
} // namespace tyndall::render
