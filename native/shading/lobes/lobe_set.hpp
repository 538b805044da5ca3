// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes of one point together: what they send back, and directions drawn as often as they shine there.
// Based on: Veach, dissertation, Stanford 1997, section 9.2: one of the lobes is drawn from, the density is that of all.
// Differs:  broad lobes but sheen have no directions of their own: those by the cosine serve them.
//           A lobe's own normal changes its cosine, too: irradiance is that around the point's normal, so that what the lobe
//           sends back is scaled by the quotient of the cosines.
// Bound:    10 to 30 ns a lobe and direction.
#pragma once
#include "shading/lobes/lobe.hpp"
#include <span>

namespace tyndall {
namespace fibre {
struct Meeting; // lobes/fibre.hpp
}

/// Facets that are no wider are taken for as wide where directions are drawn: floats have no digits for less.
inline constexpr float least_alpha = 1e-3f;

/// Unit vectors: the point's normal, and to the viewer; lobes of one point.
struct LobeSet {
    std::span<const Lobe> lobes;
    vec3 normal{0, 0, 1}, outgoing{0, 0, 1};

    /// Radiance towards the viewer per irradiance from a unit direction, 1/sr. Of light behind the point's normal, which
    /// counts with `least_cosine`, gloss around a normal of its own sends back what lies before that, and others nothing.
    [[nodiscard]] Rgb per_irradiance(const vec3& incoming) const { return sum_of(incoming, Way::Aimed); }
    /// The same of a light without a size. Lobes are then as narrow as they are; of mirrors, for which Cycles takes the
    /// narrowest, nothing comes back.
    [[nodiscard]] Rgb per_irradiance_of_point(const vec3& incoming) const { return sum_of(incoming, Way::FromPoint); }
    /// The same along a way that sample() may have drawn. Of the Hair BSDF, Cycles takes all that is drawn, on whichever side
    /// of the point, and of aimed light what comes from the component's own side.
    [[nodiscard]] Rgb per_irradiance_as_drawn(const vec3& incoming) const { return sum_of(incoming, Way::Drawn); }
    [[nodiscard]] bool draws_on_both_sides() const;
    /// Some gloss has a normal of its own.
    [[nodiscard]] bool reflects_from_behind() const;
    /// Of irradiance: its quotient with a lobe's own cosine is finite.
    static constexpr float least_cosine = 1e-6f;
    /// Of directions by what reflects light, those that lobes draw, beside those by the cosine: as much as they shine, and a
    /// part that leaves no density far below that of a strategy. Lambert's share of the point; 0: none has any.
    [[nodiscard]] float share_of_directions(float lambert_share) const;
    static constexpr float least_share = 0.1f, most_share = 0.9f;
    /// False: no lobe has directions of its own.
    [[nodiscard]] bool has_directions() const;
    /// A unit direction, which may lie below the horizon.
    [[nodiscard]] vec3 sample(vec2 u) const;
    [[nodiscard]] float pdf_per_sr(const vec3& incoming) const;
    /// Share of even light from all around that they send back, roughly, and what of it Cycles counts as diffuse colour.
    [[nodiscard]] Rgb albedo() const;
    [[nodiscard]] Rgb diffuse_colour() const;

private:
    enum class Way : std::uint8_t { Aimed, FromPoint, Drawn };
    [[nodiscard]] Rgb sum_of(const vec3& incoming, Way way) const;
    [[nodiscard]] float of_fibre(const Lobe& lobe, const fibre::Meeting& meeting, Way way) const;
};
/// What facets of the lobe reflect at this cosine, without the lobe's weight.
[[nodiscard]] Rgb facet_colour(const Lobe& lobe, float cosine);
} // namespace tyndall
