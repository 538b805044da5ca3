// SPDX-License-Identifier: GPL-3.0-or-later
// Interference in a thin film on facets: soap, oil on water, tempered steel. What the film's two faces mirror adds up
// or cancels out by how much longer one way is, wavelength by wavelength.
// Based on: Belcour and Barla, A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence, TOG
//           36(4), 2017: Airy's sum as one over orders of interference, and what channels see of each order by the
//           Fourier transform of their sensitivity; Born and Wolf, Principles of Optics, 7th ed., section 14.4.1
//           (metals); Gulbrandsen, Artist Friendly Metallic Fresnel, JCGT 3(4), 2014 (the index of a metal that has two
//           colours).
// Differs:  the transform is a table over the longer way, by whichever sensitivity its maker knows, for the cosine and
//           the sine apart; a phase is a unit complex number, and its multiples are powers: no arctangent.
// Bound:    three orders, one place of the table each for both polarisations: 0.1 us on a dielectric. What is left out
//           of higher orders is below 2e-3 on dielectrics, 5e-3 on metals.
#pragma once
#include "core/math.hpp"
#include <vector>

namespace tyndall {
/// What the channels of a white light see of cos(2 pi w / wavelength) and of its sine, over ways w at even steps from 0
/// to reach_nm; beyond they see nothing. Both have as many entries, at least 2, finite; the cosine begins with 1, the
/// sine with 0.
struct FilmSpectra {
    std::vector<Rgb> cosine, sine;
    float reach_nm = 0.0f;       ///< Above 0.
    float fades_below_nm = 1.0f; ///< Thinner films have an index between theirs and that of air. Above 0.
    bool covers_metals = true;   ///< Of Principled: its metal has the film, too.
};
/// Throws InvalidInput that says what cannot be.
void validate(const FilmSpectra& spectra);
/// Thinner than that there is none.
inline constexpr float thinnest_film_nm = 0.1f;

struct ThinFilm {
    const FilmSpectra* spectra = nullptr; ///< Nothing: no film.
    float thickness_nm = 0.0f, ior = 1.33f;
};

/// Shares that a dielectric of this relative index, above 0, mirrors below the film; the cosine is the facet's, [0, 1].
[[nodiscard]] Rgb film_over_dielectric(float cosine, const ThinFilm& film, float ior);
/// That a conductor of index n + i k mirrors.
[[nodiscard]] Rgb film_over_conductor(float cosine, const ThinFilm& film, const Rgb& n, const Rgb& k);
/// That the metal of fresnel_f82 mirrors.
[[nodiscard]] Rgb film_over_f82(float cosine, const ThinFilm& film, const Rgb& straight, const Rgb& dark);
} // namespace tyndall
