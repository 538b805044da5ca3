// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/shared_strata.hpp"
#include "core/parallel.hpp"
#include "light_shafts/shared_strata_kernel.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
namespace shared_strata {
namespace {
/// Two pixels see much the same air: it begins and ends within a tenth of its distance.
bool is_alike(const Air& a, const Air& b) {
    const auto near_each_other = [&](float at_a, float at_b) {
        return at_a == at_b || std::abs(at_a - at_b) <= alike_tolerance * std::min(at_a, at_b);
    };
    return b.opacity > 0.0f && near_each_other(a.far_m, b.far_m) && near_each_other(a.near_m, b.near_m);
}

/// Sums over the neighbours of one square size.
class Neighbours {
public:
    Neighbours(const PictureRays& picture, std::uint32_t side, const ConstScattered& shared, const Scattered& sum)
        : picture_(picture), shared_(shared), sum_(sum), width_(static_cast<std::int32_t>(picture.width_px)),
          height_(static_cast<std::int32_t>(picture.height_px)), reach_(static_cast<std::int32_t>(side / 2)),
          has_visibility_(!shared.average_visibility.empty()), has_patterned_(!shared.patterned.empty()) {}

    /// Lines [first, end): by vectors where pixels have a ray or none, and one by one next to those that have several.
    void add_lines(std::int32_t first, std::int32_t end) {
        const std::int32_t lowest = std::max(first - reach_, 0), past = std::min(end + reach_, height_);
        stride_ = static_cast<std::size_t>(width_) + 2 * line_padding;
        const std::size_t columns = has_patterned_ ? column_count : patterned;
        lines_.assign(static_cast<std::size_t>(past - lowest) * columns * stride_, 0.0f);
        has_several_.assign(static_cast<std::size_t>((past - lowest) * width_), 0);
        const auto line = [&](std::int32_t y) {
            return lines_.data() + static_cast<std::size_t>(y - lowest) * columns * stride_ + line_padding;
        };
        for (std::int32_t y = lowest; y < past; ++y)
            has_any_several_ |= gather(y, line(y), &has_several_[static_cast<std::size_t>((y - lowest) * width_)]);
        light_.resize(4 * stride_);
        float *const visibility = light_.data() + 3 * stride_, *const light = light_.data();
        for (std::int32_t y = first; y < end; ++y) {
            LinesAround around{.lines = {},
                               .stride = stride_,
                               .reach = reach_,
                               .width = static_cast<std::size_t>(width_),
                               .has_visibility = has_visibility_,
                               .has_patterned = has_patterned_};
            for (std::int32_t dy = std::max(-reach_, -y); dy <= std::min(reach_, height_ - 1 - y); ++dy)
                around.lines[static_cast<std::size_t>(dy + reach_)] = line(y + dy);
            add_line(around, light, visibility);
            for (std::int32_t x = 0; x < width_; ++x) {
                const std::uint32_t ray = picture_.first_ray[pixel(x, y)];
                if (has_any_several_ && is_next_to_several(x, y, lowest, past)) {
                    for (std::uint32_t each = ray; each < picture_.first_ray[pixel(x, y) + 1]; ++each)
                        add_ray(x, y, each);
                } else if (ray < picture_.first_ray[pixel(x, y) + 1]) {
                    const auto at = static_cast<std::size_t>(x);
                    sum_.radiance[ray] += Rgb(light[at], light[stride_ + at], light[2 * stride_ + at]);
                    if (has_visibility_)
                        sum_.average_visibility[ray] += visibility[at];
                }
            }
        }
    }

private:
    [[nodiscard]] std::size_t pixel(std::int32_t x, std::int32_t y) const {
        return static_cast<std::size_t>(y) * picture_.width_px + static_cast<std::size_t>(x);
    }
    /// A line's pixels as columns, those without one ray as if they had no air. Returns whether any has several.
    bool gather(std::int32_t y, float* line, std::uint8_t* has_several) const {
        bool has_any = false;
        const auto set = [&](std::size_t column, std::size_t x, const Rgb& value) {
            for (int channel = 0; channel < 3; ++channel)
                line[(column + static_cast<std::size_t>(channel)) * stride_ + x] = value[channel];
        };
        for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
            const std::size_t at = pixel(static_cast<std::int32_t>(x), y);
            const std::uint32_t ray = picture_.first_ray[at], count = picture_.first_ray[at + 1] - ray;
            has_any |= count > 1;
            has_several[x] = count > 1;
            if (count != 1 || picture_.cells[ray] == alone_cell)
                continue;
            const Air& air = picture_.air[ray];
            line[near_m * stride_ + x] = air.near_m;
            line[far_m * stride_ + x] = air.far_m;
            line[opacity * stride_ + x] = air.opacity;
            set(radiance, x, shared_.radiance[ray]);
            if (has_visibility_)
                line[visibility * stride_ + x] = shared_.average_visibility[ray];
            if (has_patterned_) {
                set(patterned, x, shared_.patterned[ray]);
                set(unshadowed, x, shared_.patterned_unshadowed[ray]);
            }
        }
        return has_any;
    }
    [[nodiscard]] bool is_next_to_several(std::int32_t x, std::int32_t y, std::int32_t lowest,
                                          std::int32_t past) const {
        for (std::int32_t other = std::max(y - reach_, lowest); other <= std::min(y + reach_, past - 1); ++other) {
            const auto line = has_several_.begin() + (other - lowest) * width_;
            if (std::any_of(line + std::max(x - reach_, 0), line + std::min(x + reach_ + 1, width_),
                            [](std::uint8_t has) { return has != 0; }))
                return true;
        }
        return false;
    }
    /// As add_line, of one ray; of a neighbour's rays the first that is like it counts.
    void add_ray(std::int32_t x, std::int32_t y, std::uint32_t ray) const {
        const Air& air = picture_.air[ray];
        if (picture_.cells[ray] == alone_cell || !(air.opacity > 0.0f))
            return;
        Rgb light(0.0f), of_pattern(0.0f), of_whole(0.0f), kept(0.0f);
        float visibility_sum = 0.0f, weight_sum = 0.0f, weight_here = 0.0f, opacity_sum = 0.0f;
        for (std::int32_t dy = std::max(-reach_, -y); dy <= std::min(reach_, height_ - 1 - y); ++dy)
            for (std::int32_t dx = std::max(-reach_, -x); dx <= std::min(reach_, width_ - 1 - x); ++dx) {
                const std::size_t beside = pixel(x + dx, y + dy);
                std::uint32_t other = picture_.first_ray[beside];
                const std::uint32_t end = picture_.first_ray[beside + 1];
                while (other < end && (picture_.cells[other] == alone_cell || !is_alike(air, picture_.air[other])))
                    ++other;
                if (other == end)
                    continue;
                const float weight = share_at(dx, reach_) * share_at(dy, reach_);
                light += weight * shared_.radiance[other];
                if (has_patterned_) {
                    const float here = share_here(dx, reach_) * share_here(dy, reach_);
                    of_pattern += weight * shared_.patterned[other];
                    of_whole += weight * shared_.patterned_unshadowed[other];
                    kept += here * shared_.patterned_unshadowed[other];
                    weight_here += here;
                }
                if (has_visibility_)
                    visibility_sum += weight * shared_.average_visibility[other];
                weight_sum += weight;
                opacity_sum += weight * picture_.air[other].opacity;
            }
        // Neither sum is 0: the ray itself is like itself.
        sum_.radiance[ray] += light * (air.opacity / opacity_sum);
        for (int channel = 0; has_patterned_ && channel < 3; ++channel)
            if (of_whole[channel] > 0.0f)
                sum_.radiance[ray][channel] += of_pattern[channel] / of_whole[channel] * kept[channel] / weight_here;
        if (has_visibility_)
            sum_.average_visibility[ray] += visibility_sum / weight_sum;
    }

    const PictureRays& picture_;
    const ConstScattered& shared_;
    const Scattered& sum_;
    std::int32_t width_, height_, reach_;
    bool has_visibility_, has_patterned_, has_any_several_ = false;
    std::size_t stride_ = 0;
    std::vector<float> lines_, light_;
    std::vector<std::uint8_t> has_several_; ///< Rays, of each pixel of lines_.
};
} // namespace
} // namespace shared_strata

void add_shared(const PictureRays& picture, std::uint32_t side, std::uint32_t first_row, std::uint32_t end_row,
                const ConstScattered& shared, const Scattered& sum, const Progress& progress) {
    constexpr std::size_t rows_per_block = 8; // half as many again are gathered
    parallel_blocks(end_row - first_row, rows_per_block, progress, [&](std::size_t begin, std::size_t end) {
        shared_strata::Neighbours(picture, side, shared, sum)
            .add_lines(static_cast<std::int32_t>(first_row + begin), static_cast<std::int32_t>(first_row + end));
    });
}
} // namespace tyndall::light_shafts
