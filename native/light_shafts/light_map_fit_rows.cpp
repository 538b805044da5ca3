// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_rows.hpp"
#include "light_shafts/light_map_fit_kernel.hpp"
#include "light_shafts/lit_pieces.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
void grow_focus(const SeenRay& seen, const LightMapAxes& axes, Focus& focus) {
    constexpr float thousandth = 6.9f;
    float first_depth = -1.0f;
    const vec2 origin = axes.metres(seen.ray.origin), per_m = axes.along(seen.ray.direction);
    for_each_lit_part(seen.pieces, seen.lit, [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb&) {
        if (piece.source_per_m == Rgb(0.0f))
            return;
        const auto depth_at = [&](float at_m) {
            const Rgb depth = piece.depth_at_near + piece.depth_per_m * (at_m - piece.near_m);
            return std::min({depth.x, depth.y, depth.z});
        };
        if (first_depth < 0.0f)
            first_depth = depth_at(near_m);
        const float most = first_depth + thousandth, near = depth_at(near_m), far = depth_at(far_m);
        if (near > most && far > most)
            return;
        const float end_m = far > most ? std::lerp(near_m, far_m, (most - near) / (far - near)) : far_m;
        focus.grow(origin + per_m * near_m);
        focus.grow(origin + per_m * end_m);
    });
}

static bool is_grey(const Rgb& value) { return value.x == value.y && value.x == value.z; }

bool is_grey(const SeenRay& seen) {
    return std::ranges::all_of(seen.lit, [](const LitInterval& lit) { return is_grey(lit.transmittance); }) &&
           std::ranges::all_of(seen.pieces, [](const ScatterPiece& piece) {
               return is_grey(piece.source_per_m) && is_grey(piece.depth_at_near) && is_grey(piece.depth_per_m);
           });
}

/// sinh(x) / x: by how much a stretch scatters more than its middle says.
static float sinh_share(float half_gain) {
    const float square = half_gain * half_gain;
    return 1.0f + square * (1.0f / 6.0f + square * (1.0f / 120.0f + square * (1.0f / 5040.0f)));
}

void RowMaker::add_cells(const ScatterPiece& piece, float near_m, float cell_m, std::size_t count,
                         const Rgb& transmittance) {
    const std::size_t first = position_.size(), channels = is_coloured_ ? 3 : 1;
    const float middle_m = near_m + 0.5f * cell_m;
    position_.resize(first + count);
    if (depth_.size() < position_.size() * channels) {
        depth_.resize(2 * position_.size() * channels);
        amount_.resize(depth_.size());
    }
    const float position = along_at_zero_ + along_per_m_ * std::clamp(middle_m, enters_m_, leaves_m_);
    for (std::size_t cell = 0; cell < count; ++cell)
        position_[first + cell] = position + static_cast<float>(cell) * along_per_m_ * cell_m;
    for (std::size_t i = 0; i < channels; ++i) {
        const auto channel = static_cast<int>(i);
        const float gain = piece.depth_per_m[channel] * cell_m;
        float* const depth = &depth_[first * channels + i];
        float* const amount = &amount_[first * channels + i];
        if (std::abs(gain) > 1.0f) { // beyond what sinh_share is for
            for (std::size_t cell = 0; cell < count; ++cell) {
                const float from_m = near_m + static_cast<float>(cell) * cell_m;
                depth[cell * channels] = 0.0f;
                amount[cell * channels] = transmittance[channel] * scattered(piece, from_m, from_m + cell_m)[channel];
            }
            continue;
        }
        const float at_first = piece.depth_at_near[channel] + piece.depth_per_m[channel] * (middle_m - piece.near_m);
        const float of_cell = transmittance[channel] * piece.source_per_m[channel] * cell_m * sinh_share(0.5f * gain);
        for (std::size_t cell = 0; cell < count; ++cell) {
            depth[cell * channels] = at_first + static_cast<float>(cell) * gain;
            amount[cell * channels] = of_cell;
        }
    }
}

void RowMaker::add_part(const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
    float from_m = near_m;
    const auto add_until = [&](float to_m) {
        if (from_m < to_m)
            add_cells(piece, from_m, to_m - from_m, 1, transmittance);
        from_m = std::max(from_m, to_m);
    };
    add_until(std::min(enters_m_, far_m));
    const float last_m = std::min(leaves_m_, far_m);
    if (along_per_m_ != 0.0f && from_m < last_m) {
        const float per_line_m = std::abs(1.0f / along_per_m_), sign = along_per_m_ > 0.0f ? 1.0f : -1.0f;
        const float begin = sign * (along_at_zero_ + along_per_m_ * from_m),
                    end = sign * (along_at_zero_ + along_per_m_ * last_m);
        const float first_line = std::floor(begin) + 1.0f, whole = std::ceil(end) - 1.0f - first_line;
        if (first_line < end)
            add_until(std::min((first_line - sign * along_at_zero_) * per_line_m, last_m));
        if (whole > 0.0f) {
            const float cell_m = std::min(per_line_m, (last_m - from_m) / whole);
            add_cells(piece, from_m, cell_m, static_cast<std::size_t>(whole), transmittance);
            from_m += whole * cell_m;
        }
    }
    add_until(last_m);
    add_until(far_m);
}

float deal_out(std::span<const float> positions, std::span<const float> amounts, std::size_t channels,
               std::vector<float>& line_weights) {
    const auto [lowest, highest] = std::ranges::minmax(positions);
    const std::size_t stored = channels == 1 ? 1 : 4;
    const float first = std::floor(lowest);
    line_weights.assign((static_cast<std::size_t>(std::floor(highest) - first) + 2) * stored, 0.0f);
    for (std::size_t cell = 0; cell < positions.size(); ++cell) {
        const float line = std::floor(positions[cell]), share = positions[cell] - line;
        float* const weights = &line_weights[static_cast<std::size_t>(line - first) * stored];
        for (std::size_t channel = 0; channel < channels; ++channel) {
            const float amount = amounts[cell * channels + channel];
            weights[channel] += (1.0f - share) * amount;
            weights[stored + channel] += share * amount;
        }
    }
    return first;
}

void RowMaker::add_row(const SeenRay& seen, LightMapMatrix::Part& part) {
    const vec2 start = texel_at(place_, axes_.metres(seen.ray.origin)),
               per_m = axes_.along(seen.ray.direction) / place_.texel_m();
    const int axis = std::abs(per_m.y) > std::abs(per_m.x) ? 1 : 0;
    along_at_zero_ = start[axis], along_per_m_ = per_m[axis];
    enters_m_ = seen.ray.near_m, leaves_m_ = seen.ray.far_m;
    const float last = static_cast<float>(place_.resolution) - 2.0f; // its two lines, and two texels of each, are there
    for (int i = 0; i < 2; ++i) {
        if (per_m[i] == 0.0f)
            continue;
        const float a = (1.0f - start[i]) / per_m[i], b = (last - start[i]) / per_m[i];
        enters_m_ = std::max(enters_m_, std::min(a, b));
        leaves_m_ = std::min(leaves_m_, std::max(a, b));
    }
    leaves_m_ = std::max(leaves_m_, enters_m_);
    position_.clear();
    for_each_lit_part(seen.pieces, seen.lit,
                      [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
                          add_part(piece, near_m, far_m, transmittance);
                      });
    const std::size_t channels = is_coloured_ ? 3 : 1, count = position_.size() * channels;
    part.channels = is_coloured_ ? 4 : 1;
    if (position_.empty())
        return part.end_ray();
    light_map_kernel::attenuate(std::span(depth_).first(count), std::span(amount_).first(count));
    for (float& position : position_)
        position = std::clamp(position, 0.0f, last);
    const float first = deal_out(position_, std::span(amount_).first(count), channels, line_weights_);
    // A ray straight into the light stays where it is.
    const float slope = along_per_m_ == 0.0f ? 0.0f : per_m[1 - axis] / along_per_m_;
    part.add_stretches(axis == 1, static_cast<std::uint32_t>(first), start[1 - axis] + (first - start[axis]) * slope,
                       slope, line_weights_);
    part.end_ray();
}
} // namespace tyndall::light_shafts
