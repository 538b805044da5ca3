// SPDX-License-Identifier: GPL-3.0-or-later
// A light at a point among density grids: pieces of the rays' steps, short enough as the light sees them.
// Bound:    one look at the light and one at the depths between per piece, three where it is wide for the light; a ray
//           that passes the light by has 30 pieces beyond its steps. The light's fall with distance and angle is integrated
//           by the midpoint, or by Simpson's rule where that would not do: 1e-4.
#include "light_shafts/lit_pieces.hpp"
#include "light_shafts/local_reached.hpp"
#include "scene/light_texture.hpp"
#include "scene/softened_patch.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
static constexpr double most_angle_rad = 0.1;    // under which the light sees a piece
static constexpr double narrow_angle_rad = 0.03; // of which the midpoint tells enough: 0.03^2 / 12

/// Cuts the steps of one ray after another into pieces for one light.
class LocalScatter::GridPieces {
public:
    explicit GridPieces(const LocalScatter& light) : light_(light), media_(light.media_) {}

    /// Of the part [begin_m, end_m] of the ray, which the light can shine on.
    void cut(const ViewRay& ray, std::span<const LocalRays::Segment> segments, std::span<const SetOfMedia> sets,
             const MediumSteps& steps, std::size_t step_row, const LocalSupport& support, std::size_t support_row,
             std::vector<ScatterPiece>& pieces) {
        ray_ = &ray;
        known_at_m_ = -1.0;
        foot_m_ = support.distance[LocalSupport::LightX][support_row];
        aside_m_ = support.distance[LocalSupport::LightY][support_row];
        const double begin_m = foot_m_ + support.distance[LocalSupport::Begin][support_row];
        const double end_m = foot_m_ + support.distance[LocalSupport::End][support_row];
        edges_.clear();
        if (light_.shape_.has_soft_edge)
            for (const auto which : {LocalSupport::Inner0, LocalSupport::Inner1})
                edges_.push_back(foot_m_ + support.distance[which][support_row]);
        if (light_.shape_.sphere_radius_m > 0.0)
            for (const auto which : {LocalSupport::Body0, LocalSupport::Body1})
                edges_.push_back(foot_m_ + support.distance[which][support_row]);
        if (light_.light_.is_dimmed_by_media) { // bends where a boundary of fog is between
            crossings_.clear();
            light_.boundaries_.append_crossings(
                {ray.origin, ray.direction, static_cast<float>(begin_m), static_cast<float>(end_m)}, crossings_);
            for (const LocalCrossing& crossing : crossings_)
                edges_.insert(edges_.end(), {crossing.near_m, crossing.far_m});
        }
        reached_.clear();
        if (light_.grid_depth_)
            light_.grid_depth_->append_reached(ray.origin, ray.direction, static_cast<float>(begin_m),
                                               static_cast<float>(end_m), reached_);
        Rgb camera_depth(0.0f);
        for (const MediumStep& step : steps.of_ray(step_row)) {
            const double near_m = std::max<double>(step.near_m, begin_m), far_m = std::min<double>(step.far_m, end_m);
            const Rgb depth_per_m = step.depth_gain / (step.far_m - step.near_m);
            if (near_m < far_m) {
                const MediumSet& set = sets[segments[step.segment].set].set;
                const std::span<const GridShare> shares = steps.shares_of(step);
                if (!set.is_empty() || !shares.empty())
                    cut_step(near_m, far_m, set, shares,
                             camera_depth + depth_per_m * static_cast<float>(near_m - step.near_m), depth_per_m,
                             pieces);
            }
            camera_depth += step.depth_gain;
        }
    }

private:
    [[nodiscard]] vec3 point(double at_m) const { return ray_->origin + static_cast<float>(at_m) * ray_->direction; }
    /// Radiance per metre that the step's media scatter towards the camera.
    [[nodiscard]] Rgb source(double at_m, const MediumSet& set, std::span<const GridShare> shares) const {
        const LightSample& light = light_.light_;
        const vec3 at = point(at_m);
        if (at == light.position)
            return Rgb(0.0f);
        const LocalView view = view_local(light, at);
        const float cosine =
            -glm::dot(ray_->direction, view.from_light); // from the light's way to the way to the camera
        Rgb scatter = media_.scatter_per_m_sr(set, cosine);
        for (const GridShare& share : shares) {
            const GridField& field = media_.grids().field(share.grid, share.channel);
            scatter += share.density * field.density_scale * media_.scatter_per_m_sr(field.medium, cosine);
        }
        const Rgb colour = light.textured ? texture_colour(light, at) : Rgb(1.0f);
        return scatter * colour * view.irradiance;
    }
    [[nodiscard]] Rgb light_depth(double at_m, bool is_reached) const {
        if (!light_.light_.is_dimmed_by_media)
            return Rgb(0.0f);
        const vec3 at = point(at_m), position = light_.light_.position;
        if (at == position)
            return Rgb(0.0f);
        const Rgb passing = media_.homogeneous_transmittance({.origin = at,
                                                              .direction = glm::normalize(position - at),
                                                              .near_m = 0.0f,
                                                              .far_m = local_distance_m(light_.light_, at)});
        const Rgb depth = -glm::log(glm::max(passing, Rgb(1e-30f)));
        return is_reached ? depth + light_.grid_depth_->depth(at) : depth;
    }

    void cut_step(double near_m, double far_m, const MediumSet& set, std::span<const GridShare> shares,
                  const Rgb& depth_at_near, const Rgb& depth_per_m, std::vector<ScatterPiece>& pieces) {
        const auto angle_at = [&](double at_m) { return std::atan2(at_m - foot_m_, aside_m_); };
        for (double from = near_m; from < far_m;) {
            double end = next_end(reached_, from, far_m);
            for (const double edge : edges_)
                if (edge > from && edge < end)
                    end = edge;
            const bool is_reached = is_inside(reached_, 0.5 * (from + end));
            const double first = angle_at(from), last = angle_at(end);
            const double turns = std::max(1.0, std::ceil((last - first) / most_angle_rad));
            for (double turn = 0.0, at = from; turn < turns; turn += 1.0) {
                const double until =
                    turn + 1.0 < turns
                        ? std::clamp(foot_m_ + aside_m_ * std::tan(std::lerp(first, last, (turn + 1.0) / turns)), at,
                                     end)
                        : end;
                const double parts =
                    is_reached && shares.empty() ? std::max(1.0, std::ceil((until - at) / light_.grid_piece_m_)) : 1.0;
                for (double part = 0.0, start = at; part < parts; part += 1.0) {
                    const double stop = part + 1.0 < parts ? std::lerp(at, until, (part + 1.0) / parts) : until;
                    if (start < stop)
                        append({start, stop, set, shares, is_reached, last - first > turns * parts * narrow_angle_rad},
                               depth_at_near + depth_per_m * static_cast<float>(start - near_m), depth_per_m, pieces);
                    start = stop;
                }
                at = until;
            }
            from = end;
        }
    }

    struct Part {
        double from, to;
        const MediumSet& set;
        std::span<const GridShare> shares;
        bool is_reached, is_wide; ///< By light through a grid; as the light sees it.
    };
    void append(const Part& part, const Rgb& camera_depth, const Rgb& camera_depth_per_m,
                std::vector<ScatterPiece>& pieces) {
        const auto& [from, to, set, shares, is_reached, is_wide] = part;
        Rgb mean = source(0.5 * (from + to), set, shares);
        if (is_wide)
            mean = (source(from, set, shares) + 4.0f * mean + source(to, set, shares)) / 6.0f;
        if (mean == Rgb(0.0f))
            return;
        // Where a piece ends the next one mostly begins.
        const Rgb at_near =
            from == known_at_m_ && is_reached == is_known_reached_ ? known_depth_ : light_depth(from, is_reached);
        const Rgb at_far = light_depth(to, is_reached);
        known_at_m_ = to, known_depth_ = at_far, is_known_reached_ = is_reached;
        pieces.push_back({.near_m = static_cast<float>(from),
                          .far_m = static_cast<float>(to),
                          .source_per_m = mean,
                          .depth_at_near = camera_depth + at_near,
                          .depth_per_m = camera_depth_per_m + (at_far - at_near) / static_cast<float>(to - from)});
    }

    const LocalScatter& light_;
    const Media& media_;
    const ViewRay* ray_ = nullptr;
    double foot_m_ = 0.0, aside_m_ = 0.0; ///< Of the light, along the ray and beside it.
    double known_at_m_ = -1.0;            ///< Where known_depth_ is the light's.
    Rgb known_depth_{0.0f};
    bool is_known_reached_ = false;
    std::vector<double> edges_;
    std::vector<LocalCrossing> crossings_;
    std::vector<LinePart> reached_;
};

void LocalScatter::scatter_in_grids(const LocalRays& rays, const MediumSteps& steps,
                                    std::span<const std::uint32_t> step_rows, const Visibility* visibility,
                                    std::span<Rgb> radiance, std::span<Rgb> unshadowed) const {
    thread_local Reached reached;
    thread_local std::vector<ScatterPiece> pieces;
    GridPieces cutter(*this);
    find_reached(rays, visibility, reached);
    std::ranges::fill(radiance, Rgb(0.0f));
    std::ranges::fill(unshadowed, Rgb(0.0f));
    for (std::size_t row = 0; row < reached.rays.size(); ++row) {
        const std::span<const LitInterval> lit = reached.lit.of_ray(row);
        if (lit.empty() && unshadowed.empty())
            continue;
        const std::uint32_t ray = reached.rays[row];
        pieces.clear();
        cutter.cut(rays.ray(ray), rays.segments_of(ray), rays.sets(), steps, step_rows[ray], reached.support, ray,
                   pieces);
        for_each_lit_part(std::span<const ScatterPiece>(pieces), lit,
                          [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
                              radiance[ray] += transmittance * scattered(piece, near_m, far_m);
                          });
        for (std::size_t piece = 0; !unshadowed.empty() && piece < pieces.size(); ++piece)
            unshadowed[ray] += scattered(pieces[piece], pieces[piece].near_m, pieces[piece].far_m);
    }
}

void LocalScatter::dim_by_grids(const GridLoss& loss) {
    if (!light_.is_dimmed_by_media || media_.grids().is_empty())
        return;
    grid_depth_.emplace(media_, light_);
    if (loss.spacing_voxels > 0.0f)
        grid_depth_->tabulate(loss.spacing_voxels);
    grid_piece_m_ = loss.piece_voxels * media_.grids().least_voxel_m();
}

bool LocalScatter::is_dimmed_by_grids(const ViewRay& ray) const {
    return grid_depth_ && grid_depth_->reaches(ray.origin, ray.direction, ray.near_m, ray.far_m);
}
} // namespace tyndall::light_shafts
