// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_scatter_kernel.hpp"
#include <algorithm>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/local_scatter_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/exp-inl.hpp"
#include "light_shafts/local_light_shape-inl.hpp"
#include "light_shafts/slope_rows_angle-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Gauss-Legendre on [0, 1], weights of sum 1, and the weights of the Legendre coefficients 4 and 5 relative to the mean.
struct Rule {
    static constexpr std::size_t count = 6;
    float at[count], weight[count], fourth[count], fifth[count];
};
constexpr Rule make_rule() {
    constexpr double at[3] = {0.932469514203152028, 0.661209386466264514, 0.238619186083196909};
    constexpr double weight[3] = {0.171324492379170345, 0.360761573048138608, 0.467913934572691047};
    Rule rule{};
    for (std::size_t i = 0; i < Rule::count; ++i) {
        const double x = i < 3 ? -at[i] : at[5 - i], w = 0.5 * weight[i < 3 ? i : 5 - i], x2 = x * x;
        rule.at[i] = static_cast<float>(0.5 + 0.5 * x);
        rule.weight[i] = static_cast<float>(w);
        rule.fourth[i] = static_cast<float>(w * 9.0 * (35.0 * x2 * x2 - 30.0 * x2 + 3.0) / 8.0);
        rule.fifth[i] = static_cast<float>(w * 11.0 * x * (63.0 * x2 * x2 - 70.0 * x2 + 15.0) / 8.0);
    }
    return rule;
}
static constexpr Rule rule = make_rule();

/// sin(a) / a for a^2 in [0, 2.5], 1e-7.
static HWY_INLINE V sinc(V a2) {
    V p = hn::MulAdd(a2, set(-1.0f / 39916800), set(1.0f / 362880));
    p = hn::MulAdd(p, a2, set(-1.0f / 5040));
    p = hn::MulAdd(p, a2, set(1.0f / 120));
    p = hn::MulAdd(p, a2, set(-1.0f / 6));
    return hn::MulAdd(p, a2, set(1.0f));
}

/// A part of a piece: each end as shares of the piece's begin and end, which keep their relative precision.
struct Part {
    std::uint32_t piece;
    std::uint32_t depth; ///< Number of halvings.
    std::array<float, 2> begin{1.0f, 0.0f}, end{0.0f, 1.0f};
};
constexpr std::uint32_t most_halvings = 24;
/// What a vector of pieces needs at all its points.
struct Lanes : LightLanes {
    V x0, x1, depth0[3], depth_gain[3];
};
/// A crossing of each piece: n and d at both ends, signed extinction. Not vectors: std::vector is compiled for any CPU.
struct LaneCrossing {
    alignas(64) float n[2][lanes], d[2][lanes], signed_sigma_t[3][lanes];
};

struct Kernel {
    const LocalShape& shape;
    const std::array<float, 3>& sigma_t_at_light;
    const LocalSupport& support;
    std::span<const SetOfMedia> sets;
    LocalPieces& pieces;
    std::vector<Part>& parts;
    std::vector<LaneCrossing>& crossings;

    /// sigma_s times the phase function, where the light has come the way -x with this inverse distance.
    static HWY_INLINE void add_lobes(const SetOfMedia& media, V towards, V away, V cosine2, V (&scatter)[3]) {
        for (const PhaseLobe& lobe : media.lobes) {
            const V base = hn::MulAdd(set(lobe.two_g), lobe.is_forward ? towards : away, set(lobe.least));
            const V root = reciprocal_root_of(d, base);
            V phase = hn::Mul(root, hn::Mul(root, root));
            if (lobe.draine_alpha != 0.0f)
                phase = hn::Mul(phase, hn::MulAdd(set(lobe.draine_alpha), cosine2, set(1.0f)));
            for (std::size_t channel = 0; channel < 3; ++channel)
                scatter[channel] = hn::MulAdd(phase, set(lobe.weight[channel]), scatter[channel]);
        }
    }

    /// Extinction of the way to the light, per metre of it.
    HWY_INLINE void light_side(V before, V after, V (&sigma_t)[3]) const {
        for (std::size_t channel = 0; channel < 3; ++channel)
            sigma_t[channel] = set(sigma_t_at_light[channel]);
        if (crossings.empty())
            return;
        for (const LaneCrossing& crossing : crossings) {
            const auto mean = [&](const float(&ends)[2][lanes]) {
                return hn::MulAdd(before, hn::Load(d, ends[0]), hn::Mul(after, hn::Load(d, ends[1])));
            };
            const V n = mean(crossing.n), way = mean(crossing.d);
            const V share = hn::Min(hn::Max(hn::Div(n, hn::Max(way, set(1e-30f))), hn::Zero(d)), set(1.0f));
            for (std::size_t channel = 0; channel < 3; ++channel)
                sigma_t[channel] = hn::MulAdd(share, hn::Load(d, crossing.signed_sigma_t[channel]), sigma_t[channel]);
        }
        for (V& channel : sigma_t)
            channel = hn::Max(channel, hn::Zero(d));
    }

    void gather_crossings(const std::uint32_t* piece) {
        crossings.clear();
        if (pieces.crossings.empty())
            return;
        std::uint32_t most = 0;
        for (std::size_t lane = 0; lane < lanes; ++lane)
            most = std::max(most, pieces.crossing_count[piece[lane]]);
        for (std::uint32_t index = 0; index < most; ++index) {
            LaneCrossing& lane_crossing = crossings.emplace_back();
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                constexpr PieceCrossing none{{0.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 0.0f, 0.0f}};
                const std::uint32_t at = piece[lane];
                const PieceCrossing& c =
                    index < pieces.crossing_count[at] ? pieces.crossings[pieces.first_crossing[at] + index] : none;
                for (std::size_t end = 0; end < 2; ++end)
                    lane_crossing.n[end][lane] = c.n[end], lane_crossing.d[end][lane] = c.d[end];
                for (std::size_t channel = 0; channel < 3; ++channel)
                    lane_crossing.signed_sigma_t[channel][lane] = c.signed_sigma_t[channel];
            }
        }
    }

    /// Parts [first, first + lanes) of the list; `used` of them count. Those too rough are halved and appended.
    template <bool is_whole>
    void evaluate(std::size_t first, std::size_t used) {
        alignas(64) std::uint32_t piece[lanes];
        alignas(64) float begin_before[lanes], begin_after[lanes], end_before[lanes], end_after[lanes];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t at = first + std::min(lane, used - 1);
            if constexpr (is_whole) {
                piece[lane] = static_cast<std::uint32_t>(at);
            } else {
                const Part& part = parts[at];
                piece[lane] = part.piece;
                begin_before[lane] = part.begin[0], begin_after[lane] = part.begin[1];
                end_before[lane] = part.end[0], end_after[lane] = part.end[1];
            }
        }
        const auto index = hn::BitCast(di, hn::Load(hn::RebindToUnsigned<Tag>(), piece));
        const auto of_piece = [&](const auto& column) {
            const hn::Rebind<std::remove_cvref_t<decltype(column[0])>, Tag> any;
            if constexpr (is_whole)
                return hn::Load(any, column.data() + first);
            else
                return hn::GatherIndex(any, column.data(), index);
        };
        const auto ray = of_piece(pieces.ray);
        const auto of_ray = [&](LocalSupport::Term which) {
            return hn::GatherIndex(d, support.term[which].data(), ray);
        };
        gather_crossings(piece);
        Lanes s;
        s.x0 = of_piece(pieces.x0), s.x1 = of_piece(pieces.x1);
        const V softened_y = of_ray(LocalSupport::SoftenedY);
        s.light_y2 = of_ray(LocalSupport::LightY2), s.softened_y2 = hn::Mul(softened_y, softened_y);
        const bool is_grey = hn::AllTrue(di, hn::Ne(of_piece(pieces.is_grey), hn::Zero(di)));
        for (std::size_t channel = 0; channel < (is_grey ? 1u : 3u); ++channel) {
            s.depth0[channel] = of_piece(pieces.depth0[channel]);
            s.depth_gain[channel] = of_piece(pieces.depth_gain[channel]);
        }
        if (shape.has_normal)
            s.lobe0 = of_piece(pieces.lobe0), s.lobe1 = of_piece(pieces.lobe1),
            s.normal_d = of_ray(LocalSupport::NormalD);
        if (shape.is_soft)
            s.offset0 = of_ray(LocalSupport::Offset0), s.offset_x = of_ray(LocalSupport::OffsetX);
        if (shape.has_cone) {
            s.cone[0] = of_ray(LocalSupport::ConeX), s.cone_d[0] = of_ray(LocalSupport::ConeDx);
            s.cone[1] = of_ray(LocalSupport::ConeY), s.cone_d[1] = of_ray(LocalSupport::ConeDy);
            s.cone[2] = of_ray(LocalSupport::ConeZ), s.cone_d[2] = of_ray(LocalSupport::ConeDz);
        }
        // Ends of the parts.
        V before0 = set(1.0f), after0 = hn::Zero(d), before1 = hn::Zero(d), after1 = set(1.0f);
        V x0 = s.x0, x1 = s.x1, length = of_piece(pieces.length_m);
        if constexpr (!is_whole) {
            before0 = hn::Load(d, begin_before), after0 = hn::Load(d, begin_after);
            before1 = hn::Load(d, end_before), after1 = hn::Load(d, end_after);
            x0 = hn::MulAdd(before0, s.x0, hn::Mul(after0, s.x1));
            x1 = hn::MulAdd(before1, s.x0, hn::Mul(after1, s.x1));
            // By the smaller shares, which know the part's length next to either end of the piece.
            length = hn::Mul(
                length, hn::IfThenElse(hn::Lt(after1, set(0.5f)), hn::Sub(after1, after0), hn::Sub(before0, before1)));
        }
        const V r0 = hn::Sqrt(hn::MulAdd(x0, x0, s.softened_y2)), r1 = hn::Sqrt(hn::MulAdd(x1, x1, s.softened_y2));
        const V angle = atan2_of(d, hn::Mul(softened_y, length), hn::MulAdd(x0, x1, s.softened_y2));
        const V angle2 = hn::Mul(angle, angle);
        V sine[Rule::count]; // over the angle
        for (std::size_t i = 0; i < Rule::count; ++i)
            sine[i] = hn::Mul(set(rule.at[i]), sinc(hn::Mul(angle2, set(rule.at[i] * rule.at[i]))));
        alignas(64) std::int32_t set_of[lanes];
        const auto set_index = of_piece(pieces.set);
        hn::Store(set_index, di, set_of);
        const bool is_one_set = hn::AllTrue(di, hn::Eq(set_index, hn::Set(di, set_of[0])));

        V mean[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)}, fourth[3] = {mean[0], mean[0], mean[0]},
          fifth[3] = {mean[0], mean[0], mean[0]};
        V mean_share = hn::Zero(d);
        V least[3] = {set(1e30f), set(1e30f), set(1e30f)}, most[3] = {mean[0], mean[0], mean[0]}; // depths
        const auto depth_at = [&](std::size_t channel, V after, V distance, const V(&sigma_t)[3]) {
            const V depth =
                hn::MulAdd(after, s.depth_gain[channel], hn::MulAdd(sigma_t[channel], distance, s.depth0[channel]));
            least[channel] = hn::Min(least[channel], depth), most[channel] = hn::Max(most[channel], depth);
            return depth;
        };
        const auto note_end = [&](V before, V after, V x) {
            V sigma_t[3];
            light_side(before, after, sigma_t);
            const V distance = hn::Sqrt(hn::MulAdd(x, x, s.light_y2));
            for (std::size_t channel = 0; channel < (is_grey ? 1u : 3u); ++channel)
                depth_at(channel, after, distance, sigma_t);
        };
        note_end(before0, after0, x0);
        note_end(before1, after1, x1);
        for (std::size_t i = 0; i < Rule::count; ++i) {
            const V weight0 = hn::Mul(sine[Rule::count - 1 - i], r1), weight1 = hn::Mul(sine[i], r0);
            const V inverse = reciprocal_of(d, hn::Add(weight0, weight1));
            V before = hn::Mul(weight0, inverse), after = hn::Mul(weight1, inverse);
            if constexpr (!is_whole) {
                const V own_before = before, own_after = after;
                before = hn::MulAdd(own_before, before0, hn::Mul(own_after, before1));
                after = hn::MulAdd(own_before, after0, hn::Mul(own_after, after1));
            }
            const V x = hn::MulAdd(before, s.x0, hn::Mul(after, s.x1)), x2 = hn::Mul(x, x);
            const V distance2 = hn::Add(x2, s.light_y2), inverse_distance = reciprocal_root_of(d, distance2);
            const V inverse2 = hn::Mul(inverse_distance, inverse_distance);
            LightView view{
                {}, hn::Mul(x, inverse_distance), hn::Mul(s.light_y2, inverse2), hn::Mul(distance2, inverse_distance)};
            const LightShape light{shape};
            const V normal_m = shape.has_normal ? hn::MulAdd(before, s.lobe0, hn::Mul(after, s.lobe1)) : hn::Zero(d);
            if (shape.is_patch())
                view = light.patch_at(s, x, distance2, normal_m);
            else
                view.share = light.shape_at(s, x, x2, inverse_distance, normal_m);
            if (shape.has_cone && !shape.is_area)
                view.share = light.cone_at(s, x, view.share);
            const auto& [share, cosine, sine2, distance] = view;
            // 1 - |cos| of the angle by which the light turns, as sin^2 / (1 + |cos|).
            const V less = hn::Mul(sine2, reciprocal_of(d, hn::Add(set(1.0f), hn::Abs(cosine))));
            const V more = hn::Sub(set(2.0f), less);
            const auto turns_back = hn::Gt(cosine, hn::Zero(d)); // the ray has passed the light, and looks back at it
            const V towards = hn::IfThenElse(turns_back, more, less), away = hn::IfThenElse(turns_back, less, more);
            const V cosine2 = hn::Sub(set(1.0f), sine2);
            V scatter[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
            if (is_one_set)
                add_lobes(sets[static_cast<std::size_t>(set_of[0])], towards, away, cosine2, scatter);
            else
                scatter_of_sets(set_of, set_index, towards, away, cosine2, scatter);
            mean_share = hn::MulAdd(set(rule.weight[i]), share, mean_share);
            V sigma_t[3], transmittance{};
            light_side(before, after, sigma_t);
            for (std::size_t channel = 0; channel < 3; ++channel) {
                if (channel == 0 || !is_grey) {
                    const V depth = depth_at(channel, after, distance, sigma_t);
                    transmittance = exp_of(d, hn::Neg(depth));
                }
                const V value = hn::Mul(hn::Mul(share, scatter[channel]), transmittance);
                mean[channel] = hn::MulAdd(set(rule.weight[i]), value, mean[channel]);
                fourth[channel] = hn::MulAdd(set(rule.fourth[i]), value, fourth[channel]);
                fifth[channel] = hn::MulAdd(set(rule.fifth[i]), value, fifth[channel]);
            }
        }
        // Coefficients of an analytic function fall like rho^-k, and the rule's error like rho^-12. The points may all miss
        // what is left of a steep exponential, unless that is nothing beside what is nearer, or at all, behind 80 optical
        // depths. At the rim of a cone the share rises from 0 as a square of what floats know to 1e-7, and halving would not
        // end. Where a patch's lobe ends the share has a bend, next to which there is hardly any light.
        const V log_share = of_piece(pieces.log_share), angle_per_m = hn::Div(angle, softened_y);
        const V least_share = hn::Max(mean_share, set(1e-12f));
        const V noise =
            hn::MulAdd(set(1e-5 * shape.one_minus_cos_half * shape.per_smooth), reciprocal_root_of(d, least_share),
                       hn::Div(set(shape.is_patch() ? 1e-2f : 0.0f), least_share));
        auto is_rough = hn::Gt(hn::Zero(d), hn::Zero(d));
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const std::size_t depths = is_grey ? 0 : channel;
            const V loss = hn::Sub(most[depths], least[depths]);
            const auto is_steep = hn::Gt(loss, set(20.0f));
            const auto may_bend = hn::Or(hn::Gt(angle, set(1e-4f)), hn::Gt(loss, set(0.5f)));
            const auto is_bent = [&](V less_exact) {
                const auto exceeds = [&](V coefficient, float limit) {
                    return hn::Gt(hn::Abs(coefficient),
                                  hn::Mul(hn::MulAdd(less_exact, set(limit), noise), mean[channel]));
                };
                return hn::And(hn::Or(exceeds(fourth[channel], 0.03f), exceeds(fifth[channel], 0.012f)), may_bend);
            };
            if (hn::AllFalse(d, hn::Or(is_steep, is_bent(set(1.0f)))))
                continue;
            const V most_share =
                hn::Mul(angle_per_m, exp_of(d, hn::Min(hn::Sub(log_share, least[depths]), set(40.0f))));
            // The rule's error is the cube of the coefficients; of a smaller share, more of it will do.
            const V less_exact = hn::Max(set(1.0f), hn::Sqrt(reciprocal_root_of(d, hn::Max(most_share, set(1e-20f)))));
            const auto is_something = hn::And(hn::Gt(most_share, set(static_cast<float>(LocalPieces::nothing))),
                                              hn::Lt(least[depths], set(80.0f)));
            is_rough = hn::Or(is_rough, hn::And(hn::Or(is_steep, is_bent(less_exact)), is_something));
        }
        V sum[3];
        for (std::size_t channel = 0; channel < 3; ++channel)
            sum[channel] = hn::Mul(mean[channel], angle_per_m);
        if constexpr (is_whole) {
            for (std::size_t channel = 0; channel < 3; ++channel)
                hn::Store(hn::IfThenZeroElse(is_rough, sum[channel]), d, pieces.sum[channel].data() + first);
            if (hn::AllFalse(d, is_rough))
                return;
        }
        finish_lanes<is_whole>(first, used, sum, is_rough, r0, r1);
    }

    /// Adds up parts that will do, and halves the others.
    template <bool is_whole>
    void finish_lanes(std::size_t first, std::size_t used, const V (&sum)[3], Mask is_rough, V r0, V r1) {
        alignas(64) float result[3][lanes], radius0[lanes], radius1[lanes];
        alignas(64) std::int32_t rough[lanes];
        for (std::size_t channel = 0; channel < 3; ++channel)
            hn::Store(sum[channel], d, result[channel]);
        hn::Store(hn::IfThenElseZero(hn::RebindMask(di, is_rough), hn::Set(di, 1)), di, rough);
        hn::Store(r0, d, radius0), hn::Store(r1, d, radius1);
        for (std::size_t lane = 0; lane < used; ++lane) {
            const Part part =
                is_whole ? Part{.piece = static_cast<std::uint32_t>(first + lane), .depth = 0} : parts[first + lane];
            if (rough[lane] != 0 && part.depth < most_halvings)
                halve(part, radius0[lane], radius1[lane]);
            else if (!is_whole)
                for (std::size_t channel = 0; channel < 3; ++channel)
                    pieces.sum[channel][part.piece] += result[channel][lane];
        }
    }

    void scatter_of_sets(const std::int32_t (&set_of)[lanes], hn::Vec<decltype(di)> set_index, V towards, V away,
                         V cosine2, V (&scatter)[3]) const {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (std::find(set_of, set_of + lane, set_of[lane]) != set_of + lane)
                continue;
            V own[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
            add_lobes(sets[static_cast<std::size_t>(set_of[lane])], towards, away, cosine2, own);
            const auto is_mine = hn::RebindMask(d, hn::Eq(set_index, hn::Set(di, set_of[lane])));
            for (std::size_t channel = 0; channel < 3; ++channel)
                scatter[channel] = hn::IfThenElse(is_mine, own[channel], scatter[channel]);
        }
    }

    /// At the middle of the angle, by the sine rule.
    void halve(const Part& part, float radius0, float radius1) {
        const float before = radius1 / (radius0 + radius1), after = radius0 / (radius0 + radius1);
        const std::array<float, 2> middle{before * part.begin[0] + after * part.end[0],
                                          before * part.begin[1] + after * part.end[1]};
        parts.push_back({part.piece, part.depth + 1, part.begin, middle});
        parts.push_back({part.piece, part.depth + 1, middle, part.end});
    }
};

void integrate_of(const LocalShape& shape, const std::array<float, 3>& sigma_t_at_light, const LocalSupport& support,
                  std::span<const SetOfMedia> sets, LocalPieces& pieces) {
    thread_local std::vector<Part> parts;
    thread_local std::vector<LaneCrossing> crossings;
    parts.clear();
    Kernel kernel{shape, sigma_t_at_light, support, sets, pieces, parts, crossings};
    for (std::size_t pad = pieces.count; pieces.count > 0 && pad % lanes != 0; ++pad) // whole vectors are read
        for (auto* column : {&pieces.ray, &pieces.set, &pieces.is_grey})
            (*column)[pad] = (*column)[pieces.count - 1];
    for (std::size_t first = 0; first < pieces.count; first += lanes)
        kernel.evaluate<true>(first, std::min(lanes, pieces.count - first));
    for (std::size_t first = 0, used; first < parts.size(); first += used) { // grows meanwhile
        used = std::min(lanes, parts.size() - first);
        kernel.evaluate<false>(first, used);
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(integrate_of);

void integrate(const LocalShape& shape, const std::array<float, 3>& sigma_t_at_light, const LocalSupport& support,
               std::span<const SetOfMedia> sets, LocalPieces& pieces) {
    HWY_DYNAMIC_DISPATCH(integrate_of)(shape, sigma_t_at_light, support, sets, pieces);
}
} // namespace tyndall::light_shafts
#endif
