// SPDX-License-Identifier: GPL-3.0-or-later
// Samples of pixels, without what no pass asks for: 44 bytes instead of 172 for a picture with no pass but Combined.
#pragma once
#include "render/film.hpp"
#include <vector>

namespace tyndall::render {
class PackedSamples {
public:
    /// What there is beside radiance, alpha, depth, position and transmittance.
    struct Parts {
        bool has_passes = false;    ///< Normal, colours, light with and without occluders, ambient occlusion.
        bool has_world_lit = false; ///< Of PathSample.
        bool operator==(const Parts&) const = default;
    };
    [[nodiscard]] static Parts parts_for(const PassSet& passes, bool shares_world);

    void push(const PathSample& sample, const Parts& parts);
    [[nodiscard]] PathSample get(std::size_t index, const Parts& parts) const;
    [[nodiscard]] std::size_t bytes() const { return values_.capacity() * sizeof(float); }

private:
    std::vector<float> values_;
};
} // namespace tyndall::render
