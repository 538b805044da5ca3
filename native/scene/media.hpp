// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a ray which media are: closed meshes bound them, the world may fill the rest, density grids modulate some;
// overlapping ones add.
#pragma once
#include "scene/grid_media.hpp"
#include "scene/scene.hpp"
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall {
/// The media at a place, by index into SceneDescription::media, ascending. A medium in which two overlapping objects
/// stand is there twice: their coefficients add, as in Cycles.
struct MediumSet {
    static constexpr std::size_t capacity = 12; ///< Deeper overlaps keep the first 12 entered.
    std::array<std::uint16_t, capacity> media{};
    std::uint8_t count = 0;
    [[nodiscard]] bool is_empty() const { return count == 0; }
    bool operator==(const MediumSet&) const = default;
    void insert(std::uint16_t medium);
};

struct MediumSegment {
    float near_m, far_m; ///< far may be infinite in the world's medium.
    MediumSet set;       ///< Of the homogeneous ones; empty where there are only grids.
};

/// One instance's share of a medium: the triangles of a closed mesh whose material carries it.
struct MediumBoundary {
    std::uint32_t instance = 0; ///< Into SceneDescription::instances.
    std::uint16_t medium = 0;   ///< Into SceneDescription::media.
    bool is_box = false;        ///< The mesh is the axis-aligned box of its bounds in object space: a fog box.
    bool is_closed = false;     ///< Every edge is left as often as it is entered: rays end outside.
    bool is_inside_out = false; ///< Its triangles are wound inwards (negative volume); undone in all answers.
    mat4 object_from_world{1.0f};
    Bounds3 object_bounds;
    const TriangleBvh* cut_bvh = nullptr; ///< Of a mesh with more than a handful of triangles, for cuts with planes.
};

/// Medium of a mesh's material slot in one of its instances; -1: none.
[[nodiscard]] std::int32_t medium_of_slot(const SceneDescription& description, const Instance& instance,
                                          std::uint16_t slot);

/// Who sees what media emit: their objects may be hidden from surfaces.
enum class GlowSeenBy : std::uint8_t { All = 0, Surfaces = 1 };

/// The media of a scene with an Embree scene of their boundaries. Immutable; safe from any thread.
/// A medium is where the winding number of its boundary is positive, so that meshes may overlap themselves; an open
/// mesh bounds the half of a ray behind its front faces. Normals may point either way.
class Media {
public:
    Media(const Scene& scene, const Progress& progress);
    Media(const Media&) = delete;
    Media& operator=(const Media&) = delete;
    ~Media();

    [[nodiscard]] bool is_empty() const;  ///< No medium with a non-zero coefficient or emission.
    [[nodiscard]] Bounds3 bounds() const; ///< Of the bounded media and grids; empty without one.
    [[nodiscard]] bool fills_world() const;
    /// The media that density grids modulate: in no MediumSet.
    [[nodiscard]] const GridMedia& grids() const;
    /// Into SceneDescription::media; -1 where the world has none, or one without any coefficient.
    [[nodiscard]] std::int32_t world_medium_index() const;
    [[nodiscard]] std::span<const MediumBoundary> boundaries() const;
    [[nodiscard]] const Scene& scene() const { return scene_; }

    /// Appends the segments of the ray that lie in at least one medium or among the density of a grid, near to far.
    void segments(const Ray& ray, std::vector<MediumSegment>& segments) const;
    /// exp(-optical depth) of [near_m, far_m] of the ray, per channel.
    [[nodiscard]] Rgb transmittance(const Ray& ray) const;
    /// The same of the homogeneous media alone, and their optical depth.
    [[nodiscard]] Rgb homogeneous_transmittance(const Ray& ray) const { return glm::exp(-homogeneous_depth(ray)); }
    [[nodiscard]] Rgb homogeneous_depth(const Ray& ray) const;
    /// Multiplies the same of each ray into `passing`: a tenth of the time where a fog box is all there is.
    void attenuate(std::span<const Ray> rays, std::span<Rgb> passing) const;
    /// Some medium of the scene does, as these see it: surfaces none whose objects are hidden from bounces. A medium of
    /// several objects is seen if one of them is.
    [[nodiscard]] bool emits(GlowSeenBy by = GlowSeenBy::All) const;
    /// Radiance that the media emit along the ray towards its origin, attenuated. An endless segment that emits in a
    /// channel without extinction has no finite answer: that channel of it adds nothing.
    [[nodiscard]] Rgb emission(const Ray& ray, GlowSeenBy by = GlowSeenBy::All) const;

    [[nodiscard]] Rgb sigma_t_per_m(const MediumSet& set) const;
    [[nodiscard]] Rgb sigma_s_per_m(const MediumSet& set) const;
    /// sum of sigma_s * phase function over the lobes, 1/(m sr); cosine between the light's way and the way on to
    /// the camera: 1 is straight forward scattering.
    [[nodiscard]] Rgb scatter_per_m_sr(const MediumSet& set, float cosine) const;
    /// The same of one, which a density grid may modulate.
    [[nodiscard]] Rgb scatter_per_m_sr(std::uint16_t medium, float cosine) const;

private:
    void homogeneous_segments(const Ray& ray, std::vector<MediumSegment>& segments) const;

    const Scene& scene_;
    struct Boundaries;
    std::unique_ptr<const Boundaries> boundaries_;
};

/// Distances at which a ray's line enters and leaves an axis-aligned box; near > far where it misses.
struct BoxInterval {
    float near_m, far_m;
};
[[nodiscard]] BoxInterval clip_to_box(const Bounds3& box, const vec3& origin, const vec3& direction);
} // namespace tyndall
