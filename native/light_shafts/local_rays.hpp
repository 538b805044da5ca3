// SPDX-License-Identifier: GPL-3.0-or-later
// The view rays of a block as every local light reads them: in columns, with what their media have in common.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/media.hpp"
#include <array>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// Henyey and Greenstein's lobe [1941], (1 - g^2) sigma_s / (4 pi) over ((1 - |g|)^2 + 2 |g| (1 -+ cosine))^1.5: a sum of
/// terms that are not negative, however sharp the peak. Draine's, which is this times 1 + alpha cosine^2 [2003, eq. 5], has
/// its norm in the weight.
struct PhaseLobe {
    std::array<float, 3> weight;
    float least, two_g; ///< (1 - |g|)^2 and 2 |g|.
    float draine_alpha;
    bool is_forward;
};
/// What a set of media does to light.
struct SetOfMedia {
    MediumSet set;
    dvec3 sigma_t{0.0};
    std::vector<PhaseLobe> lobes;
    double least_scatter = 0.0, most_scatter = 0.0; ///< By the direction, of the strongest channel, per m and sr.
};

/// Is the point in the boundary's box, or outside by no more than this share of it?
[[nodiscard]] bool holds(const MediumBoundary& boundary, const vec3& point, float slack = 0.0f);
/// A ray that ends on a face of a box may end outside of it by a rounding.
constexpr float rounding_of_ends = 1e-5f;

/// Computed once for all lights. The rays and their media must outlive it.
class LocalRays {
public:
    /// Ray r has segments[first_segment[r] .. first_segment[r + 1]), of Media::segments, made finite.
    void assign(const Media& media, std::span<const ViewRay> rays, std::span<const std::uint32_t> first_segment,
                std::span<const MediumSegment> segments);
    void clear() { rays_ = {}; }
    [[nodiscard]] bool is_empty() const { return rays_.empty(); }

    [[nodiscard]] std::size_t size() const { return rays_.size(); }
    [[nodiscard]] const ViewRay& ray(std::size_t index) const { return rays_[index]; }
    [[nodiscard]] std::span<const ViewRay> rays() const { return rays_; }
    struct Segment {
        float near_m, far_m;
        std::uint32_t set; ///< Into sets().
        dvec3 depth_at_near;
    };
    [[nodiscard]] std::span<const Segment> segments_of(std::size_t ray) const {
        return std::span(segments_).subspan(first_segment_[ray], first_segment_[ray + 1] - first_segment_[ray]);
    }
    /// Between the camera and a point of the segment, by its distance.
    [[nodiscard]] dvec3 depth_at(const Segment& segment, double at_m) const {
        return segment.depth_at_near + sets_[segment.set].sigma_t * (at_m - segment.near_m);
    }
    /// Of all that the ray has in media; it has some.
    [[nodiscard]] dvec3 depth_at_end(std::size_t ray) const {
        const Segment& last = segments_of(ray).back();
        return depth_at(last, last.far_m);
    }
    /// All media are boxes, and what the ray has in media lies in every one of them.
    [[nodiscard]] bool is_in_all_boxes(std::size_t ray) const { return is_in_all_boxes_[ray] != 0; }
    [[nodiscard]] std::span<const SetOfMedia> sets() const { return sets_; }
    /// The logarithm of the sets' largest most_scatter.
    [[nodiscard]] double log_most_scatter() const { return log_most_scatter_; }

    /// Columns, each padded to a multiple of `padding` rays: origin, direction, and the ends of what lies in media; a
    /// ray without media ends before it begins.
    static constexpr std::size_t padding = 8;
    enum Column : std::uint8_t {
        OriginX,
        OriginY,
        OriginZ,
        DirectionX,
        DirectionY,
        DirectionZ,
        Near,
        Far,
        ColumnCount
    };
    [[nodiscard]] const double* column(int which) const { return columns_[static_cast<std::size_t>(which)].data(); }

private:
    [[nodiscard]] std::uint32_t index_of(const Media& media, const MediumSet& set);

    std::span<const ViewRay> rays_;
    std::span<const std::uint32_t> first_segment_;
    std::vector<Segment> segments_;
    std::vector<SetOfMedia> sets_;
    double log_most_scatter_ = 0.0;
    std::vector<std::uint8_t> is_in_all_boxes_;
    std::array<std::vector<double>, ColumnCount> columns_;
};
} // namespace tyndall::light_shafts
