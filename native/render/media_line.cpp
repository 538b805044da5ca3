// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/media_line.hpp"
#include "light_shafts/media_ray.hpp"
#include "volume/phase_function.hpp"
#include <cmath>

namespace tyndall::render {
/// Less optical depth bends nothing that cells along a ray would not follow by themselves.
static constexpr float least_depth = 0.2f;
/// Shares of the light that the part takes, between which a cell ends: an eighth each, and of the last one less and less.
static constexpr std::array loss_shares{0.125f, 0.25f, 0.375f, 0.5f, 0.625f, 0.75f, 0.875f, 0.95f, 0.99f};

/// Asymmetry from which directions of the phase function are worth a ray of their own.
static constexpr float least_peak = 0.3f;

static float passing_of(const Rgb& depth) {
    return depth.x == depth.y && depth.y == depth.z ? std::exp(-depth.x) : average(glm::exp(-depth));
}

void MediaLine::append_lobes(std::uint16_t medium, float density) {
    for (const ScatterLobe& lobe : media_->scene().description().media[medium].lobes) {
        lobes_.push_back({density * average(lobe.sigma_s_per_m), lobe.asymmetry_g, lobe.draine_alpha});
        ++pieces_.back().lobe_count;
        pieces_.back().sigma_s_per_m += lobes_.back().sigma_s_per_m;
        has_peak_ |= std::abs(lobe.asymmetry_g) >= least_peak;
    }
}

void MediaLine::append(const MediumSegment& segment, std::uint32_t index, const MediumStep* step) {
    const float near_m = step != nullptr ? step->near_m : segment.near_m,
                far_m = step != nullptr ? step->far_m : segment.far_m;
    if (!(near_m < far_m))
        return;
    const Rgb before = pieces_.empty() ? Rgb(0.0f) : pieces_.back().depth_at(pieces_.back().far_m);
    const Rgb sigma_t = step != nullptr ? step->depth_gain / (far_m - near_m) : media_->sigma_t_per_m(segment.set);
    pieces_.push_back({near_m, far_m, before, sigma_t, index, static_cast<std::uint32_t>(lobes_.size())});
    for (const std::uint16_t medium : std::span(segment.set.media).first(segment.set.count))
        append_lobes(medium, 1.0f);
    if (step == nullptr)
        return;
    for (const GridShare& share : steps_.shares_of(*step)) {
        const GridField& field = media_->grids().field(share.grid, share.channel);
        append_lobes(field.medium, share.density * field.density_scale);
    }
}

void MediaLine::assign(const Media& media, const light_shafts::ViewRay& part, const StepLimits& limits) {
    media_ = &media;
    segments_.clear(), pieces_.clear(), lobes_.clear(), equal_losses_m_.clear();
    part_ = light_shafts::clip_to_media(media, part, segments_).clipped;
    sigma_t_per_m_ = 0.0f;
    has_peak_ = false;
    if (!(part_.near_m < part_.far_m))
        return;
    if (media.grids().is_empty()) {
        for (std::uint32_t index = 0; index < segments_.size(); ++index)
            append(segments_[index], index, nullptr);
    } else {
        steps_.clear();
        append_steps(media, {part_.origin, part_.direction, part_.near_m, part_.far_m}, segments_, limits, steps_);
        for (const MediumStep& step : steps_.of_ray(0))
            append(segments_[step.segment], step.segment, &step);
    }
    if (pieces_.empty())
        return;
    sigma_t_per_m_ =
        average(pieces_.back().depth_at(pieces_.back().far_m)) / (pieces_.back().far_m - pieces_.front().near_m);
    divide_losses();
}

void MediaLine::divide_losses() {
    const float passing = passing_of(pieces_.back().depth_at(pieces_.back().far_m));
    if (passing > std::exp(-least_depth))
        return;
    std::size_t piece = 0;
    for (const float share : loss_shares) {
        const float target = 1.0f - share * (1.0f - passing);
        while (piece + 1 < pieces_.size() && passing_of(pieces_[piece].depth_at(pieces_[piece].far_m)) > target)
            ++piece;
        const Piece& here = pieces_[piece];
        const float sigma_t = average(here.sigma_t_per_m);
        const float left = passing_of(here.depth) / target;
        if (sigma_t > 0.0f && left > 1.0f)
            equal_losses_m_.push_back(std::min(here.near_m + std::log(left) / sigma_t, here.far_m));
    }
}

Rgb MediaLine::transmittance(const Piece& piece, float at_m) const {
    if (media_->grids().is_empty())
        return glm::exp(-piece.depth_at(at_m));
    Rgb depth = piece.depth;
    const Rgb sigma_t = media_->sigma_t_per_m(segments_[piece.segment].set);
    depth += sigma_t * (at_m - piece.near_m) +
             media_->grids().optical_depth({part_.origin, part_.direction, piece.near_m, at_m});
    return glm::exp(-depth);
}

Rgb MediaLine::scatter_per_m_sr(const Piece& piece, float at_m, const vec3& to_light, const LightLinks* links) const {
    const std::vector<Medium>& media = media_->scene().description().media;
    const MediumSet& set = segments_[piece.segment].set;
    const float cosine = glm::dot(to_light, part_.direction); // back along both: 1 is straight on
    Rgb sum(0.0f);
    for (const std::uint16_t medium : std::span(set.media).first(set.count))
        if (links == nullptr || links->lights(media[medium].receiver_set))
            sum += media_->scatter_per_m_sr(medium, cosine);
    if (media_->grids().is_empty())
        return sum;
    const vec3 place = part_.origin + at_m * part_.direction;
    media_->grids().for_each_density(place, [&](const GridField& field, float density) {
        sum += density * field.density_scale * media_->scatter_per_m_sr(field.medium, cosine);
    });
    return sum;
}
} // namespace tyndall::render
