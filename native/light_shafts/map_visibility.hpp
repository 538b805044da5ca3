// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by walking along the texels of a light's depth map: what rows rectified from the map converge to.
// Based on: Amanatides and Woo, A Fast Voxel Traversal Algorithm, Eurographics 1987, in two dimensions.
// Differs:  on a lamp's face a view ray is straight but not evenly spaced: the borders of texels are found one by one,
//           and whether a stretch is lit is exact within each texel.
// Bound:    one look-up per texel that a ray crosses: some hundred times slower than rows; for the few rays without.
#pragma once
#include "light_shafts/shadow_map.hpp"
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts {
class MapVisibility final : public Visibility {
public:
    explicit MapVisibility(ShadowMap map) : map_(std::move(map)) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const override;
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }
    [[nodiscard]] const ShadowMap& map() const { return map_; }

private:
    ShadowMap map_;
    Statistics statistics_;
};
} // namespace tyndall::light_shafts
