// SPDX-License-Identifier: GPL-3.0-or-later
// Planes that hold the light of some lights apart from that of the others: light groups, of surfaces and of light shafts.
// Differs:  from Cycles, transfer functions recolour the picture, not its groups: these stay what the air scatters.
// Bound:    12 bytes per pixel and group, 24 with shafts; a few additions per light, sample and point.
#pragma once
#include "core/progress.hpp"
#include "render/data_passes.hpp"
#include "render/film.hpp"
#include <span>
#include <string>
#include <vector>

namespace tyndall::render {
/// Adds irradiance or radiance of a group to those of point `point` of `point_count`, group by group. Light of no group, or
/// of one that nobody asks for, is not kept apart.
template <typename Light>
void add_to_group(std::span<Light> by_group, std::uint8_t group, std::size_t point_count, std::size_t point,
                  const Light& light) {
    if (const std::size_t index = group * point_count + point; index < by_group.size())
        by_group[index] += light;
}

/// Sums of samples. Pixels are independent: threads may add to different ones.
class GroupSums {
public:
    /// Refuses names that are not unlike one another with InvalidInput.
    GroupSums(std::size_t pixel_count, std::vector<std::string> names, bool has_shafts);
    [[nodiscard]] std::size_t group_count() const { return names_.size(); }
    /// A sample's light on surfaces and of the world.
    void add(std::size_t pixel, const PathSample& sample);
    /// More light of the sample that was added last to this pixel.
    void add_light(std::size_t pixel, std::uint8_t group, const Rgb& radiance);
    /// The light shafts of the sample that was added last to this pixel.
    void add_shafts(std::size_t pixel, std::uint8_t group, const Rgb& radiance);
    /// So far; a pixel without a sample is 0.
    [[nodiscard]] std::vector<NamedPlane> resolve(const Progress& progress) const;

private:
    [[nodiscard]] NamedPlane plane_of(const std::string& name, const std::vector<Rgb>& sums, std::size_t group,
                                      const Progress& progress) const;

    std::size_t pixel_count_;
    std::vector<std::string> names_;
    std::vector<Rgb> light_, shafts_; ///< Pixel by pixel; no shafts where nobody asks for them.
    std::vector<std::uint32_t> sample_counts_;
};
} // namespace tyndall::render
