// SPDX-License-Identifier: GPL-3.0-or-later
// What camera rays meet before any light is asked for, and what each light then gives: apart, so that a light that moved
// is asked anew while rays, materials and the other lights stay.
#pragma once
#include "render/surface_point.hpp"
#include <vector>

namespace tyndall::render {
/// Surface points of camera rays that wait for light.
struct SurfaceWalk {
    /// What light on a point adds to its ray.
    struct Shade {
        Rgb throughput;           ///< Share of the point's light that reaches the camera.
        Rgb radiance;             ///< Of that, per irradiance, 1/sr.
        Rgb cover{0.0f};          ///< Share of what lies behind the point that it hides from the camera.
        std::uint32_t sample = 0; ///< The ray's, among those that were walked.
    };
    /// Points of neighbouring rays in one layer, which are lit together.
    struct Batch {
        std::uint32_t end = 0; ///< It begins where the one before ends.
        std::uint32_t layer = 0;
    };
    std::vector<SurfacePoint> points;
    std::vector<Shade> shades;  ///< Per point.
    std::vector<Batch> batches; ///< Layers of a ray rise.

    void clear() {
        points.clear();
        shades.clear();
        batches.clear();
    }
    /// For one that is kept.
    void shrink_to_fit() {
        points.shrink_to_fit();
        shades.shrink_to_fit();
        batches.shrink_to_fit();
    }
    /// After the points of a layer; none: no batch.
    void end_batch(std::uint32_t layer) {
        const auto end = static_cast<std::uint32_t>(points.size());
        if (end > (batches.empty() ? 0 : batches.back().end))
            batches.push_back({end, layer});
    }
    [[nodiscard]] std::size_t bytes() const {
        return points.capacity() * sizeof(SurfacePoint) + shades.capacity() * sizeof(Shade) +
               batches.capacity() * sizeof(Batch);
    }
};

/// What each light gives to the points of a walk, with occluders and media between, and with nothing between, W/m^2.
struct SurfaceLight {
    struct OfLight {
        std::vector<Rgb> irradiance;
        std::vector<Rgb> unshadowed; ///< Empty where nobody wants it, and of the world.
    };
    std::vector<OfLight> lights; ///< In the order of DirectLight, the world last.

    [[nodiscard]] std::size_t bytes() const {
        std::size_t sum = 0;
        for (const OfLight& light : lights)
            sum += (light.irradiance.capacity() + light.unshadowed.capacity()) * sizeof(Rgb);
        return sum;
    }
};
} // namespace tyndall::render
