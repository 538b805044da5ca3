// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_solver.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// A step is not cut short: half of it would leave a map that fits nothing. Callers ask for a stop between steps.
static const Progress uninterrupted;

LightMapSolver::Along& LightMapSolver::Along::operator+=(const light_map_passes::Along& stretch) {
    return *this += Along{Channels(stretch.gradient), Channels(stretch.square), Channels(stretch.prior), stretch.limit};
}
LightMapSolver::Along& LightMapSolver::Along::operator+=(const Along& other) {
    gradient += other.gradient;
    square += other.square;
    prior += other.prior;
    limit = glm::min(limit, other.limit);
    return *this;
}
LightMapSolver::Norms& LightMapSolver::Norms::operator+=(const light_map_passes::Norms& stretch) {
    return *this += Norms{Channels(stretch.free), Channels(stretch.held)};
}
LightMapSolver::Norms& LightMapSolver::Norms::operator+=(const Norms& other) {
    free += other.free;
    held += other.held;
    return *this;
}

light_map_passes::Arrays LightMapSolver::arrays() {
    return {.texels = texels_.data(),
            .gradient = gradient_.data(),
            .direction = direction_.data(),
            .displacement = displacement_.data(),
            .prior = prior_.data(),
            .scale = scale_.data(),
            .lambda = lambda_};
}

template <typename Sum, typename Work>
Sum LightMapSolver::sum_over_seen(Sum zero, const Work& work) const {
    return parallel_sum(seen_.size(), 16, zero, uninterrupted, [&](std::size_t begin, std::size_t end) {
        Sum sum = zero;
        for (std::size_t stretch = begin; stretch < end; ++stretch)
            sum += work(seen_[stretch].begin, seen_[stretch].end);
        return sum;
    });
}

LightMapSolver::Channels LightMapSolver::sum_over_rays(const std::vector<vec4>& radiance) const {
    return parallel_sum(radiance.size(), 4096, Channels(0.0), uninterrupted, [&](std::size_t begin, std::size_t end) {
        Channels sum(0.0);
        for (std::size_t ray = begin; ray < end; ++ray)
            sum += Channels(ray_weights_[ray]) * Channels(radiance[ray]) * Channels(radiance[ray]);
        return sum;
    });
}

void LightMapSolver::find_seen(const MapTexels& diagonal) {
    const auto is_seen = [&](std::size_t texel) { return diagonal[texel] != vec4(0.0f); };
    for (std::uint32_t row = 0; row < matrix_.resolution(); ++row) {
        const std::uint32_t first = row * matrix_.pitch(), last = first + matrix_.resolution();
        for (std::uint32_t texel = first; texel < last; ++texel) {
            if (!is_seen(texel))
                continue;
            ++seen_texel_count_;
            constexpr std::uint32_t gap = 8; // shorter ones are passed over faster than around
            if (!seen_.empty() && seen_.back().begin >= first && texel - seen_.back().end < gap)
                seen_.back().end = texel + 1;
            else
                seen_.push_back({texel, texel + 1});
        }
    }
}

LightMapSolver::LightMapSolver(const LightMapMatrix& matrix, std::span<const vec4> target,
                               std::span<const float> ray_weight, MapTexels start, MapTexels prior,
                               float regularisation)
    : matrix_(matrix), ray_weights_(ray_weight.size()), residual_(target.begin(), target.end()), moved_(target.size()),
      texels_(std::move(start)), prior_(std::move(prior)), gradient_(texels_.size()), direction_(texels_.size()),
      displacement_(texels_.size()), scale_(texels_.size()) {
    require(target.size() == matrix.ray_count() && ray_weight.size() == target.size(), "light map fit: ", target.size(),
            " targets and ", ray_weight.size(), " weights for ", matrix.ray_count(), " rays");
    require(texels_.size() == matrix.texel_count() && prior_.size() == texels_.size(),
            "light map fit: ", texels_.size(), " and ", prior_.size(), " texels for a map of ", matrix.texel_count());
    std::ranges::transform(ray_weight, ray_weights_.begin(), [](float weight) { return vec4(weight); });
    white_square_ = sum_over_rays(matrix.white());
    matrix.square_columns(ray_weights_, scale_, uninterrupted);
    find_seen(scale_);
    const Channels trace = sum_over_seen(Channels(0.0), [&](std::size_t begin, std::size_t end) {
        Channels sum(0.0);
        for (std::size_t texel = begin; texel < end; ++texel)
            sum += Channels(scale_[texel]);
        return sum;
    });
    const double mean =
        (trace.x + trace.y + trace.z) / (3.0 * static_cast<double>(std::max<std::size_t>(seen_texel_count_, 1)));
    lambda_ = static_cast<float>(regularisation * mean);
    for (vec4& scale : scale_)
        for (int channel = 0; channel < 4; ++channel)
            scale[channel] = scale[channel] > 0.0f ? 1.0f / (scale[channel] + lambda_) : 0.0f;

    matrix.multiply(texels_, moved_, scratch_, uninterrupted);
    for (std::size_t ray = 0; ray < moved_.size(); ++ray)
        residual_[ray] -= moved_[ray];
    fit_square_ = sum_over_rays(residual_);
    prior_square_ = sum_over_seen(Channels(0.0), [&](std::size_t begin, std::size_t end) {
        Channels sum(0.0);
        for (std::size_t texel = begin; texel < end; ++texel) {
            const Channels away(texels_[texel] - prior_[texel]);
            sum += away * away;
        }
        return sum;
    });
    record();
    turn_after(move(direction_, vec4(0.0f)), glm::bvec4(true));
}

void LightMapSolver::record() {
    FitStep step{};
    double fit = 0.0, white = 0.0;
    for (int channel = 0; channel < 3; ++channel) {
        const double of_white = white_square_[channel] > 0.0 ? white_square_[channel] : 1.0;
        step.objective[static_cast<std::size_t>(channel)] =
            (fit_square_[channel] + lambda_ * prior_square_[channel]) / of_white;
        fit += fit_square_[channel];
        white += white_square_[channel];
    }
    step.residual = white > 0.0 ? std::sqrt(fit / white) : 0.0;
    history_.push_back(step);
}

LightMapSolver::Norms LightMapSolver::move(const MapTexels& direction, const vec4& length) {
    parallel_for(
        residual_.size(), uninterrupted, [&](std::size_t ray) { moved_[ray] = ray_weights_[ray] * residual_[ray]; },
        4096);
    matrix_.multiply_transposed(moved_, gradient_, uninterrupted);
    return sum_over_seen(Norms(), [&, all = arrays()](std::size_t begin, std::size_t end) {
        return light_map_passes::move(all, direction.data(), length, begin, end);
    });
}

void LightMapSolver::turn_after(const Norms& norms, const glm::bvec4& restarts) {
    vec4 conjugacy(0.0f);
    for (int channel = 0; channel < 3; ++channel) {
        // Dostal: texels leave 0 once they could gain more than those that move.
        const bool is_fresh =
            restarts[channel] || norms.held[channel] > norms.free[channel] || !(free_square_[channel] > 0.0);
        conjugacy[channel] = is_fresh ? 0.0f : static_cast<float>(norms.free[channel] / free_square_[channel]);
        free_square_[channel] = norms.free[channel] + (is_fresh ? norms.held[channel] : 0.0);
        is_fresh_[channel] = conjugacy[channel] == 0.0f;
    }
    along_ = sum_over_seen(Along(), [&, all = arrays()](std::size_t begin, std::size_t end) {
        return light_map_passes::turn(all, conjugacy, begin, end);
    });
}

LightMapSolver::Along LightMapSolver::project(vec4& length, const Along& along) {
    const glm::bvec4 is_clipped = glm::greaterThan(length, along.limit);
    while (true) {
        const Along found = sum_over_seen(Along(), [&, all = arrays()](std::size_t begin, std::size_t end) {
            return light_map_passes::project(all, length, begin, end);
        });
        // Towards the whole step's end the objective may rise; close to its beginning it falls.
        bool all_fall = true;
        for (int channel = 0; channel < 3; ++channel)
            if (is_clipped[channel] && !(found.gradient[channel] > 0.0) && length[channel] > along.limit[channel]) {
                length[channel] = std::max(0.5f * length[channel], along.limit[channel]);
                all_fall = false;
            }
        if (all_fall)
            return found;
    }
}

vec4 LightMapSolver::length_of_step(const MapTexels& direction, const Along& along) {
    matrix_.multiply(direction, moved_, scratch_, uninterrupted);
    const Channels curvature = sum_over_rays(moved_) + Channels(lambda_) * along.square;
    vec4 length(0.0f);
    for (int channel = 0; channel < 3; ++channel)
        if (!is_done_[channel] && along.gradient[channel] > 0.0 && curvature[channel] > 0.0)
            length[channel] = static_cast<float>(along.gradient[channel] / curvature[channel]);
    return length;
}

bool LightMapSolver::step() {
    // Where a step as long as the last one leaves what is allowed, the right length would, too: it is not worth a product.
    if (!glm::any(glm::greaterThan(guess_, along_.limit)))
        guess_ = length_of_step(direction_, along_);
    vec4 length = guess_;
    glm::bvec4 is_clipped = glm::greaterThan(length, along_.limit);
    const MapTexels* direction = &direction_;
    Along along = along_;
    if (glm::any(is_clipped)) {
        along = project(length, along_);
        direction = &displacement_;
        const vec4 share = length_of_step(displacement_, along);
        for (int channel = 0; channel < 3; ++channel) {
            const float most = is_clipped[channel] ? 1.0f : along_.limit[channel] / length[channel];
            guess_[channel] = length[channel] * std::clamp(share[channel], 0.25f, 4.0f);
            is_clipped[channel] = is_clipped[channel] || share[channel] > most;
            length[channel] = std::min(share[channel], most);
        }
    }
    const Channels fit =
        parallel_sum(residual_.size(), 4096, Channels(0.0), uninterrupted, [&](std::size_t begin, std::size_t end) {
            Channels sum(0.0);
            for (std::size_t ray = begin; ray < end; ++ray) {
                const Channels left(residual_[ray] - length * moved_[ray]);
                sum += Channels(ray_weights_[ray]) * left * left;
            }
            return sum;
        });
    const Channels steps(length);
    const Channels prior =
        glm::max(prior_square_ + 2.0 * steps * along.prior + steps * steps * along.square, Channels(0.0));
    glm::bvec4 restarts = is_clipped;
    bool has_moved = false;
    for (int channel = 0; channel < 3; ++channel) {
        const double before = fit_square_[channel] + lambda_ * prior_square_[channel];
        if (!is_done_[channel] && fit[channel] + lambda_ * prior[channel] < before) {
            fit_square_[channel] = fit[channel];
            prior_square_[channel] = prior[channel];
            has_moved = true;
        } else {
            length[channel] = 0.0f;
            is_done_[channel] = is_done_[channel] || is_fresh_[channel];
            restarts[channel] = true;
        }
    }
    if (!has_moved && glm::all(glm::bvec3(is_done_)))
        return false;
    parallel_for(
        residual_.size(), uninterrupted, [&](std::size_t ray) { residual_[ray] -= length * moved_[ray]; }, 4096);
    const Norms norms = move(*direction, length);
    record();
    turn_after(norms, restarts);
    return true;
}
} // namespace tyndall::light_shafts
