// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/light_groups.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::render {
GroupSums::GroupSums(std::size_t pixel_count, std::vector<std::string> names, bool has_shafts)
    : pixel_count_(pixel_count), names_(std::move(names)), light_(pixel_count * names_.size()),
      shafts_(has_shafts ? pixel_count * names_.size() : 0), sample_counts_(pixel_count) {
    require(names_.size() <= no_light_group, "there are ", names_.size(), " light groups: ", +no_light_group,
            " are the most");
    for (auto name = names_.begin(); name != names_.end(); ++name)
        require(std::find(names_.begin(), name, *name) == name, "there are two light groups \"", *name, "\"");
}

void GroupSums::add(std::size_t pixel, const PathSample& sample) {
    ++sample_counts_[pixel];
    for (std::size_t group = 0; group < sample.by_group.size(); ++group)
        light_[pixel * names_.size() + group] += sample.by_group[group];
}

void GroupSums::add_light(std::size_t pixel, std::uint8_t group, const Rgb& radiance) {
    if (group < names_.size())
        light_[pixel * names_.size() + group] += radiance;
}

void GroupSums::add_shafts(std::size_t pixel, std::uint8_t group, const Rgb& radiance) {
    if (group >= names_.size())
        return;
    light_[pixel * names_.size() + group] += radiance;
    if (!shafts_.empty())
        shafts_[pixel * names_.size() + group] += radiance;
}

NamedPlane GroupSums::plane_of(const std::string& name, const std::vector<Rgb>& sums, std::size_t group,
                               const Progress& progress) const {
    NamedPlane plane{.name = name, .channel_count = 3, .values = std::vector<float>(pixel_count_ * 3)};
    constexpr std::size_t pixels_per_block = 1 << 14;
    parallel_for(
        pixel_count_, progress,
        [&](std::size_t pixel) {
            const auto count = static_cast<float>(std::max(1u, sample_counts_[pixel]));
            for (int channel = 0; channel < 3; ++channel)
                plane.values[pixel * 3 + static_cast<std::size_t>(channel)] =
                    sums[pixel * names_.size() + group][channel] / count;
        },
        pixels_per_block);
    return plane;
}

std::vector<NamedPlane> GroupSums::resolve(const Progress& progress) const {
    std::vector<NamedPlane> planes;
    for (std::size_t group = 0; group < names_.size(); ++group) {
        planes.push_back(plane_of("Combined_" + names_[group], light_, group, progress));
        if (!shafts_.empty())
            planes.push_back(plane_of("Shafts_" + names_[group], shafts_, group, progress));
    }
    return planes;
}
} // namespace tyndall::render
