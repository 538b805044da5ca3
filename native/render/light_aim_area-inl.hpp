// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights for the lanes of light_aim.cpp, which includes this inside its namespace, once per SIMD target.
// Based on: scene/area_light.cpp, whose strata these are; there is the source of each formula.
// Differs:  sine and cosine of an angle within half a turn by those of its quarter, doubled twice: 3e-7.

struct Turn {
    V sine, cosine;
};
/// Of an angle in [-pi, pi].
static HWY_INLINE Turn sine_and_cosine(V angle) {
    const V quarter = set(0.25f) * angle, a2 = quarter * quarter;
    V sine = hn::MulAdd(a2, set(1.0f / 362880.0f), set(-1.0f / 5040.0f));
    sine = hn::MulAdd(a2, sine, set(1.0f / 120.0f));
    sine = hn::MulAdd(a2, sine, set(-1.0f / 6.0f));
    sine = hn::MulAdd(a2 * quarter, sine, quarter);
    V versed = hn::MulAdd(a2, set(-1.0f / 3628800.0f), set(1.0f / 40320.0f)); // 1 - cosine
    versed = hn::MulAdd(a2, versed, set(-1.0f / 720.0f));
    versed = hn::MulAdd(a2, versed, set(1.0f / 24.0f));
    versed = hn::MulAdd(a2, versed, set(-0.5f)) * hn::Neg(a2);
    for (int doubling = 0; doubling < 2; ++doubling) {
        const V cosine = set(1.0f) - versed;
        versed = set(2.0f) * sine * sine;
        sine = set(2.0f) * sine * cosine;
    }
    return {sine, set(1.0f) - versed};
}

/// The part of a light's box that may shine on a point, from the point's foot in the light's plane.
struct SeenBox {
    V2 foot, low, high;
    V height;
};
static HWY_INLINE SeenBox seen_box(const Form& form, const V3& position) {
    const V3 way = subtract(position, set(form.position));
    SeenBox box{{dot(way, set(form.area_axes[0])), dot(way, set(form.area_axes[1]))},
                {},
                {},
                dot(way, set(-form.area_axes[2]))};
    const V half_x = set(form.half_size_m.x), half_y = set(form.half_size_m.y);
    box.low = {hn::Neg(half_x) - box.foot.x, hn::Neg(half_y) - box.foot.y};
    box.high = {half_x - box.foot.x, half_y - box.foot.y};
    if (form.spread.cotangent > 0.0f) {
        const V reach = box.height * set(1.0f / form.spread.cotangent);
        box.low = {hn::Max(box.low.x, hn::Neg(reach)), hn::Max(box.low.y, hn::Neg(reach))};
        box.high = {hn::Min(box.high.x, reach), hn::Min(box.high.y, reach)};
    }
    return box;
}

/// Not what lies behind it, beside its spread's square, or has all of its box below the horizon.
static HWY_INLINE Mask may_area_light(const Form& form, const V3& position, const V3& normal) {
    const SeenBox box = seen_box(form, position);
    const V slack = hn::MulAdd(set(1e-5f), hn::Abs(box.height), set(form.margin));
    const Mask is_before = hn::And(hn::Gt(box.height, hn::Zero(d)), hn::And(hn::Lt(box.low.x, box.high.x + slack),
                                                                            hn::Lt(box.low.y, box.high.y + slack)));
    const V along_x = hn::Abs(dot(normal, set(form.area_axes[0]))) * set(form.half_size_m.x);
    const V along_y = hn::Abs(dot(normal, set(form.area_axes[1]))) * set(form.half_size_m.y);
    const V middle = dot(subtract(set(form.position), position), normal);
    return hn::And(is_before, hn::Gt(middle + along_x + along_y + slack, hn::Zero(d)));
}

/// `square`: the random numbers; `disc`: the same on the unit disc. `target`: the point on the light.
static HWY_INLINE Mask aim_area(const Form& form, const V2& square, const V2& disc, const V3& position,
                                const V3& normal, V3& target, V& weight) {
    const SeenBox box = seen_box(form, position);
    const auto& [foot, low, high, height] = box;
    const V zero = hn::Zero(d), one = set(1.0f), least = set(1e-30f);
    Mask is_lit = hn::And(hn::Gt(height, zero), hn::And(hn::Lt(low.x, high.x), hn::Lt(low.y, high.y)));
    const V height2 = height * height;
    const auto angle = [&](V x, V y) {
        const V distance = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, height2)));
        return light_shafts::HWY_NAMESPACE::atan2_of(d, x * y, height * distance);
    };
    const V from = angle(low.x, high.y) - angle(low.x, low.y), to = angle(high.x, high.y) - angle(high.x, low.y);
    const V solid_angle = to - from;
    const Mask is_far = hn::Lt(solid_angle, set(least_solid_angle_sr));
    const auto [sine_of_turn, cosine_of_turn] = sine_and_cosine(hn::MulAdd(square.x, solid_angle, from));
    const auto edge = [&](V y) { return y / hn::Sqrt(hn::Max(hn::MulAdd(y, y, height2), least)); };
    const V lower = hn::Neg(edge(low.y)), upper = edge(high.y);
    const V f = hn::Neg(hn::MulAdd(cosine_of_turn, lower, upper));
    const V cu = hn::CopySign(one, hn::Neg(f)) * sine_of_turn /
                 hn::Sqrt(hn::Max(hn::MulAdd(f, f, lower * lower * sine_of_turn * sine_of_turn), least));
    const V in_cone_x = cu * height / hn::Sqrt(hn::Max(hn::NegMulAdd(cu, cu, one), least));
    const V x = hn::Min(hn::Max(in_cone_x, low.x), high.x), across2 = hn::MulAdd(x, x, height2);
    const auto rise = [&](V y) { return y / hn::Sqrt(hn::Max(hn::MulAdd(y, y, across2), least)); };
    const V from_rise = rise(low.y), h = hn::MulAdd(square.y, rise(high.y) - from_rise, from_rise);
    const V in_cone_y = h * hn::Sqrt(across2 / hn::Max(hn::NegMulAdd(h, h, one), least));
    const V y = hn::Min(hn::Max(in_cone_y, low.y), high.y);
    const V size_x = high.x - low.x, size_y = high.y - low.y;
    V2 place{hn::IfThenElse(is_far, hn::MulAdd(square.x, size_x, low.x), x),
             hn::IfThenElse(is_far, hn::MulAdd(square.y, size_y, low.y), y)};
    Mask by_area = is_far;
    V area = size_x * size_y;
    const V half_x = set(form.half_size_m.x), half_y = set(form.half_size_m.y);
    if (form.is_ellipse) {
        const V away_x = hn::Max(hn::Abs(foot.x) - half_x, zero), away_y = hn::Max(hn::Abs(foot.y) - half_y, zero);
        const V across_x = hn::Abs(foot.x) + half_x, across_y = hn::Abs(foot.y) + half_y;
        const V nearest2 = hn::MulAdd(away_x, away_x, hn::MulAdd(away_y, away_y, height2));
        const V farthest2 = hn::MulAdd(across_x, across_x, hn::MulAdd(across_y, across_y, height2));
        const Mask is_whole = hn::And(hn::Gt(size_x, set(1.9999f) * half_x), hn::Gt(size_y, set(1.9999f) * half_y));
        const Mask takes_disc = hn::And(is_whole, hn::Lt(farthest2, set(area_far_ratio) * nearest2));
        place.x = hn::IfThenElse(takes_disc, hn::MulSub(disc.x, half_x, foot.x), place.x);
        place.y = hn::IfThenElse(takes_disc, hn::MulSub(disc.y, half_y, foot.y), place.y);
        by_area = hn::Or(by_area, takes_disc);
        area = hn::IfThenElse(takes_disc, set(1.0f / form.per_area_m2), area);
        const V unit_x = (place.x + foot.x) / half_x, unit_y = (place.y + foot.y) / half_y;
        is_lit = hn::And(is_lit, hn::Or(takes_disc, hn::Le(hn::MulAdd(unit_x, unit_x, unit_y * unit_y), one)));
    }
    target = along(along(set(form.position), place.x + foot.x, set(form.area_axes[0])), place.y + foot.y,
                   set(form.area_axes[1]));
    const V3 way = subtract(target, position);
    const V beside2 = hn::MulAdd(place.x, place.x, place.y * place.y), distance2 = beside2 + height2;
    const V inverse = one / hn::Sqrt(hn::Max(distance2, least));
    const V spread = set(form.spread.gain) *
                     hn::Max(zero, one - set(form.spread.cotangent) * hn::Sqrt(beside2) / hn::Max(height, least));
    const V projected = hn::IfThenElse(by_area, area * height * inverse * inverse * inverse, solid_angle);
    const V cosine = dot(normal, way) * inverse;
    weight = set(form.per_area_m2) * projected * spread * cosine;
    return hn::And(is_lit, hn::Gt(cosine, zero));
}
