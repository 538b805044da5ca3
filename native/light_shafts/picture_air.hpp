// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air for the rays of a picture, under suns: looked up in columns of air some pixels apart, and weighted
// for each ray by where it is lit.
// Data flow: rays -> order of coarse rows, 9 bytes per ray -> per row and 16 rays: lit blocks -> where there are any, the
//           columns around two of the rays, made when first met: texture and light of each sun, 8 bytes per step -> what
//           both have between four columns, lit lines -> light, textured light -> their ratio.
// Bound:    full HD: 14,000 columns of up to 128 steps, and per packet of 16 rays one ray's columns and the lit lines, which
//           take a third of the time; the rest is reading rays twice, in two orders.
#pragma once
#include "light_shafts/air_columns.hpp"
#include "light_shafts/coarse_rows.hpp"
#include "light_shafts/prepared_lights.hpp"

namespace tyndall::light_shafts {
class PictureAir {
public:
    /// All lights must fit. All arguments must outlive this.
    PictureAir(const PreparedLights& prepared, const Camera& camera, const AirTexture& air, const Turn& turn);
    /// Whether these lights and this air are better asked so than ray by ray.
    [[nodiscard]] static bool fits(const PreparedLights& prepared, const AirTexture& air, const Turn& turn);
    /// False: columns lie too far apart for what is painted.
    [[nodiscard]] bool shows_paint() const;
    /// Of the rays `asked`; those that are dark keep what they have, and so do those that have to be asked one by one, which
    /// it returns. Throws Cancelled.
    [[nodiscard]] std::vector<std::uint32_t> find(std::span<const ViewRay> rays, std::span<const std::uint32_t> asked,
                                                  std::span<float> heterogeneity, const Progress& progress) const;

private:
    struct AskedBeam {
        const CoarseRows* rows;
        float weight;
    };
    const AirTexture& air_;
    Camera camera_; ///< Of the columns.
    AirGrid grid_;
    std::vector<AskedBeam> beams_;        ///< One of each light of the columns.
    std::unique_ptr<AirColumns> columns_; ///< They grow as they are asked for.
};
} // namespace tyndall::light_shafts
