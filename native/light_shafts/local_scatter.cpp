// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/local_reached.hpp"
#include "light_shafts/local_scatter_kernel.hpp"
#include "light_shafts/local_sent.hpp"
#include "light_shafts/picture_along_ray.hpp"
#include <algorithm>
#include <cmath>
#include <optional>

namespace tyndall::light_shafts {
/// Of a smooth piece before a textured light: two per texel, for interpolation bends at each. Where more texels lie there,
/// parts are longer and read means.
static constexpr float fewest_texture_parts = 6.0f, most_texture_parts = 32.0f;
/// Of the way between two places where the picture is read, how much of it a mean is over. What nodes draw is mostly smooth
/// over many texels: half as wide, means blur it four times less.
static float means_wide(const LightTexture& texture) {
    return texture.projection == LightProjection::Directions ? 0.25f : 0.5f;
}
/// Of one whose light changes with the distance, which grows 6 times along the longest piece.
static constexpr float fewest_distance_parts = 16.0f;

LocalScatter::LocalScatter(const Media& media, const LightSample& light)
    : media_(media), light_(light), shape_(light), boundaries_(media, light.position) {
    Rgb sigma_s(0.0f);
    for (const Medium& medium : media.scene().description().media)
        sigma_s += medium.sigma_s_per_m();
    is_black_ = media.is_empty() || light.strength * sigma_s == Rgb(0.0f);
    if (!light.is_dimmed_by_media)
        return;
    // Any direction tells which media hold the light; this one lies in no plane that modellers favour.
    std::vector<MediumSegment> segments;
    media.segments({.origin = light.position, .direction = glm::normalize(vec3(0.36f, 0.48f, 0.8f))}, segments);
    if (!segments.empty() && segments.front().near_m == 0.0f) {
        const Rgb sigma_t = media.sigma_t_per_m(segments.front().set);
        sigma_t_at_light_ = {sigma_t.x, sigma_t.y, sigma_t.z};
    }
}

/// Cuts lit parts of rays into smooth pieces and integrates them, a few hundred at a time.
class LocalScatter::Batch {
public:
    void begin(const LocalScatter& light, const LocalRays& rays, const LocalSupport& support, std::span<Rgb> radiance,
               std::span<Rgb> unshadowed) {
        light_ = &light, rays_ = &rays, support_ = &support, radiance_ = radiance, unshadowed_ = unshadowed;
        pieces_.clear();
        cut_ = nullptr, parts_ = nullptr;
        picture_.reset();
        if (const Light* textured = light.light_.textured; textured != nullptr && textured->kind != LightKind::Area)
            picture_.emplace(*light.light_.textured, light.light_.position);
    }
    /// From now on parts are told apart, and nothing is summed.
    void keep_parts(const CutRay& cut, std::vector<LocalPart>& parts) { cut_ = &cut, parts_ = &parts; }
    /// The lit parts of one ray, near to far.
    void add(std::size_t ray, std::span<const LitInterval> lit);
    void flush();

private:
    /// What a piece's light is added to.
    struct Counts {
        bool as_lit, as_unshadowed;
    };
    struct Target {
        Rgb transmittance;
        Counts counts;
    };

    [[nodiscard]] double distance(LocalSupport::Distance which) const { return support_->distance[which][ray_]; }
    void prepare_splits();
    void cut(std::span<const LitInterval> lit, const Counts& counts);
    /// A piece; of a textured light, as many as its texels ask for.
    void append(const LocalRays::Segment& segment, double x0, double x1, const Target& target);
    void append_textured(const LocalRays::Segment& segment, double x0, double x1, const Target& target);
    void append_piece(const LocalRays::Segment& segment, double x0, double x1, const Target& target);

    const LocalScatter* light_ = nullptr;
    const LocalRays* rays_ = nullptr;
    const LocalSupport* support_ = nullptr;
    std::span<Rgb> radiance_, unshadowed_;
    std::size_t ray_ = 0;
    double light_x_ = 0.0;
    LocalSent sent_;
    std::vector<double> splits_; ///< As distances from the light's foot, ascending.
    std::vector<LocalCrossing> crossings_;
    std::optional<PictureAlongRay> picture_; ///< Of a textured light that is no area light.
    const CutRay* cut_ = nullptr;
    std::vector<LocalPart>* parts_ = nullptr; ///< Where parts are told apart.
    LocalPieces pieces_;
    std::array<Target, LocalPieces::capacity> targets_;
};

void LocalScatter::Batch::prepare_splits() {
    splits_.clear(), crossings_.clear();
    for (const auto which : {LocalSupport::Inner0, LocalSupport::Inner1})
        if (light_->shape_.has_soft_edge && distance(LocalSupport::Inner0) < distance(LocalSupport::Inner1))
            splits_.push_back(distance(which));
    if (light_->shape_.sphere_radius_m > 0.0)
        splits_.insert(splits_.end(), {distance(LocalSupport::Body0), distance(LocalSupport::Body1)});
    if (light_->shape_.is_area)
        splits_.insert(splits_.end(), {distance(LocalSupport::Inner0), distance(LocalSupport::Inner1)});
    if (light_->light_.is_dimmed_by_media) {
        ViewRay reached = rays_->ray(ray_);
        reached.near_m = static_cast<float>(light_x_ + distance(LocalSupport::Begin));
        reached.far_m = static_cast<float>(light_x_ + distance(LocalSupport::End));
        if (!light_->boundaries_.is_clear(*rays_, ray_, reached)) {
            light_->boundaries_.append_crossings(reached, crossings_);
            for (const LocalCrossing& crossing : crossings_)
                for (const double at : {crossing.near_m, crossing.far_m})
                    splits_.push_back(at - light_x_);
        }
    }
    if (cut_ != nullptr)
        (*cut_)({.ray = static_cast<std::uint32_t>(ray_),
                 .foot_m = light_x_,
                 .light_m = distance(LocalSupport::LightY),
                 .begin = distance(LocalSupport::Begin),
                 .end = distance(LocalSupport::End)},
                splits_);
    std::ranges::sort(splits_);
    const auto& at_light = light_->sigma_t_at_light_;
    dvec3 light_side_per_m(at_light[0], at_light[1], at_light[2]);
    for (const LocalCrossing& crossing : crossings_)
        light_side_per_m += glm::max(crossing.signed_sigma_t, dvec3(0.0));
    sent_.begin_ray(*rays_, distance(LocalSupport::LightY), support_->term[LocalSupport::SoftenedY][ray_],
                    std::max({light_side_per_m.x, light_side_per_m.y, light_side_per_m.z}),
                    std::max(-distance(LocalSupport::Begin), distance(LocalSupport::End)), rays_->depth_at_end(ray_));
}

void LocalScatter::Batch::add(std::size_t ray, std::span<const LitInterval> lit) {
    ray_ = ray, light_x_ = distance(LocalSupport::LightX);
    if (picture_) {
        const ViewRay& own = rays_->ray(ray);
        picture_->begin_ray(vec3(dvec3(own.origin) + light_x_ * dvec3(own.direction)), own.direction);
    }
    prepare_splits();
    if (unshadowed_.empty()) {
        cut(lit, {.as_lit = true, .as_unshadowed = false});
        return;
    }
    const double begin = light_x_ + distance(LocalSupport::Begin), end = light_x_ + distance(LocalSupport::End);
    const bool is_all_lit =
        lit.size() == 1 && lit[0].near_m <= begin && lit[0].far_m >= end && lit[0].transmittance == Rgb(1.0f);
    const ViewRay& whole = rays_->ray(ray);
    const LitInterval all{.near_m = whole.near_m, .far_m = whole.far_m};
    cut({&all, 1}, {.as_lit = is_all_lit, .as_unshadowed = true});
    if (!is_all_lit)
        cut(lit, {.as_lit = true, .as_unshadowed = false});
}

void LocalScatter::Batch::cut(std::span<const LitInterval> lit, const Counts& counts) {
    const double begin = distance(LocalSupport::Begin), end = distance(LocalSupport::End);
    const double light_y = distance(LocalSupport::LightY);
    auto split = splits_.begin();
    const auto segments = rays_->segments_of(ray_);
    auto segment = segments.begin();
    sent_.forget();
    for (const LitInterval& interval : lit) {
        double from = std::max(begin, interval.near_m - light_x_);
        const double lit_to = std::min(end, interval.far_m - light_x_);
        while (from < lit_to && segment != segments.end()) {
            const double segment_end = segment->far_m - light_x_;
            if (segment_end <= from) {
                ++segment;
                continue;
            }
            from = std::max(from, segment->near_m - light_x_);
            if (sent_.is_lost(rays_->depth_at(*segment, light_x_ + from)))
                return;
            while (split != splits_.end() && *split <= from)
                ++split;
            double to = std::min(lit_to, segment_end);
            if (split != splits_.end())
                to = std::min(to, *split);
            // Weighted means of a piece's ends cancel where it reaches far to both sides of the foot. And where the ray
            // leads far away, all that it loses there lies in the last instant of the angle, which no point would see.
            // So do the turns next to a soft light's sample, whose angle is that of the softened distance.
            if (from < 0.0 && to > 0.0 && std::max(-from, to) > 1.5 * light_y)
                to = 0.0;
            constexpr double far = 6.0, longest = 8.0;
            to = std::min(to, from >= 0.0             ? std::max(far * light_y, longest * from)
                              : -from > far * light_y ? from / longest
                                                      : to);
            if (!(from < to))
                break; // the rest of this lit part lies in air
            append(*segment, from, to, {interval.transmittance, counts});
            from = to;
        }
    }
}

void LocalScatter::Batch::append(const LocalRays::Segment& segment, double x0, double x1, const Target& target) {
    if (light_->light_.textured != nullptr)
        append_textured(segment, x0, x1, target);
    else
        append_piece(segment, x0, x1, target);
}

/// Parts of equal angle under which the light sees the ray: in its picture they are about as long, and what they scatter
/// before any loss is the same.
void LocalScatter::Batch::append_textured(const LocalRays::Segment& segment, double x0, double x1,
                                          const Target& target) {
    const auto y = static_cast<float>(distance(LocalSupport::LightY));
    const auto first = static_cast<float>(x0), last = static_cast<float>(x1);
    const auto turned = [&](float x, float tangent) { return y * (x + y * tangent) / (y - x * tangent); };
    const float angle_rad = std::atan2(y * (last - first), y * y + first * last);
    const LightTexture& texture = *light_->light_.textured->texture;
    const float texels =
        picture_ ? picture_->texels(first, turned(first, std::tan(0.5f * angle_rad)), last, angle_rad) : 0.0f;
    const bool has_distance = changes_with_distance(texture);
    const float fewest = has_distance ? fewest_distance_parts : fewest_texture_parts;
    const float count = std::ceil(std::clamp(2.0f * texels, fewest, most_texture_parts));
    // Gauss's two points: what linear interpolation makes along a part is nearly a square.
    constexpr float gauss = 0.211324865f;
    const float part_rad = angle_rad / count, width = means_wide(texture) * texels / count;
    const float to_near = std::tan(gauss * part_rad), to_far = std::tan((1.0f - gauss) * part_rad),
                to_end = std::tan(part_rad);
    float from = first;
    for (float part = 1.0f; part <= count; ++part) {
        const float to = part < count ? std::clamp(turned(from, to_end), from, last) : last;
        const float near = turned(from, to_near), far = turned(from, to_far);
        const auto colour_at = [&](float x) { return picture_ ? texture.colour(picture_->uv(x), width) : Rgb(1.0f); };
        Rgb at_near = colour_at(near), at_far = colour_at(far);
        if (has_distance) {
            at_near *= distance_share(texture, y * y + near * near);
            at_far *= distance_share(texture, y * y + far * far);
        }
        const Rgb colour = 0.5f * (at_near + at_far);
        if (from < to && colour != Rgb(0.0f))
            append_piece(segment, from == first ? x0 : double{from}, to == last ? x1 : double{to},
                         {target.transmittance * colour, target.counts});
        from = to;
    }
}

void LocalScatter::Batch::append_piece(const LocalRays::Segment& segment, double x0, double x1, const Target& target) {
    if (pieces_.count == LocalPieces::capacity)
        flush();
    const std::size_t at = pieces_.count++;
    const double length_m = x1 - x0;
    pieces_.x0[at] = static_cast<float>(x0), pieces_.x1[at] = static_cast<float>(x1);
    pieces_.length_m[at] = static_cast<float>(length_m);
    const dvec3& sigma_t = rays_->sets()[segment.set].sigma_t;
    const dvec3 depth = rays_->depth_at(segment, light_x_ + x0);
    sent_.add(rays_->sets()[segment.set], x0, length_m, depth, target.transmittance);
    pieces_.log_share[at] = static_cast<float>(sent_.log_share());
    for (int channel = 0; channel < 3; ++channel) {
        pieces_.depth0[static_cast<std::size_t>(channel)][at] = static_cast<float>(depth[channel]);
        pieces_.depth_gain[static_cast<std::size_t>(channel)][at] = static_cast<float>(sigma_t[channel] * length_m);
    }
    if (light_->shape_.has_normal) {
        const double at_foot = distance(LocalSupport::Normal0), per_m = distance(LocalSupport::NormalX);
        const double least_m = -light_->shape_.below_m;
        pieces_.lobe0[at] = static_cast<float>(std::max(least_m, at_foot + per_m * x0));
        pieces_.lobe1[at] = static_cast<float>(std::max(least_m, at_foot + per_m * x1));
    }
    const auto is_grey = [](const auto& value) { return value[0] == value[1] && value[0] == value[2]; };
    bool all_grey = is_grey(depth) && is_grey(sigma_t) && is_grey(light_->sigma_t_at_light_);
    pieces_.first_crossing[at] = static_cast<std::uint32_t>(pieces_.crossings.size());
    const double middle_m = light_x_ + 0.5 * (x0 + x1);
    for (const LocalCrossing& crossing : crossings_) {
        if (!(crossing.near_m < middle_m && middle_m < crossing.far_m))
            continue;
        const auto at_both_ends = [&](const dvec2& line) {
            return dvec2(line.x + line.y * (light_x_ + x0), line.x + line.y * (light_x_ + x1));
        };
        const dvec2 n = at_both_ends(crossing.n), way = at_both_ends(crossing.d);
        const double sign = way.x + way.y < 0.0 ? -1.0 : 1.0;
        PieceCrossing& made = pieces_.crossings.emplace_back();
        made.n = {static_cast<float>(sign * n.x), static_cast<float>(sign * n.y)};
        made.d = {static_cast<float>(sign * way.x), static_cast<float>(sign * way.y)};
        for (int channel = 0; channel < 3; ++channel)
            made.signed_sigma_t[static_cast<std::size_t>(channel)] =
                static_cast<float>(crossing.signed_sigma_t[channel]);
        all_grey = all_grey && is_grey(crossing.signed_sigma_t);
    }
    pieces_.crossing_count[at] = static_cast<std::uint32_t>(pieces_.crossings.size()) - pieces_.first_crossing[at];
    pieces_.is_grey[at] = all_grey ? 1 : 0;
    pieces_.ray[at] = static_cast<std::int32_t>(ray_);
    pieces_.set[at] = static_cast<std::int32_t>(segment.set);
    targets_[at] = target;
}

void LocalScatter::Batch::flush() {
    integrate(light_->shape_, light_->sigma_t_at_light_, *support_, rays_->sets(), pieces_);
    for (std::size_t at = 0; at < pieces_.count; ++at) {
        const auto ray = static_cast<std::size_t>(pieces_.ray[at]);
        const Target& target = targets_[at];
        const Rgb sum = light_->light_.strength * target.transmittance *
                        Rgb(pieces_.sum[0][at], pieces_.sum[1][at], pieces_.sum[2][at]);
        if (parts_ != nullptr)
            parts_->push_back({static_cast<std::uint32_t>(ray), pieces_.x0[at], pieces_.x1[at], sum});
        else if (target.counts.as_lit)
            radiance_[ray] += sum;
        if (target.counts.as_unshadowed)
            unshadowed_[ray] += sum;
    }
    pieces_.clear();
}

void LocalScatter::find_reached(const LocalRays& rays, const Visibility* visibility, Reached& reached) const {
    auto& [support, indices, asked, lit] = reached;
    find_support(shape_, rays, support);
    indices.clear(), asked.clear(), lit.clear();
    for (std::uint32_t ray = 0; ray < rays.size(); ++ray) {
        const double begin = support.distance[LocalSupport::Begin][ray], end = support.distance[LocalSupport::End][ray];
        if (!(begin < end))
            continue;
        indices.push_back(ray);
        ViewRay& part = asked.emplace_back(rays.ray(ray));
        // Rounded outwards: the exact ends are in `support`.
        const double light_x = support.distance[LocalSupport::LightX][ray];
        const auto outwards = [](double at, double sign) {
            return static_cast<float>(at + sign * 1e-7 * std::abs(at));
        };
        part.near_m = std::max(part.near_m, outwards(light_x + begin, -1.0));
        part.far_m = std::min(part.far_m, outwards(light_x + end, 1.0));
    }
    if (visibility != nullptr)
        visibility->lit_intervals(asked, lit);
    else
        for (const ViewRay& ray : asked) {
            lit.intervals.push_back({.near_m = ray.near_m, .far_m = ray.far_m});
            lit.end_ray();
        }
}

void LocalScatter::add_scattered(const LocalRays& rays, const Visibility* visibility, std::span<Rgb> radiance,
                                 std::span<Rgb> unshadowed, std::span<float> lit_length_m) const {
    struct Workspace {
        Reached reached;
        Batch batch;
    };
    thread_local Workspace workspace;
    auto& [reached, batch] = workspace;
    find_reached(rays, visibility, reached);
    batch.begin(*this, rays, reached.support, radiance, unshadowed);
    for (std::size_t row = 0; row < reached.rays.size(); ++row)
        if (const auto own = reached.lit.of_ray(row); !own.empty() || !unshadowed.empty())
            batch.add(reached.rays[row], own);
    batch.flush();
    if (!lit_length_m.empty())
        add_lit_lengths(rays, reached, lit_length_m);
}

void LocalScatter::append_parts(const LocalRays& rays, const Visibility* visibility, const CutRay& cut,
                                std::vector<LocalPart>& parts) const {
    struct Workspace {
        Reached reached;
        Batch batch;
    };
    thread_local Workspace workspace;
    auto& [reached, batch] = workspace;
    find_reached(rays, visibility, reached);
    batch.begin(*this, rays, reached.support, {}, {});
    batch.keep_parts(cut, parts);
    for (std::size_t row = 0; row < reached.rays.size(); ++row)
        if (const auto own = reached.lit.of_ray(row); !own.empty())
            batch.add(reached.rays[row], own);
    batch.flush();
}
} // namespace tyndall::light_shafts
