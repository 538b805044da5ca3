// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air for the rays of a whole picture, under suns: looked up once in columns of air some pixels apart,
// and weighted for each ray by where it is lit.
// Data flow: camera -> columns: texture, and light of each sun, 8 bytes per step -> rays in the order of coarse rows ->
//           per row and 16 rays: 2 columns between 4 each, lit lines -> light, textured light -> their ratio.
// Bound:    full HD: the columns of 33,000 nodes, 64 steps each; per packet of rays as many lines as it scatters at 2,048
//           lines a row, and 2 columns.
#pragma once
#include "light_shafts/air_columns.hpp"
#include "light_shafts/coarse_rows.hpp"
#include "light_shafts/prepared_lights.hpp"

namespace tyndall::light_shafts {
class PictureAir {
public:
    /// Of all lights, which fit; throws Cancelled.
    PictureAir(const PreparedLights& prepared, const Camera& camera, const AirTexture& air, const Turn& turn,
               const Progress& progress);
    /// Whether these lights and this air are better asked so than ray by ray.
    [[nodiscard]] static bool fits(const PreparedLights& prepared, const AirTexture& air, const Turn& turn);
    /// Of those rays that have dark_air, and keep it where they are dark or have no answer here. Throws Cancelled.
    void find(std::span<const ViewRay> rays, std::span<float> heterogeneity, const Progress& progress) const;

private:
    struct AskedBeam {
        const CoarseRows* rows;
        float weight;
        ColumnLight columns;
    };
    AirColumns columns_;
    std::vector<AskedBeam> beams_;
};
} // namespace tyndall::light_shafts
