// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a ray which media are: closed meshes bound them, the world may fill the rest; overlapping ones add.
#pragma once
#include "scene/scene.hpp"
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall {
/// The media at a place, by index into SceneDescription::media, ascending, each once.
struct MediumSet {
    static constexpr std::size_t capacity = 12; ///< Deeper overlaps keep the first 12 and are counted.
    std::array<std::uint16_t, capacity> media{};
    std::uint8_t count = 0;
    [[nodiscard]] bool is_empty() const { return count == 0; }
    bool operator==(const MediumSet&) const = default;
};

struct MediumSegment {
    float near_m, far_m; ///< far may be infinite in the world's medium.
    MediumSet set;
};

/// The media of a scene with an Embree scene of their boundaries. Immutable; safe from any thread.
class Media {
public:
    Media(const Scene& scene, const Progress& progress);
    Media(const Media&) = delete;
    Media& operator=(const Media&) = delete;
    ~Media();

    [[nodiscard]] bool is_empty() const;  ///< No medium with a non-zero coefficient or emission.
    [[nodiscard]] Bounds3 bounds() const; ///< Of the bounded media; empty without one.
    [[nodiscard]] bool fills_world() const;

    /// Appends the segments of the ray that lie in at least one medium, near to far.
    void segments(const Ray& ray, std::vector<MediumSegment>& segments) const;
    /// exp(-optical depth) of [near_m, far_m] of the ray, per channel.
    [[nodiscard]] Rgb transmittance(const Ray& ray) const;
    /// Radiance that the media emit along the ray towards its origin, attenuated.
    [[nodiscard]] Rgb emission(const Ray& ray) const;

    [[nodiscard]] Rgb sigma_t_per_m(const MediumSet& set) const;
    [[nodiscard]] Rgb sigma_s_per_m(const MediumSet& set) const;
    /// sum of sigma_s * Henyey-Greenstein over the lobes, 1/(m sr); cosine between the light's way and the way on to
    /// the camera: 1 is straight forward scattering.
    [[nodiscard]] Rgb scatter_per_m_sr(const MediumSet& set, float cosine) const;

private:
    const Scene& scene_;
    struct Boundaries;
    std::unique_ptr<const Boundaries> boundaries_;
};
} // namespace tyndall
