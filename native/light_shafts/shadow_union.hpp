// SPDX-License-Identifier: GPL-3.0-or-later
// The part of one view ray that opaque triangles shadow, as disjoint intervals that grow while triangles are cut.
#pragma once
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

namespace tyndall::light_shafts {
struct ShadowInterval {
    float near_m, far_m;
};

/// Union of intervals within [near_m, far_m], exact: ends are inserted ends, whatever the order of insertion.
class ShadowUnion {
public:
    void reset(float near_m, float far_m) {
        intervals_.clear();
        open_near_m_ = near_m, open_far_m_ = far_m;
        longest_ = {near_m, near_m};
    }
    /// What is not yet shadowed lies within [open_near_m, open_far_m]; nothing is left where they meet.
    [[nodiscard]] float open_near_m() const { return open_near_m_; }
    [[nodiscard]] float open_far_m() const { return open_far_m_; }
    [[nodiscard]] bool is_complete() const { return !(open_near_m_ < open_far_m_); }
    /// The longest interval between the open ends.
    [[nodiscard]] const ShadowInterval& longest() const { return longest_; }
    /// Disjoint and ascending, within the open ends.
    [[nodiscard]] const std::vector<ShadowInterval>& intervals() const { return intervals_; }

    /// All of [near_m, far_m] is shadowed, or lies outside the ray.
    [[nodiscard]] bool covers(float near_m, float far_m) const {
        near_m = std::max(near_m, open_near_m_);
        far_m = std::min(far_m, open_far_m_);
        if (!(near_m < far_m))
            return true;
        const auto after = std::ranges::upper_bound(intervals_, near_m, {}, &ShadowInterval::near_m);
        return after != intervals_.begin() && std::prev(after)->far_m >= far_m;
    }

    void insert(float near_m, float far_m) {
        if (!(far_m > open_near_m_ && near_m < open_far_m_ && near_m < far_m))
            return;
        if (near_m <= open_near_m_) {
            open_near_m_ = far_m;
            while (!intervals_.empty() && intervals_.front().near_m <= open_near_m_) {
                open_near_m_ = std::max(open_near_m_, intervals_.front().far_m);
                intervals_.erase(intervals_.begin());
            }
            if (far_m < open_far_m_)
                return;
        }
        if (far_m >= open_far_m_) {
            open_far_m_ = std::min(open_far_m_, near_m);
            while (!intervals_.empty() && intervals_.back().far_m >= open_far_m_) {
                open_far_m_ = std::min(open_far_m_, intervals_.back().near_m);
                intervals_.pop_back();
            }
            return;
        }
        std::size_t first = intervals_.size();
        while (first > 0 && intervals_[first - 1].far_m >= near_m)
            --first;
        std::size_t last = first;
        ShadowInterval merged{near_m, far_m};
        for (; last < intervals_.size() && intervals_[last].near_m <= far_m; ++last) {
            merged.near_m = std::min(merged.near_m, intervals_[last].near_m);
            merged.far_m = std::max(merged.far_m, intervals_[last].far_m);
        }
        const auto place = intervals_.begin() + static_cast<std::ptrdiff_t>(first);
        if (first == last) {
            intervals_.insert(place, merged);
        } else {
            *place = merged;
            intervals_.erase(place + 1, intervals_.begin() + static_cast<std::ptrdiff_t>(last));
        }
        if (merged.far_m - merged.near_m > longest_.far_m - longest_.near_m)
            longest_ = merged;
    }

private:
    std::vector<ShadowInterval> intervals_;
    float open_near_m_ = 0.0f, open_far_m_ = 0.0f;
    ShadowInterval longest_{0.0f, 0.0f};
};
} // namespace tyndall::light_shafts
