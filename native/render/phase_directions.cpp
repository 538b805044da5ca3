// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/phase_directions.hpp"
#include "core/sampling.hpp"
#include "volume/phase_function.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
/// Of an even light, what a piece sends to the part's beginning.
static float scattered_by(const MediaLine::Piece& piece) {
    const float length_m = piece.far_m - piece.near_m, sigma_t = average(piece.sigma_t_per_m);
    const float reach_m = sigma_t * length_m > 1e-4f ? -std::expm1(-sigma_t * length_m) / sigma_t : length_m;
    return piece.sigma_s_per_m * std::exp(-average(piece.depth)) * reach_m;
}

PhaseDirections::PhaseDirections(const MediaLine& line) : line_(line) {
    for (const MediaLine::Piece& piece : line.pieces())
        sum_ += scattered_by(piece);
}

PhaseDirections::Distance PhaseDirections::distance(float u) const {
    if (!(sum_ > 0.0f))
        return {};
    Distance drawn;
    float left = u * sum_, here = 0.0f;
    for (const MediaLine::Piece& piece : line_.pieces()) {
        const float scattered = scattered_by(piece);
        if (!(scattered > 0.0f))
            continue;
        if (drawn.piece != nullptr && left < here)
            break;
        left -= here;
        here = scattered;
        drawn.piece = &piece; // the last one takes what rounding leaves
    }
    if (drawn.piece == nullptr)
        return {};
    const MediaLine::Piece& piece = *drawn.piece;
    const float part = std::clamp(left / here, 0.0f, 0x1.fffffep-1f);
    const float length_m = piece.far_m - piece.near_m, sigma_t = average(piece.sigma_t_per_m);
    drawn.at_m = sigma_t * length_m > 1e-4f
                     ? piece.near_m - std::log1p(part * std::expm1(-sigma_t * length_m)) / sigma_t
                     : piece.near_m + part * length_m;
    drawn.at_m = std::clamp(drawn.at_m, piece.near_m, piece.far_m);
    return drawn;
}

float PhaseDirections::density_per_m(const MediaLine::Piece& piece, float at_m) const {
    return sum_ > 0.0f ? piece.sigma_s_per_m * std::exp(-average(piece.depth_at(at_m))) / sum_ : 0.0f;
}

PhaseDirections::Drawn PhaseDirections::at(vec2 u, vec2 u_direction) const {
    const Distance distance = this->distance(u.x);
    if (distance.piece == nullptr)
        return {};
    const MediaLine::Piece& piece = *distance.piece;
    float target = u.y * piece.sigma_s_per_m, asymmetry_g = 0.0f;
    for (const MediaLine::Lobe& lobe : line_.lobes_of(piece)) {
        if (!(lobe.sigma_s_per_m > 0.0f))
            continue;
        asymmetry_g = lobe.asymmetry_g;
        if (target < lobe.sigma_s_per_m)
            break;
        target -= lobe.sigma_s_per_m;
    }
    const float cosine = sample_henyey_greenstein_cosine(asymmetry_g, u_direction.x);
    return {&piece, distance.at_m, direction_around(line_.direction(), cosine, u_direction.y)};
}

float PhaseDirections::density(const MediaLine::Piece& piece, float at_m, const vec3& direction) const {
    if (!(sum_ > 0.0f))
        return 0.0f;
    const float cosine = glm::dot(direction, line_.direction());
    float scattered = 0.0f;
    for (const MediaLine::Lobe& lobe : line_.lobes_of(piece))
        scattered += lobe.sigma_s_per_m * henyey_greenstein_per_sr(cosine, lobe.asymmetry_g);
    return scattered * std::exp(-average(piece.depth_at(at_m))) / sum_;
}
} // namespace tyndall::render
