// SPDX-License-Identifier: GPL-3.0-or-later
// Thin films against Airy's sum of all reflections, in complex amplitudes; without interference; and where there is none.
#include "core/errors.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/lobes/thin_film.hpp"
#include "shading/material.hpp"
#include "support/close_to.hpp"
#include <complex>
#include <doctest/doctest.h>
#include <numbers>
#include <utility>

namespace thin_film_test {
using namespace tyndall;
using tyndall::support::close_to;
using Complex = std::complex<double>;

namespace {
/// One that sees a wavelength per channel, and waves of any length.
FilmSpectra laser_spectra(const vec3& wavelengths_nm) {
    FilmSpectra spectra;
    spectra.reach_nm = 8000.0f;
    for (int step = 0; step <= 80000; ++step) {
        const double way_nm = 0.1 * step;
        Rgb cosine, sine;
        for (int channel = 0; channel < 3; ++channel) {
            const double phase = 2.0 * std::numbers::pi * way_nm / wavelengths_nm[channel];
            cosine[channel] = static_cast<float>(std::cos(phase));
            sine[channel] = static_cast<float>(std::sin(phase));
        }
        spectra.cosine.push_back(cosine);
        spectra.sine.push_back(sine);
    }
    return spectra;
}
const vec3 lasers_nm(633.0f, 532.0f, 450.0f);

/// Fresnel's amplitudes between two complex indices, across the plane of incidence and along it; cosines by Snell.
std::pair<Complex, Complex> amplitudes(Complex n, Complex cosine, Complex to_n, Complex to_cosine) {
    return {(n * cosine - to_n * to_cosine) / (n * cosine + to_n * to_cosine),
            (to_n * cosine - n * to_cosine) / (to_n * cosine + n * to_cosine)};
}
Complex refracted(double cosine, Complex ior) { return std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior)); }

/// All reflections within the film, of one wavelength.
double airy(double cosine, double thickness_nm, double film_ior, Complex ior, double wavelength_nm) {
    const Complex within = refracted(cosine, film_ior), below = refracted(cosine, ior);
    const auto outer = amplitudes(1.0, cosine, film_ior, within), inner = amplitudes(film_ior, within, ior, below);
    const double way_nm = 2.0 * film_ior * thickness_nm * within.real();
    const Complex late = std::polar(1.0, 2.0 * std::numbers::pi * way_nm / wavelength_nm);
    const auto share = [&](const Complex& a, const Complex& b) {
        return std::norm((a + b * late) / (1.0 + a * b * late));
    };
    return 0.5 * (share(outer.first, inner.first) + share(outer.second, inner.second));
}
} // namespace

TEST_CASE("a film over a dielectric mirrors what all reflections within it add up to, wavelength by wavelength") {
    const FilmSpectra spectra = laser_spectra(lasers_nm);
    for (const float film_ior : {1.2f, 1.38f, 1.8f})
        for (const float ior : {1.1f, 1.5f, 1.9f})
            for (const float thickness_nm : {40.0f, 99.6f, 260.0f, 555.0f})
                for (const float cosine : {1.0f, 0.8f, 0.45f}) {
                    CAPTURE(film_ior);
                    CAPTURE(ior);
                    CAPTURE(thickness_nm);
                    CAPTURE(cosine);
                    const Rgb mirrored = film_over_dielectric(
                        cosine, {.spectra = &spectra, .thickness_nm = thickness_nm, .ior = film_ior}, ior);
                    for (int channel = 0; channel < 3; ++channel)
                        CHECK(std::abs(mirrored[channel] - airy(cosine, thickness_nm, film_ior, ior,
                                                                lasers_nm[channel])) < 2e-3); // orders beyond the third
                }
}

TEST_CASE("a quarter of a wave with the root of the glass's index mirrors nothing of it, half a wave what glass does") {
    const FilmSpectra spectra = laser_spectra(lasers_nm);
    const float root = std::sqrt(1.5f);
    const float quarter_nm = lasers_nm.y / (4.0f * root);
    const auto mirrored = [&](float thickness_nm) {
        return film_over_dielectric(1.0f, {.spectra = &spectra, .thickness_nm = thickness_nm, .ior = root}, 1.5f).y;
    };
    CHECK(mirrored(quarter_nm) < 2e-5f);
    CHECK(mirrored(2.0f * quarter_nm) == close_to(straight_share(1.5f), 2e-3));
}

TEST_CASE("a film over a metal mirrors what all reflections add up to, with the shift of the metal's phase") {
    const FilmSpectra spectra = laser_spectra(lasers_nm);
    const Rgb n(0.2f, 1.5f, 2.9f), k(3.5f, 2.0f, 0.4f);
    for (const float film_ior : {1.2f, 1.45f})
        for (const float thickness_nm : {30.0f, 180.0f, 420.0f})
            for (const float cosine : {1.0f, 0.7f, 0.4f}) {
                CAPTURE(film_ior);
                CAPTURE(thickness_nm);
                CAPTURE(cosine);
                const Rgb mirrored = film_over_conductor(
                    cosine, {.spectra = &spectra, .thickness_nm = thickness_nm, .ior = film_ior}, n, k);
                for (int channel = 0; channel < 3; ++channel) {
                    const double all =
                        airy(cosine, thickness_nm, film_ior, {n[channel], k[channel]}, lasers_nm[channel]);
                    CHECK(std::abs(mirrored[channel] - all) < 5e-3);
                }
            }
}

TEST_CASE("a film that has the index of one of its sides is none") {
    const FilmSpectra spectra = laser_spectra(lasers_nm);
    for (const float cosine : {1.0f, 0.6f, 0.1f})
        for (const float thickness_nm : {50.0f, 700.0f}) {
            const ThinFilm of_air{.spectra = &spectra, .thickness_nm = thickness_nm, .ior = 1.0f};
            const ThinFilm of_glass{.spectra = &spectra, .thickness_nm = thickness_nm, .ior = 1.5f};
            const float plain = fresnel_of_any_index(cosine, 1.5f);
            CHECK(film_over_dielectric(cosine, of_air, 1.5f).x == close_to(plain, 1e-4));
            CHECK(film_over_dielectric(cosine, of_glass, 1.5f).x == close_to(plain, 1e-4));
            const Rgb n(0.2f, 1.5f, 2.9f), k(3.5f, 2.0f, 0.4f);
            const Rgb metal = film_over_conductor(cosine, of_air, n, k);
            // fresnel_conductor leaves sin^2 out beside |n + i k|^2: 1 % or so where that is small.
            CHECK(metal.x == close_to(fresnel_conductor(cosine, n, k).x, 2e-2));
        }
    // Gulbrandsen's index mirrors the colour that it was made of.
    const Rgb gold(0.9f, 0.6f, 0.2f);
    const ThinFilm of_air{.spectra = &spectra, .thickness_nm = 300.0f, .ior = 1.0f};
    const Rgb straight = film_over_f82(1.0f, of_air, gold, f82_dark(gold, Rgb(0.6f, 0.8f, 1.0f)));
    for (int channel = 0; channel < 3; ++channel)
        CHECK(straight[channel] == close_to(gold[channel], 1e-4));
}

TEST_CASE("beyond what is seen of waves both faces mirror for themselves; within all bounds, from any side") {
    FilmSpectra spectra = laser_spectra(lasers_nm);
    const ThinFilm thick{.spectra = &spectra, .thickness_nm = 1e6f, .ior = 1.8f};
    const double outer = straight_share(1.8f), inner = straight_share(1.5f / 1.8f);
    const double both = outer + (1 - outer) * (1 - outer) * inner / (1 - outer * inner);
    CHECK(film_over_dielectric(1.0f, thick, 1.5f).x == close_to(both, 1e-4));
    for (const float thickness_nm : {0.2f, 1.0f, 120.0f, 1e18f})
        for (const float film_ior : {1e-5f, 0.6f, 1.33f, 1e6f})
            for (const float ior : {1e-5f, 0.66f, 1.0f, 1.5f, 1e6f})
                for (const float cosine : {0.0f, 1e-4f, 0.3f, 1.0f}) {
                    CAPTURE(thickness_nm);
                    CAPTURE(film_ior);
                    CAPTURE(ior);
                    CAPTURE(cosine);
                    const ThinFilm film{.spectra = &spectra, .thickness_nm = thickness_nm, .ior = film_ior};
                    const auto is_share = [](const Rgb& mirrored) {
                        return glm::all(glm::greaterThanEqual(mirrored, Rgb(0.0f))) &&
                               glm::all(glm::lessThanEqual(mirrored, Rgb(1.0f)));
                    };
                    CHECK(is_share(film_over_dielectric(cosine, film, ior)));
                    CHECK(is_share(film_over_conductor(cosine, film, Rgb(ior), Rgb(0.0f, 1.0f, 100.0f))));
                    CHECK(is_share(film_over_f82(cosine, film, Rgb(0.0f, 0.5f, 1.0f), Rgb(0.3f))));
                }
    CHECK(film_over_dielectric(0.2f, {.spectra = &spectra, .thickness_nm = 100.0f, .ior = 0.7f}, 1.5f) == Rgb(1.0f));
    CHECK(film_over_dielectric(0.2f, {.spectra = &spectra, .thickness_nm = 100.0f, .ior = 1.3f}, 0.6f) == Rgb(1.0f));
}

TEST_CASE("a film as thin as nothing fades into its surface") {
    FilmSpectra spectra = laser_spectra(lasers_nm);
    spectra.fades_below_nm = 30.0f;
    const auto mirrored = [&](float thickness_nm) {
        return film_over_dielectric(0.7f, {.spectra = &spectra, .thickness_nm = thickness_nm, .ior = 1.9f}, 1.4f).x;
    };
    CHECK(mirrored(0.11f) == close_to(fresnel_of_any_index(0.7f, 1.4f), 1e-3));
    CHECK(mirrored(30.0f) == close_to(mirrored(30.01f), 1e-3));
}

TEST_CASE(
    "glass below a film lets the rest pass, seen from either side; the film of Principled covers no metal of 4.x") {
    auto spectra = std::make_shared<FilmSpectra>(laser_spectra(lasers_nm));
    const auto built = [&](LobeModel model, std::vector<Rgb> inputs, bool is_backface, Lobes& lobes) {
        LobeInputs values{};
        std::ranges::copy(inputs, values.begin());
        ShadingPoint point;
        point.view_cosine = 0.8f, point.is_backface = is_backface;
        SurfaceClosures closures{.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(1.0f)};
        add_lobes({.model = model, .film = spectra}, values, point, closures, &lobes,
                  {.outgoing = vec3(0.6f, 0.0f, 0.8f)});
        return closures;
    };
    const Rgb thickness(300.0f), ior(1.8f);
    for (const bool is_backface : {false, true}) {
        Lobes lobes;
        const std::vector<Rgb> glass{Rgb(1.0f), Rgb(1.0f), Rgb(0.5f), Rgb(1.4f), thickness, ior};
        const SurfaceClosures closures = built(LobeModel::Glass, glass, is_backface, lobes);
        REQUIRE(lobes.size() == 1);
        const Rgb mirrored = facet_colour(lobes[0], 0.8f);
        CHECK(glm::distance(closures.transparent, 1.0f - mirrored) < 1e-6f);
        // The film's two sides: air and glass from without, glass and air from within.
        const ThinFilm film{.spectra = spectra.get(), .thickness_nm = 300.0f, .ior = is_backface ? 1.8f / 1.4f : 1.8f};
        CHECK(glm::distance(mirrored, film_over_dielectric(0.8f, film, is_backface ? 1.0f / 1.4f : 1.4f)) < 1e-6f);
        Lobes bent;
        built(LobeModel::BentGlass, {Rgb(1.0f), Rgb(1.0f), Rgb(1.0f), Rgb(1.0f), Rgb(1.4f), thickness, ior},
              is_backface, bent);
        REQUIRE(bent.size() == 1);
        CHECK(glm::distance(bent[0].a, mirrored) < 1e-6f);
        CHECK(glm::distance(bent[0].weight, 1.0f - mirrored) < 1e-6f);
    }
    std::vector<Rgb> metal(input_count(LobeModel::Principled), Rgb(0.0f));
    metal[0] = metal[2] = Rgb(1.0f), metal[1] = Rgb(0.9f, 0.6f, 0.2f), metal[5] = Rgb(1.0f);
    metal.insert(metal.end(), {thickness, ior});
    for (const bool covers_metals : {false, true}) {
        spectra->covers_metals = covers_metals;
        Lobes lobes;
        built(LobeModel::Principled, metal, false, lobes);
        REQUIRE(!lobes.empty());
        CHECK((lobes[0].film.spectra != nullptr) == covers_metals);
        CHECK(lobes[0].fresnel == Lobe::Fresnel::F82);
    }
}

TEST_CASE("films of shaders that have none, and spectra that cannot be, are named") {
    const auto spectra = std::make_shared<FilmSpectra>(laser_spectra(lasers_nm));
    LobeSource source{.model = LobeModel::Glass, .constants = std::vector<Rgb>(6, Rgb(1.0f)), .film = spectra};
    source.registers.assign(6, LobeSource::no_register);
    CHECK_NOTHROW(validate(source, "bubble"));
    source.film = nullptr;
    CHECK_THROWS_WITH_AS(validate(source, "bubble"), doctest::Contains("bubble"), InvalidInput);
    source = {.model = LobeModel::Velvet, .constants = std::vector<Rgb>(5, Rgb(1.0f)), .film = spectra};
    source.registers.assign(5, LobeSource::no_register);
    CHECK_THROWS_WITH_AS(validate(source, "cloth"), doctest::Contains("cloth"), InvalidInput);
    const auto refused = [&](auto change) {
        FilmSpectra broken = *spectra;
        change(broken);
        CHECK_THROWS_AS(validate(broken), InvalidInput);
    };
    CHECK_NOTHROW(validate(*spectra));
    refused([](FilmSpectra& of) { of.sine.pop_back(); });
    refused([](FilmSpectra& of) { of.cosine.resize(1), of.sine.resize(1); });
    refused([](FilmSpectra& of) { of.cosine[7].y = NAN; });
    refused([](FilmSpectra& of) { of.reach_nm = 0.0f; });
    refused([](FilmSpectra& of) { of.fades_below_nm = -1.0f; });
}
} // namespace thin_film_test
