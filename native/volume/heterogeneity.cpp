// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/heterogeneity.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <bit>

namespace tyndall {
static void require_usable(const PaintedVolume& volume, float lowest, float highest, const char* name) {
    const std::size_t count = std::size_t{volume.size[0]} * volume.size[1] * volume.size[2];
    require(volume.values.size() == count, name, " has ", volume.values.size(), " values, but a size of ",
            volume.size[0], " x ", volume.size[1], " x ", volume.size[2]);
    for (std::size_t at = 0; at < count; ++at)
        require(lowest <= volume.values[at] && volume.values[at] <= highest, // false for a NaN, too
                name, " is ", volume.values[at], " at voxel (", at % volume.size[0], ", ",
                at / volume.size[0] % volume.size[1], ", ", at / volume.size[0] / volume.size[1], "), outside [",
                lowest, ", ", highest, "]");
}

PaintedAir::PaintedAir(PaintedVolume amount, PaintedVolume level, PaintedVolume intensity)
    : amount_(std::move(amount)), level_(std::move(level)), intensity_(std::move(intensity)) {
    require_usable(amount_, -1.0f, 1.0f, "the painted amount");
    require_usable(level_, -8.0f, 8.0f, "the painted level");
    require_usable(intensity_, 0.0f, 1000.0f, "the painted intensity");
    adds_amount_ = std::ranges::any_of(amount_.values, [](float added) { return added > 0.0f; });
    changes_level_ = std::ranges::any_of(level_.values, [](float added) { return added != 0.0f; });
    changes_intensity_ = std::ranges::any_of(intensity_.values, [](float factor) { return factor != 1.0f; });
}

void require_usable(const AirNoise& noise) {
    require_in(noise.scale_m, std::numeric_limits<float>::min(), 1e6f, "scale_m of the air's noise");
    require(1 <= noise.octaves && noise.octaves <= 8, "octaves of the air's noise is ", noise.octaves,
            ", outside [1, 8]");
    require_in(noise.persistence, 0.0f, 1.0f, "persistence of the air's noise");
    require_in(noise.contrast, 0.0f, 10.0f, "contrast of the air's noise");
    require(std::has_single_bit(noise.resolution) && 16 <= noise.resolution && noise.resolution <= 512,
            "resolution of the air's noise is ", noise.resolution, ", not a power of two in [16, 512]");
}

void require_usable(const Heterogeneity& heterogeneity) {
    require_usable(heterogeneity.noise);
    const dvec3& moved_m = heterogeneity.moved_m;
    require(std::isfinite(moved_m.x) && std::isfinite(moved_m.y) && std::isfinite(moved_m.z), "moved_m of the air is (",
            moved_m.x, ", ", moved_m.y, ", ", moved_m.z, ")");
    require_in(heterogeneity.amount, 0.0f, 1.0f, "amount of heterogeneity");
    require_in(heterogeneity.level, 0.0f, 8.0f, "level of heterogeneity");
    require_in(heterogeneity.intensity, 0.0f, 1000.0f, "intensity of heterogeneity");
    require(heterogeneity.weighting <= Heterogeneity::Weighting::WholeRay, "weighting of heterogeneity is ",
            static_cast<int>(heterogeneity.weighting), ", not 0 or 1");
    require(1 <= heterogeneity.step_count && heterogeneity.step_count <= 4096, "step_count of heterogeneity is ",
            heterogeneity.step_count, ", outside [1, 4096]");
    require(std::has_single_bit(heterogeneity.upsampling) && heterogeneity.upsampling <= 16,
            "upsampling of heterogeneity is ", heterogeneity.upsampling, ", not 1, 2, 4, 8 or 16");
    if (heterogeneity.painted)
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                require(std::isfinite(heterogeneity.unit_from_scene[column][row]),
                        "unit_from_scene of the painted air is not finite");
}

bool is_neutral(const Heterogeneity& heterogeneity) {
    const PaintedAir* const painted = heterogeneity.painted.get();
    return heterogeneity.amount == 0.0f && heterogeneity.intensity == 1.0f &&
           (painted == nullptr || (!painted->adds_amount() && !painted->changes_intensity()));
}
} // namespace tyndall
