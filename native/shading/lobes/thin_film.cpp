// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/thin_film.hpp"
#include "core/errors.hpp"
#include "shading/lobes/fresnel_colours.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tyndall {
namespace {
/// By how much a wave is late: e^(i phi), or that times an amplitude.
struct Phase {
    float real = 1.0f, imaginary = 0.0f;
    Phase operator*(const Phase& other) const {
        return {real * other.real - imaginary * other.imaginary, real * other.imaginary + imaginary * other.real};
    }
};

/// Of what a face mirrors: its share, and the shift of its phase, across the plane of incidence and along it.
struct Polarised {
    float share = 1.0f;
    Phase shift = {};
};
struct Face {
    Polarised across, along;
};
/// A dielectric's, and the cosine within.
struct Refracting {
    Face face;
    float inner_cosine;
};

/// Fresnel's equations; nothing where all is mirrored.
std::optional<Refracting> refracting(float cosine, float ior) {
    const float inner2 = ior * ior - (1.0f - cosine * cosine);
    if (!(inner2 > 0.0f) || cosine <= 0.0f)
        return std::nullopt;
    const float inner = std::sqrt(inner2), inner_cosine = inner / ior; // the first: ior times the cosine
    const auto of = [](float amplitude) {
        return Polarised{amplitude * amplitude, {amplitude < 0.0f ? -1.0f : 1.0f, 0.0f}};
    };
    return Refracting{
        {of((cosine - inner) / (cosine + inner)), of((ior * cosine - inner_cosine) / (ior * cosine + inner_cosine))},
        inner_cosine};
}

Phase unit(float real, float imaginary) {
    const float size = std::hypot(real, imaginary);
    return size > 0.0f ? Phase{real / size, imaginary / size} : Phase{};
}

/// A conductor's below a medium of index `ior`. `share`: of both polarisations; nothing: as they are.
Face conducting(float cosine, float ior, float n, float k, const std::optional<float>& share) {
    // Born and Wolf's u and v: of the refracted ray's complex cosine times the complex index.
    const float n2 = n * n, k2 = k * k, cosine2 = cosine * cosine, twice = 2.0f * n * k;
    const float difference = n2 - k2 - ior * ior * (1.0f - cosine2), size = std::hypot(difference, twice);
    const float u2 = std::max(0.5f * (size + difference), 0.0f), v2 = std::max(0.5f * (size - difference), 0.0f);
    const float u = std::sqrt(u2), v = std::sqrt(v2), outer = ior * cosine;
    const auto square = [](float x) { return x * x; };
    const auto quotient = [](float over, float under) { return under > 0.0f ? over / under : 1.0f; };
    const float real = (n2 - k2) * cosine, imaginary = twice * cosine;
    Face face;
    face.across.share = share ? *share : quotient(square(outer - u) + v2, square(outer + u) + v2);
    face.along.share = share ? *share
                             : quotient(square(real - ior * u) + square(imaginary - ior * v),
                                        square(real + ior * u) + square(imaginary + ior * v));
    face.across.shift = unit(square(outer) - u2 - v2, -2.0f * outer * v);
    face.along.shift =
        unit(square((n2 + k2) * cosine) - ior * ior * (u2 + v2), 2.0f * outer * (twice * u - (n2 - k2) * v));
    return face;
}

/// Of both faces together, without interference, and what each order of it adds.
struct Orders {
    static constexpr std::size_t count = 3; // higher ones add next to nothing
    float mean;
    Phase amplitude[count];
};
Orders orders_of(const Polarised& outer, const Polarised& inner) {
    const float passing = 1.0f - outer.share, both = outer.share * inner.share;
    const float later = passing * passing * inner.share / std::max(1.0f - both, 1e-12f);
    Orders orders{.mean = outer.share + later, .amplitude = {}};
    // The outer face turns what comes from below the other way.
    const Phase once = Phase{-outer.shift.real, -outer.shift.imaginary} * inner.shift;
    const float root = std::sqrt(both);
    Phase amplitude{2.0f * (later - passing), 0.0f};
    for (Phase& of_order : orders.amplitude)
        of_order = amplitude = amplitude * Phase{root * once.real, root * once.imaginary};
    return orders;
}

/// What the channels see.
struct Seen {
    Rgb cosine{0.0f}, sine{0.0f};
};
Seen seen_of(const FilmSpectra& spectra, float way_nm) {
    const auto last = static_cast<float>(spectra.cosine.size() - 1);
    const float place = way_nm / spectra.reach_nm * last;
    if (!(place < last))
        return {};
    const auto entry = static_cast<std::size_t>(place);
    const float share = place - static_cast<float>(entry);
    return {glm::mix(spectra.cosine[entry], spectra.cosine[entry + 1], share),
            glm::mix(spectra.sine[entry], spectra.sine[entry + 1], share)};
}

float film_index(const ThinFilm& film) {
    const float share = film.thickness_nm / film.spectra->fades_below_nm;
    if (share >= 1.0f)
        return film.ior;
    return 1.0f + (film.ior - 1.0f) * share * share * (3.0f - 2.0f * share);
}

/// The light's way through a film and back is so much longer.
float longer_way_nm(const ThinFilm& film, float index, float inner_cosine) {
    return 2.0f * index * film.thickness_nm * inner_cosine;
}

using Faces = std::array<Face, 3>; // one for each channel

/// `inner_faces(cosine in the film, its index)`: nothing where they mirror all.
template <typename InnerFaces>
Rgb interfered(float cosine, const ThinFilm& film, const InnerFaces& inner_faces) {
    const float index = film_index(film);
    const std::optional<Refracting> outer = refracting(cosine, index);
    if (!outer)
        return Rgb(1.0f);
    const std::optional<Faces> inner = inner_faces(outer->inner_cosine, index);
    if (!inner)
        return Rgb(1.0f);
    const float way_nm = longer_way_nm(film, index, outer->inner_cosine);
    std::array<Seen, Orders::count> seen;
    for (std::size_t order = 0; order < seen.size(); ++order)
        seen[order] = seen_of(*film.spectra, static_cast<float>(order + 1) * way_nm);
    Rgb sum(0.0f);
    for (int channel = 0; channel < 3; ++channel) {
        const Face& face = (*inner)[static_cast<std::size_t>(channel)];
        for (const Orders& orders :
             {orders_of(outer->face.across, face.across), orders_of(outer->face.along, face.along)}) {
            sum[channel] += orders.mean;
            for (std::size_t order = 0; order < seen.size(); ++order)
                sum[channel] += orders.amplitude[order].real * seen[order].cosine[channel] -
                                orders.amplitude[order].imaginary * seen[order].sine[channel];
        }
    }
    return glm::clamp(0.5f * sum, 0.0f, 1.0f);
}
} // namespace

void validate(const FilmSpectra& spectra) {
    require(spectra.cosine.size() >= 2 && spectra.cosine.size() == spectra.sine.size(),
            "thin films: ", spectra.cosine.size(), " and ", spectra.sine.size(),
            " entries, but at least 2 and as many are needed");
    for (const std::vector<Rgb>* column : {&spectra.cosine, &spectra.sine})
        require(std::ranges::all_of(*column, [](const Rgb& seen) { return std::isfinite(seen.x + seen.y + seen.z); }),
                "thin films: what channels see is not finite");
    require(spectra.reach_nm > 0.0f && std::isfinite(spectra.reach_nm), "thin films: a reach of ", spectra.reach_nm,
            " nm is not above 0");
    require(spectra.fades_below_nm > 0.0f && std::isfinite(spectra.fades_below_nm), "thin films: they fade below ",
            spectra.fades_below_nm, " nm, which is not above 0");
}

Rgb film_over_dielectric(float cosine, const ThinFilm& film, float ior) {
    return interfered(cosine, film, [&](float inner_cosine, float index) -> std::optional<Faces> {
        const std::optional<Refracting> inner = refracting(inner_cosine, ior / index);
        if (!inner)
            return std::nullopt;
        return Faces{inner->face, inner->face, inner->face};
    });
}

Rgb film_over_conductor(float cosine, const ThinFilm& film, const Rgb& n, const Rgb& k) {
    return interfered(cosine, film, [&](float inner_cosine, float index) -> std::optional<Faces> {
        const auto of = [&](int channel) {
            return conducting(inner_cosine, index, n[channel], k[channel], std::nullopt);
        };
        return Faces{of(0), of(1), of(2)};
    });
}

Rgb film_over_f82(float cosine, const ThinFilm& film, const Rgb& straight, const Rgb& dark) {
    // Gulbrandsen's eq. 2 and 5: n and k of what is mirrored straight, and of the edge's colour.
    const Rgb share = glm::min(straight, Rgb(0.999f)), edge = fresnel_f82(1.0f / 7.0f, straight, dark);
    const Rgb root = glm::sqrt(share);
    const Rgb n = glm::mix((1.0f + root) / (1.0f - root), (1.0f - share) / (1.0f + share), edge);
    const Rgb k2 = (share * (n + 1.0f) * (n + 1.0f) - (n - 1.0f) * (n - 1.0f)) / (1.0f - share);
    const Rgb k = glm::sqrt(glm::max(k2, Rgb(0.0f)));
    return interfered(cosine, film, [&](float inner_cosine, float index) -> std::optional<Faces> {
        // Below the film the metal is another: its shares are those of its index there.
        const Rgb below_n = n / index, below_k2 = k * k / (index * index);
        const Rgb straight_below =
            ((below_n - 1.0f) * (below_n - 1.0f) + below_k2) / ((below_n + 1.0f) * (below_n + 1.0f) + below_k2);
        const Rgb below = fresnel_f82(inner_cosine, straight_below, f82_dark_of_edge(straight_below, edge));
        const auto of = [&](int channel) {
            return conducting(inner_cosine, index, n[channel], k[channel], below[channel]);
        };
        return Faces{of(0), of(1), of(2)};
    });
}
} // namespace tyndall
