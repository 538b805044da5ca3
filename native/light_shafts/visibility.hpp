// SPDX-License-Identifier: GPL-3.0-or-later
// Which parts of a view ray a light reaches: one interface, three ways to answer (exact strip, epipolar raster, shadow
// map), each with a documented error. The scattering integrals know nothing of how the intervals were found.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// A lit part of a view ray, as distances from its origin; intervals of a ray rise and do not overlap.
struct LitInterval {
    float near_m, far_m;
    Rgb transmittance{1.0f}; ///< Of the transparent surfaces between it and the light, per channel.
};
/// Lit intervals of consecutive rays in compressed rows.
struct LitRows {
    std::vector<std::uint32_t> first{0}; ///< Ray r owns intervals[first[r] .. first[r + 1]).
    std::vector<LitInterval> intervals;
    void clear() {
        first.assign(1, 0);
        intervals.clear();
    }
    void end_ray() { first.push_back(static_cast<std::uint32_t>(intervals.size())); }
    [[nodiscard]] std::span<const LitInterval> of_ray(std::size_t ray) const {
        return std::span(intervals).subspan(first[ray], first[ray + 1] - first[ray]);
    }
};

/// Scatter pieces of consecutive rays in compressed rows.
struct PieceRows {
    std::vector<std::uint32_t> first{0}; ///< Ray r owns pieces[first[r] .. first[r + 1]).
    std::vector<ScatterPiece> pieces;
    void clear() {
        first.assign(1, 0);
        pieces.clear();
    }
    void end_ray() { first.push_back(static_cast<std::uint32_t>(pieces.size())); }
    [[nodiscard]] std::span<const ScatterPiece> of_ray(std::size_t ray) const {
        return std::span(pieces).subspan(first[ray], first[ray + 1] - first[ray]);
    }
};

/// Equal steps along rays: ray r has step_count of step_m[r] from begin_m[r] on.
struct StepRows {
    std::span<const float> begin_m, step_m;
    std::uint32_t step_count;
};

struct CoarseRows; // coarse_rows.hpp

class Visibility {
public:
    Visibility() = default;
    Visibility(const Visibility&) = delete;
    Visibility& operator=(const Visibility&) = delete;
    virtual ~Visibility() = default;

    /// Appends the lit intervals of each ray within its finite [near_m, far_m]. Safe to call from many threads, each
    /// with its own `rows`.
    virtual void lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const = 0;
    /// Adds to each ray the radiance that its pieces scatter where they are lit, and to lit_length_m the length of the
    /// lit parts (weighted by the transmittance's mean), unless that is empty: not asked for. By lit_intervals, unless
    /// a method fuses the two.
    virtual void add_scattered(std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                               std::span<float> lit_length_m) const;
    /// Overwrites the share of each ray's steps that is lit, weighted by the mean of the transmittance: step s of ray r is
    /// shares[r * step_count + s]. By lit_intervals, unless a method knows better.
    virtual void find_lit_shares(std::span<const ViewRay> rays, const StepRows& steps, std::span<float> shares) const;
    /// The order in which to ask for many rays, so that what they read stays in the cache; empty: any.
    [[nodiscard]] virtual std::vector<std::uint32_t> coherent_order(std::span<const ViewRay>, const Progress&) const {
        return {};
    }
    /// Brings the rays `asked` into such an order. Throws Cancelled.
    virtual void make_coherent(std::span<const ViewRay>, std::vector<std::uint32_t>& /*asked*/, const Progress&) const {
    }
    /// Rows that tell lit lines of rays to a sun, coarser than those that lit_intervals reads; nothing where there are none.
    [[nodiscard]] virtual const CoarseRows* coarse_rows() const { return nullptr; }
    /// What was built, what was skipped, which occluders had to fall back.
    [[nodiscard]] virtual const Statistics& statistics() const = 0;
};

/// Adds to each of some consecutive steps the share of it that lies between `begin` and `end`, in steps, times `weight`.
void add_lit_share(float begin, float end, float weight, std::span<float> shares);

/// Prepares visibility of one light sample for `rays` (finite, clipped to the media) of `view`.
using MakeVisibility = std::unique_ptr<Visibility>(const Scene& scene, const View& view, const LightSample& light,
                                                   std::span<const ViewRay> rays, const Config& config,
                                                   Progress& progress);
MakeVisibility make_exact_strip; // exact_strip.cpp
MakeVisibility make_epipolar;    // epipolar.cpp
MakeVisibility make_shadow_map;  // shadow_map.cpp

struct Occluders;
struct RaySpan;
class StripOnDemand;
/// The same for one of many light samples, which share what is known of the scene and are safe to prepare side by side.
using MakeBeamVisibility = std::unique_ptr<Visibility>(const Scene& scene, const Occluders& occluders, const View& view,
                                                       const LightSample& light, std::span<const RaySpan> outline,
                                                       std::shared_ptr<const StripOnDemand> strip, const Config& config,
                                                       Progress& progress);
MakeBeamVisibility make_epipolar_beam;
MakeBeamVisibility make_shadow_map_beam;
class OccluderEdits;
/// Whether a map is made finer than asked for where edits would not show: up to 2,048 texels per side.
enum class EditedMap : std::uint8_t { ShowsEdits, AsAsked };
/// A sample of a light whose occluders are edited: by its depth map, whatever the method.
std::unique_ptr<Visibility> make_edited_beam(const Scene& scene, const OccluderEdits& edits, const Occluders& occluders,
                                             const View& view, const LightSample& light,
                                             std::span<const RaySpan> outline,
                                             std::shared_ptr<const StripOnDemand> strip, const Config& config,
                                             Progress& progress, EditedMap map = EditedMap::ShowsEdits);
} // namespace tyndall::light_shafts
