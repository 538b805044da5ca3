// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/scatter_pieces.hpp"
#include "light_shafts/light_side_depth.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
float mean_transmittance(float optical_depth) {
    if (optical_depth < 1e-3f) // third order: 4e-11 at the seam
        return 1.0f - optical_depth * (0.5f - optical_depth * (1.0f / 6.0f));
    return -std::expm1(-optical_depth) / optical_depth;
}

Rgb scattered(const ScatterPiece& piece, float near_m, float far_m) {
    const float length_m = far_m - near_m;
    Rgb radiance;
    for (int channel = 0; channel < 3; ++channel) {
        const float gain = piece.depth_per_m[channel] * length_m;
        const float at_near = piece.depth_at_near[channel] + piece.depth_per_m[channel] * (near_m - piece.near_m);
        // From the end that loses less: nothing overflows, whichever way the depth grows.
        radiance[channel] = piece.source_per_m[channel] * length_m * std::exp(-(at_near + std::min(gain, 0.0f))) *
                            mean_transmittance(std::abs(gain));
    }
    return radiance;
}

DirectionalScatter::DirectionalScatter(const Media& media, const LightSample& light)
    : media_(media), irradiance_(light.strength), light_(light) {
    if (light.is_dimmed_by_media && media.fills_world()) {
        MediumSet world;
        world.insert(static_cast<std::uint16_t>(media.world_medium_index()));
        const Rgb sigma_t = media.sigma_t_per_m(world);
        for (int channel = 0; channel < 3; ++channel)
            if (sigma_t[channel] > 0.0f)
                irradiance_[channel] = 0.0f; // infinitely far away: nothing is left
    }
    Rgb sigma_s(0.0f);
    for (const Medium& medium : media.scene().description().media)
        sigma_s += medium.sigma_s_per_m();
    is_black_ = media.is_empty() || irradiance_ * sigma_s == Rgb(0.0f);
}

namespace {
/// Sums over the light-side terms that hold at a place, as the sweep goes from near to far.
struct LightSide {
    dvec3 depth_at_zero{0.0}, depth_per_m{0.0};
    void add(const LightSideTerm& term, const dvec3& sigma_t_per_m, double sign) {
        depth_at_zero += sign * term.way_at_zero_m * sigma_t_per_m;
        depth_per_m += sign * term.way_per_m * sigma_t_per_m;
    }
};

/// Where light all but runs along a boundary, a term is as steep as it is short: it would take the digits of all others
/// with it into the sums, for a part of the ray that nobody sees.
bool is_over_at_once(const LightSideTerm& term) {
    constexpr double negligible = 1e-8;
    const auto way_m = [&](double at) { return std::abs(term.way_at_zero_m + at * term.way_per_m); };
    const double scale_m = std::abs(term.near_m) + std::abs(term.far_m) + way_m(term.near_m) + way_m(term.far_m);
    return term.far_m - term.near_m < negligible * scale_m;
}

/// The light's way through homogeneous media to the points of a ray, from near to far.
class LightSideSweep {
public:
    void begin(const Media& media, const ViewRay& inside, const vec3& towards_light) {
        terms_.clear(), by_far_.clear(), sigma_t_of_term_.clear();
        light_side_ = {}, begun_ = ended_ = 0;
        for (const MediumBoundary& boundary : media.boundaries())
            append_light_side_terms(media, boundary, inside, towards_light, terms_);
        std::erase_if(terms_, is_over_at_once);
        std::ranges::sort(terms_, {}, &LightSideTerm::near_m);
        for (std::uint32_t term = 0; term < terms_.size(); ++term) {
            MediumSet alone;
            alone.insert(terms_[term].medium);
            sigma_t_of_term_.emplace_back(media.sigma_t_per_m(alone));
            by_far_.push_back(term);
        }
        std::ranges::sort(by_far_, {}, [&](std::uint32_t term) { return terms_[term].far_m; });
    }
    void begin_without() {
        terms_.clear(), by_far_.clear();
        light_side_ = {}, begun_ = ended_ = 0;
    }
    /// Calls visit(from, to, light side) for the parts of [from, end) on which the light's way is linear.
    template <class Visit>
    void visit(double from, double end, const Visit& visit) {
        while (from < end) {
            while (begun_ < terms_.size() && terms_[begun_].near_m <= from)
                light_side_.add(terms_[begun_], sigma_t_of_term_[begun_], 1.0), ++begun_;
            while (ended_ < terms_.size() && terms_[by_far_[ended_]].far_m <= from)
                light_side_.add(terms_[by_far_[ended_]], sigma_t_of_term_[by_far_[ended_]], -1.0), ++ended_;
            double to = end;
            if (begun_ < terms_.size())
                to = std::min(to, terms_[begun_].near_m);
            if (ended_ < terms_.size())
                to = std::min(to, terms_[by_far_[ended_]].far_m);
            visit(from, to, light_side_);
            from = to;
        }
    }

private:
    std::vector<LightSideTerm> terms_;
    std::vector<std::uint32_t> by_far_;
    std::vector<dvec3> sigma_t_of_term_;
    LightSide light_side_;
    std::size_t begun_ = 0, ended_ = 0;
};

/// Where light all but runs along a boundary, its way grows by metres within less than a float tells apart: a piece whose
/// ends rounding moved keeps the depths that it had there.
ScatterPiece piece_between(double near_m, double far_m, const Rgb& source_per_m, const dvec3& depth_at_near,
                           const dvec3& depth_per_m) {
    ScatterPiece piece{.near_m = static_cast<float>(near_m),
                       .far_m = static_cast<float>(far_m),
                       .source_per_m = source_per_m,
                       .depth_at_near = Rgb(depth_at_near),
                       .depth_per_m = Rgb(depth_per_m)};
    constexpr double negligible = 1e-3;
    const double length_m = double{piece.far_m} - piece.near_m, exact_m = far_m - near_m;
    if (length_m > 0.0 && std::abs(length_m - exact_m) > negligible * length_m)
        piece.depth_per_m = Rgb(depth_per_m * (exact_m / length_m));
    return piece;
}

/// Of one thread: begun for a ray.
LightSideSweep& begin_sweep(const Media& media, const ViewRay& ray, std::span<const MediumSegment> segments,
                            const LightSample& light) {
    thread_local LightSideSweep sweep;
    if (light.is_dimmed_by_media)
        sweep.begin(media, {ray.origin, ray.direction, segments.front().near_m, segments.back().far_m},
                    light.towards_light);
    else
        sweep.begin_without();
    return sweep;
}
} // namespace

void DirectionalScatter::append_pieces(const ViewRay& ray, std::span<const MediumSegment> segments,
                                       std::vector<ScatterPiece>& pieces) const {
    if (segments.empty())
        return;
    if (!media_.grids().is_empty()) {
        thread_local MediumSteps steps;
        steps.clear();
        append_steps(media_, {ray.origin, ray.direction, ray.near_m, ray.far_m}, segments, {}, steps);
        append_grid_pieces(ray, segments, steps, 0, pieces);
        return;
    }
    LightSideSweep& sweep = begin_sweep(media_, ray, segments, light_);
    const float cosine = glm::dot(ray.direction, light_.towards_light);
    dvec3 camera_depth(0.0);
    for (const MediumSegment& segment : segments) {
        const Rgb source = irradiance_ * media_.scatter_per_m_sr(segment.set, cosine);
        const dvec3 sigma_t(media_.sigma_t_per_m(segment.set));
        sweep.visit(segment.near_m, segment.far_m, [&](double from, double to, const LightSide& light_side) {
            const dvec3 light_depth = light_side.depth_at_zero + from * light_side.depth_per_m;
            pieces.push_back(piece_between(from, to, source, camera_depth + glm::max(light_depth, dvec3(0.0)),
                                           sigma_t + light_side.depth_per_m));
            camera_depth += sigma_t * (to - from);
        });
    }
}

void DirectionalScatter::append_grid_pieces(const ViewRay& ray, std::span<const MediumSegment> segments,
                                            const MediumSteps& all_steps, std::size_t index,
                                            std::vector<ScatterPiece>& pieces) const {
    const std::span<const MediumStep> steps = all_steps.of_ray(index);
    if (segments.empty() || steps.empty())
        return;
    LightSideSweep& sweep = begin_sweep(media_, ray, segments, light_);
    thread_local std::vector<LinePart> reached;                                            // through grids
    thread_local std::vector<std::array<Rgb, DensityGrid::most_channels>> scatter_of_grid; // and channel
    reached.clear(), scatter_of_grid.clear();
    if (grid_depth_)
        grid_depth_->append_reached(ray.origin, ray.direction, steps.front().near_m, steps.back().far_m, reached);
    const float cosine = glm::dot(ray.direction, light_.towards_light);
    for (const PlacedGrid& placed : media_.grids().all()) {
        auto scatter = scatter_of_grid.emplace_back().begin();
        for (const GridField& field : placed.used_fields())
            *scatter++ = field.density_scale * media_.scatter_per_m_sr(field.medium, cosine);
    }
    dvec3 camera_depth(0.0);
    double known_at = -1.0; // where known_depth holds
    Rgb known_depth(0.0f);
    const auto grid_depth_at = [&](double at) {
        if (at != known_at) {
            known_depth = grid_depth_->depth(ray.origin + static_cast<float>(at) * ray.direction);
            known_at = at;
        }
        return dvec3(known_depth);
    };
    for (const MediumStep& step : steps) {
        Rgb source = media_.scatter_per_m_sr(segments[step.segment].set, cosine);
        for (const GridShare& share : all_steps.shares_of(step))
            source += share.density * scatter_of_grid[share.grid][share.channel];
        source *= irradiance_;
        const dvec3 sigma_t = dvec3(step.depth_gain) / (double{step.far_m} - step.near_m);
        const bool is_asked = source != Rgb(0.0f);
        sweep.visit(step.near_m, step.far_m, [&](double begin, double past, const LightSide& light_side) {
            for (double from = begin, end; from < past; from = end) {
                end = is_asked ? next_end(reached, from, past) : past;
                const bool is_reached = is_asked && is_inside(reached, 0.5 * (from + end));
                const double count =
                    is_reached && step.share_count == 0 ? std::ceil((end - from) / grid_piece_m_) : 1.0;
                for (double part = 0.0, at = from; part < count; part += 1.0) {
                    const double to = part + 1.0 < count ? std::lerp(from, end, (part + 1.0) / count) : end;
                    dvec3 light_depth = glm::max(light_side.depth_at_zero + at * light_side.depth_per_m, dvec3(0.0));
                    dvec3 depth_per_m = sigma_t + light_side.depth_per_m;
                    if (is_reached && at < to) {
                        const dvec3 at_near = grid_depth_at(at);
                        light_depth += at_near;
                        depth_per_m += (grid_depth_at(to) - at_near) / (to - at);
                    }
                    pieces.push_back(piece_between(at, to, source, camera_depth + light_depth, depth_per_m));
                    camera_depth += sigma_t * (to - at);
                    at = to;
                }
            }
        });
    }
    // Behind what lets nothing through the ray still counts as lit, or not.
    if (steps.back().far_m < segments.back().far_m)
        pieces.push_back(
            {.near_m = steps.back().far_m, .far_m = segments.back().far_m, .depth_at_near = Rgb(camera_depth)});
}

void DirectionalScatter::dim_by_grids(const GridLoss& loss) {
    if (!light_.is_dimmed_by_media || media_.grids().is_empty())
        return;
    grid_depth_.emplace(media_, light_);
    if (loss.spacing_voxels > 0.0f)
        grid_depth_->tabulate(loss.spacing_voxels);
    grid_piece_m_ = loss.piece_voxels * media_.grids().least_voxel_m();
}

bool DirectionalScatter::is_dimmed_by_grids(const ViewRay& ray) const {
    return grid_depth_ && grid_depth_->reaches(ray.origin, ray.direction, ray.near_m, ray.far_m);
}
} // namespace tyndall::light_shafts
