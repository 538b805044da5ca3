// SPDX-License-Identifier: GPL-3.0-or-later
// A picture is the same whatever renders it: by any number of threads, as a whole or in parts.
#pragma once
#include "support/one_point.hpp"
#include <doctest/doctest.h>

namespace tyndall::support {
/// Planes by one thread, of a frame of 21 x 21 pixels at least, which are those by four; and a region's are a crop of them,
/// bit for bit.
inline render::Film check_whole_and_part(const Scene& scene, const Camera& camera, render::FrameConfig config) {
    config.thread_count = 1;
    config.shafts.shares_strata = false; // what pixels share ends at a region's border
    render::Film one = film_of(scene, camera, config);
    config.thread_count = 4;
    const render::Film four = film_of(scene, camera, config);
    const render::Region part{5, 7, 18, 21};
    config.region = part;
    const render::Film crop = film_of(scene, camera, config);
    for (std::size_t plane = 0; plane < one.planes.size(); ++plane) {
        const std::vector<float>& values = one.planes[plane].values;
        CHECK(four.planes[plane].values == values);
        const std::size_t channels = values.size() / (std::size_t{one.width_px} * one.height_px),
                          row = (part.x1 - part.x0) * channels;
        for (std::size_t y = part.y0; y < part.y1; ++y)
            for (std::size_t i = 0; i < row; ++i)
                REQUIRE(crop.planes[plane].values[(y - part.y0) * row + i] ==
                        values[(y * one.width_px + part.x0) * channels + i]);
    }
    return one;
}
} // namespace tyndall::support
