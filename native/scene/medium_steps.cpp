// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/medium_steps.hpp"
#include <algorithm>

namespace tyndall {
namespace {
constexpr float opaque = 21.0f;    // exp(-21) is 8e-10
constexpr double most_cuts = 32.0; // of a step that is optically thick: its light ends within it

float largest(const Rgb& value) { return std::max({value.x, value.y, value.z}); }
float least(const Rgb& value) { return std::min({value.x, value.y, value.z}); }

/// A step before its densities are known.
struct Cut {
    double near_m, far_m;
    std::uint32_t segment;
    bool is_dense; ///< Some grid may have density there.
};

/// Cuts the ray where its segments and its dense parts begin and end, and every few voxels in the latter.
class Cutter {
public:
    Cutter(const Media& media, const Ray& ray, std::span<const MediumSegment> segments, const StepLimits& limits)
        : media_(media), ray_(ray), segments_(segments), limits_(limits) {}

    void cut(std::vector<Cut>& cuts) {
        for (const PlacedGrid& placed : media_.grids().all())
            add_dense(placed);
        for (const LinePart& part : dense_)
            edges_.push_back(part.far_m);
        std::ranges::sort(edges_);
        cuts.clear();
        auto edge = edges_.begin();
        for (std::uint32_t index = 0; index < segments_.size(); ++index) {
            double at = segments_[index].near_m;
            const double end = segments_[index].far_m;
            while (edge != edges_.end() && *edge <= at)
                ++edge;
            while (at < end) {
                const double until = edge != edges_.end() ? std::min(*edge, end) : end;
                cuts.push_back({at, until, index, is_inside(dense_, 0.5 * (at + until))});
                at = until;
                while (edge != edges_.end() && *edge <= at)
                    ++edge;
            }
        }
    }

private:
    void add_dense(const PlacedGrid& placed) {
        const GridLine line = placed.line(ray_.origin, ray_.direction);
        const double step_m = limits_.length_voxels / glm::length(line.direction);
        double end_m = -std::numeric_limits<double>::infinity();
        for_each_brick(*placed.grid, line, ray_.near_m, ray_.far_m,
                       [&](const DensityGrid::Brick&, double near_m, double far_m, const glm::ivec3&) {
                           if (near_m > end_m) { // after empty bricks
                               edges_.push_back(near_m);
                               dense_.push_back({near_m, far_m});
                               next_m_ = near_m + step_m;
                           }
                           for (; next_m_ < far_m; next_m_ += step_m)
                               edges_.push_back(next_m_);
                           dense_.back().far_m = end_m = far_m;
                           return true;
                       });
    }

    const Media& media_;
    const Ray& ray_;
    std::span<const MediumSegment> segments_;
    const StepLimits& limits_;
    std::vector<double> edges_;
    std::vector<LinePart> dense_;
    double next_m_ = 0.0;
};

/// Adds the integrals of a grid's densities over each cut to its column of `integrals`.
void integrate(const PlacedGrid& placed, const Ray& ray, std::span<const Cut> cuts, std::span<glm::dvec4> integrals) {
    with_density_type(*placed.grid, [&]<class Density>(const Density&) {
        std::size_t cut = 0;
        for_each_cell<Density>(*placed.grid, placed.line(ray.origin, ray.direction), ray.near_m, ray.far_m,
                               [&](const CellSpan<Density>& span) {
                                   while (cut < cuts.size() && cuts[cut].far_m <= span.near_m)
                                       ++cut;
                                   for (std::size_t at = cut; at < cuts.size() && cuts[at].near_m < span.far_m; ++at)
                                       add_integral(integrals[at], span.integral(std::max(span.near_m, cuts[at].near_m),
                                                                                 std::min(span.far_m, cuts[at].far_m)));
                                   return cut < cuts.size();
                               });
    });
}

struct Workspace {
    std::vector<Cut> cuts, finer;
    std::vector<glm::dvec4> integrals; ///< Of each channel's density; grid by grid, cut by cut.
};

Rgb depth_gain(const Media& media, const Workspace& work, std::size_t cut, const Rgb& sigma_t_of_segment) {
    const auto length_m = static_cast<float>(work.cuts[cut].far_m - work.cuts[cut].near_m);
    Rgb gain(0.0f);
    for (int channel = 0; channel < 3; ++channel) // 0 * infinity is not the depth of an endless clear segment
        if (sigma_t_of_segment[channel] > 0.0f)
            gain[channel] = sigma_t_of_segment[channel] * length_m;
    std::size_t row = cut;
    for (const PlacedGrid& placed : media.grids().all()) {
        gain += placed.sigma_t_per_m(vec4(work.integrals[row]));
        row += work.cuts.size();
    }
    return gain;
}

void integrate_all(const Media& media, const Ray& ray, Workspace& work) {
    const std::size_t count = work.cuts.size();
    work.integrals.assign(count * media.grids().all().size(), glm::dvec4(0.0));
    Ray reached = ray;
    reached.far_m = static_cast<float>(count == 0 ? ray.near_m : work.cuts.back().far_m);
    std::size_t row = 0;
    for (const PlacedGrid& placed : media.grids().all()) {
        integrate(placed, reached, work.cuts, std::span(work.integrals).subspan(row, count));
        row += count;
    }
}

/// Cuts those that are optically thick into thinner ones, and drops what lies behind too much. False: none are.
bool refine(const Media& media, std::span<const Rgb> sigma_t_of_segment, float most_gain, Workspace& work) {
    bool has_thick = false;
    Rgb before(0.0f);
    work.finer.clear();
    for (std::size_t index = 0; index < work.cuts.size() && least(before) < opaque; ++index) {
        const Cut& cut = work.cuts[index];
        const Rgb gain = depth_gain(media, work, index, sigma_t_of_segment[cut.segment]);
        double parts = 1.0;
        if (cut.is_dense && largest(gain) > most_gain) {
            parts = std::min(std::ceil(double{largest(gain)} / most_gain), most_cuts);
            has_thick = true;
        }
        for (double part = 0.0; part < parts; part += 1.0)
            work.finer.push_back(
                {std::lerp(cut.near_m, cut.far_m, part / parts),
                 part + 1.0 < parts ? std::lerp(cut.near_m, cut.far_m, (part + 1.0) / parts) : cut.far_m, cut.segment,
                 cut.is_dense});
        before += gain;
    }
    if (has_thick)
        std::swap(work.cuts, work.finer);
    return has_thick;
}
} // namespace

void append_steps(const Media& media, const Ray& ray, std::span<const MediumSegment> segments, const StepLimits& limits,
                  MediumSteps& steps) {
    thread_local Workspace work;
    thread_local std::vector<Rgb> sigma_t;
    sigma_t.clear();
    for (const MediumSegment& segment : segments)
        sigma_t.push_back(media.sigma_t_per_m(segment.set));
    Cutter(media, ray, segments, limits).cut(work.cuts);
    integrate_all(media, ray, work);
    if (refine(media, sigma_t, limits.depth_gain, work))
        integrate_all(media, ray, work);
    Rgb depth(0.0f);
    for (std::size_t cut = 0; cut < work.cuts.size() && least(depth) < opaque; ++cut) {
        const auto& [near_m, far_m, segment, is_dense] = work.cuts[cut];
        MediumStep step{.near_m = static_cast<float>(near_m),
                        .far_m = static_cast<float>(far_m),
                        .segment = segment,
                        .depth_gain = depth_gain(media, work, cut, sigma_t[segment]),
                        .first_share = static_cast<std::uint32_t>(steps.shares.size())};
        if (!(step.near_m < step.far_m))
            continue;
        for (std::size_t grid = 0; grid < media.grids().all().size(); ++grid)
            for (std::size_t channel = 0; channel < media.grids().all()[grid].grid->channel_count(); ++channel)
                if (const double integral = work.integrals[grid * work.cuts.size() + cut][static_cast<int>(channel)];
                    integral > 0.0)
                    steps.shares.push_back({static_cast<std::uint16_t>(grid), static_cast<std::uint16_t>(channel),
                                            static_cast<float>(integral / (far_m - near_m))});
        step.share_count = static_cast<std::uint32_t>(steps.shares.size()) - step.first_share;
        depth += step.depth_gain;
        if (steps.steps.size() > steps.first.back() && step.share_count == 0)
            if (MediumStep& last = steps.steps.back(); last.share_count == 0 && last.segment == segment) {
                last.far_m = step.far_m;
                last.depth_gain += step.depth_gain;
                continue;
            }
        steps.steps.push_back(step);
    }
    steps.end_ray();
}

void append_union(std::span<const MediumSegment> homogeneous, std::span<const LinePart> dense,
                  std::vector<MediumSegment>& segments) {
    const std::size_t first = segments.size();
    segments.insert(segments.end(), homogeneous.begin(), homogeneous.end());
    const auto begin = [&] { return segments.begin() + static_cast<std::ptrdiff_t>(first); };
    for (const LinePart& part : dense) {
        auto at = static_cast<float>(part.near_m);
        const auto end = static_cast<float>(part.far_m);
        const std::size_t count = segments.size();
        // What came before is in order.
        for (std::size_t index = first; index < count && at < end; ++index) {
            const auto [near_m, far_m, set] = segments[index];
            if (far_m <= at)
                continue;
            if (near_m > at)
                segments.push_back({at, std::min(near_m, end), {}});
            at = std::max(at, far_m);
        }
        if (at < end)
            segments.push_back({at, end, {}});
        std::sort(begin(), segments.end(),
                  [](const MediumSegment& a, const MediumSegment& b) { return a.near_m < b.near_m; });
    }
}
} // namespace tyndall
