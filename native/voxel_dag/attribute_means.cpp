// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/attribute_means.hpp"
#include "image/srgb.hpp"

namespace tyndall::voxel_dag {
static constexpr double light_steps = 65535.0, normal_steps = 1 << 20;

static const std::array<std::uint16_t, 256>& light_of_byte() {
    static const std::array<std::uint16_t, 256> table = [] {
        std::array<std::uint16_t, 256> light{};
        for (std::size_t byte = 0; byte < light.size(); ++byte)
            light[byte] = static_cast<std::uint16_t>(
                std::lround(light_steps * static_cast<double>(linear_from_srgb(static_cast<float>(byte) / 255.0f))));
        return light;
    }();
    return table;
}

void SampleSum::add(const VoxelSample& sample) {
    const std::array<std::uint16_t, 256>& light = light_of_byte();
    ++count_;
    for (std::uint32_t i = 0; i < 3; ++i) {
        light_[i] += light[sample.color >> 8 * i & 255];
        normal_[i] += std::lround(normal_steps * static_cast<double>(sample.normal[static_cast<int>(i)]));
    }
    for (std::size_t i = 0; i < channels_.size(); ++i)
        channels_[i] += sample.channels[i];
}

SampleSum& SampleSum::operator+=(const SampleSum& other) {
    count_ += other.count_;
    for (std::size_t i = 0; i < 3; ++i)
        light_[i] += other.light_[i], normal_[i] += other.normal_[i];
    for (std::size_t i = 0; i < channels_.size(); ++i)
        channels_[i] += other.channels_[i];
    return *this;
}

VoxelSample SampleSum::mean() const {
    VoxelSample mean;
    const auto count = static_cast<double>(count_);
    for (std::uint32_t i = 0; i < 3; ++i) {
        const float encoded =
            srgb_from_linear(static_cast<float>(static_cast<double>(light_[i]) / count / light_steps));
        mean.color |= static_cast<std::uint32_t>(std::lround(255.0f * encoded)) << 8 * i;
    }
    const dvec3 sum(static_cast<double>(normal_[0]), static_cast<double>(normal_[1]), static_cast<double>(normal_[2]));
    mean.normal = sum == dvec3(0.0) ? vec3(0.0f, 0.0f, 1.0f) : vec3(glm::normalize(sum));
    for (std::size_t i = 0; i < channels_.size(); ++i)
        mean.channels[i] = static_cast<std::uint8_t>((2 * channels_[i] + count_) / (2 * count_));
    return mean;
}
} // namespace tyndall::voxel_dag
