// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/surface_samples.hpp"
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "voxel_dag/surface_samples.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TYNDALL_SURFACE_SAMPLES_CODES
#define TYNDALL_SURFACE_SAMPLES_CODES
namespace tyndall::voxel_dag {
/// Parts of a voxel's Morton code in its tile.
inline constexpr auto code_along = [] {
    std::array<std::array<std::uint32_t, tile_side>, 3> codes{};
    for (std::uint32_t axis = 0; axis < 3; ++axis)
        for (std::uint32_t at = 0; at < tile_side; ++at)
            codes[axis][at] = static_cast<std::uint32_t>(spread_bits(at) << axis);
    return codes;
}();
} // namespace tyndall::voxel_dag
#endif

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::FixedTag<float, 4>;
using V = hn::Vec<Tag>;
static constexpr Tag d;

static HWY_INLINE V four(const Four& values) { return hn::Load(d, values.data()); }
/// x, y, z as floats.
using Index = std::array<float, 3>;
static HWY_INLINE V value_at(const LinearFour& function, const Index& index) {
    V value = four(function.at_first);
    for (std::size_t axis = 0; axis < 3; ++axis)
        value = hn::Add(value, hn::Mul(four(function.per_step[axis]), hn::Set(d, index[axis])));
    return value;
}

/// Of the edges that the point lies beyond, the nearest one's nearest point.
static HWY_NOINLINE void share_on_edge(const SampledTriangle& triangle, const Index& index, V at, Four& shares) {
    const V along = value_at(triangle.along, index);
    const V on_edge = hn::Min(hn::Max(along, hn::Zero(d)), hn::Set(d, 1.0f));
    const V beside = hn::Mul(at, four(triangle.cover_scale));
    const V behind = hn::Mul(hn::Sub(along, on_edge), four(triangle.edge_lengths));
    const V squared = hn::Add(hn::Mul(beside, beside), hn::Mul(behind, behind));
    alignas(16) Four distances, places;
    hn::Store(hn::IfThenElse(hn::Lt(at, hn::Zero(d)), squared, hn::Set(d, 1e30f)), d, distances.data());
    hn::Store(on_edge, d, places.data());
    std::size_t edge = distances[1] < distances[0] ? 1 : 0;
    edge = distances[2] < distances[edge] ? 2 : edge;
    shares[edge] = 0;
    shares[(edge + 1) % 3] = 1 - places[edge];
    shares[(edge + 2) % 3] = places[edge];
}

static std::size_t take(const SampledTriangle& triangle, const TriangleRuns& runs, std::size_t run,
                        const ScanAxes& axes, const TileSlots& slots, SurfaceSamples& samples) {
    const V scale = four(triangle.cover_scale), offset = four(triangle.cover_offset);
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto is_share = hn::FirstN(d, 3);
    const V weight_scale = hn::Set(d, triangle.weight_scale), most_weight = hn::Set(d, triangle.most_weight);
    const auto of_row = row_place(axes), of_depth = depth_place(axes);
    const auto& run_codes = code_along[axes.run];
    std::size_t count = 0;
    for (; run < runs.count && count + tile_side <= SurfaceSamples::room; ++run) {
        const std::uint32_t row = of_row.at(runs.places[run]), depth = of_depth.at(runs.places[run]);
        const std::uint32_t code_of_word = code_along[axes.row][row] | code_along[axes.depth][depth];
        Index index;
        index[axes.row] = static_cast<float>(row);
        index[axes.depth] = static_cast<float>(depth);
        for (std::uint64_t left = runs.masks[run]; left != 0; left &= left - 1) {
            const auto at_run = static_cast<std::uint32_t>(std::countr_zero(left));
            index[axes.run] = static_cast<float>(at_run);
            const std::uint32_t code = code_of_word | run_codes[at_run], brick = code >> 3 * leaf_level;
            const std::uint64_t mask = slots.masks[brick], bit = std::uint64_t{1} << (code & 63);
            const V at = value_at(triangle.shares, index);

            V cover = hn::Add(hn::Mul(hn::IfThenElse(is_share, at, hn::Abs(at)), scale), offset);
            cover = hn::Min(hn::Max(cover, zero), one);
            cover = hn::Mul(cover, hn::Shuffle2301(cover));
            cover = hn::Mul(cover, hn::Shuffle1032(cover));
            const V weight = hn::Max(hn::Round(hn::Min(hn::Mul(cover, weight_scale), most_weight)), one);

            hn::Store(at, d, samples.shares[count].data());
            if (!hn::AllFalse(d, hn::And(is_share, hn::Lt(at, zero))))
                share_on_edge(triangle, index, at, samples.shares[count]);
            samples.weights[count] = hn::GetLane(weight);
            samples.slots[count] = slots.first[brick] + static_cast<std::uint32_t>(std::popcount(mask & (bit - 1)));
            count += (mask & bit) != 0;
        }
    }
    samples.count = count;
    return run;
}

static void add(const SurfaceSamples& samples, const std::array<Four, 3>& values, std::size_t stride, FourSums* sums) {
    const V a = four(values[0]), b = four(values[1]), c = four(values[2]);
    for (std::size_t sample = 0; sample < samples.count; ++sample) {
        const V share = hn::Mul(four(samples.shares[sample]), hn::Set(d, samples.weights[sample]));
        const V mean = hn::Add(hn::Add(hn::Mul(hn::Broadcast<0>(share), a), hn::Mul(hn::Broadcast<1>(share), b)),
                               hn::Mul(hn::Broadcast<2>(share), c));
        const auto rounded = hn::NearestInt(mean);
        std::int64_t* const sum = sums[samples.slots[sample] * stride].data();
#if HWY_MAX_BYTES >= 32
        const hn::FixedTag<std::int64_t, 4> wide;
        hn::StoreU(hn::Add(hn::LoadU(wide, sum), hn::PromoteTo(wide, rounded)), wide, sum);
#else
        const hn::FixedTag<std::int64_t, 2> wide;
        const hn::FixedTag<std::int32_t, 2> half;
        hn::StoreU(hn::Add(hn::LoadU(wide, sum), hn::PromoteTo(wide, hn::LowerHalf(rounded))), wide, sum);
        hn::StoreU(hn::Add(hn::LoadU(wide, sum + 2), hn::PromoteTo(wide, hn::UpperHalf(half, rounded))), wide, sum + 2);
#endif
    }
}

static void divide(const FourSums* sums, const FourSums* weights, std::size_t stride, std::size_t count,
                   FourMeans* means) {
    const hn::CappedTag<double, 4> wide;
    const hn::RebindToSigned<decltype(wide)> sum;
    const hn::Rebind<std::int32_t, decltype(wide)> whole;
    for (std::size_t slot = 0; slot < count; ++slot) {
        const auto per_weight = hn::Set(wide, 1.0 / static_cast<double>(weights[slot * stride][3]));
        for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(wide)) {
            const auto total = hn::ConvertTo(wide, hn::LoadU(sum, sums[slot * stride].data() + lane));
            hn::StoreU(hn::DemoteTo(whole, hn::Round(hn::Mul(total, per_weight))), whole, means[slot].data() + lane);
        }
    }
}
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
HWY_EXPORT(take);
HWY_EXPORT(add);
std::size_t take_samples(const SampledTriangle& triangle, const TriangleRuns& runs, std::size_t run,
                         const ScanAxes& axes, const TileSlots& slots, SurfaceSamples& samples) {
    return HWY_DYNAMIC_DISPATCH(take)(triangle, runs, run, axes, slots, samples);
}
void add_samples(const SurfaceSamples& samples, const std::array<Four, 3>& values, std::size_t stride, FourSums* sums) {
    HWY_DYNAMIC_DISPATCH(add)(samples, values, stride, sums);
}

HWY_EXPORT(divide);
void take_means(const FourSums* sums, const FourSums* weights, std::size_t stride, std::size_t count,
                FourMeans* means) {
    HWY_DYNAMIC_DISPATCH(divide)(sums, weights, stride, count, means);
}

/// Below this height in voxels, a sixteenth of a step, shares of the corners would not be told apart in single precision.
static constexpr double least_height = 1.0 / 4096;

namespace {
struct Linear {
    double at_zero;
    dvec3 gradient;
};
} // namespace

static void lay(const Linear& function, std::size_t lane, LinearFour& to) {
    to.at_first[lane] = static_cast<float>(function.at_zero);
    for (std::size_t axis = 0; axis < 3; ++axis)
        to.per_step[axis][lane] = static_cast<float>(function.gradient[static_cast<int>(axis)]);
}

/// A triangle that is no more than a line: everything lies beyond its longest edge; it is only as heavy as it is large.
static void make_line(const std::array<double, 3>& lengths, double area, SampledTriangle& to) {
    const auto longest = static_cast<std::size_t>(std::ranges::max_element(lengths) - lengths.begin());
    for (std::size_t lane = 0; lane < 4; ++lane)
        lay({lane == longest ? -1.0 : 0.0, dvec3(0)}, lane, to.shares);
    to.cover_scale = {0, 0, 0, 0};
    to.cover_offset = {1, 1, 1, 1};
    to.weight_scale = whole_weight;
    to.most_weight = static_cast<float>(whole_weight * area);
    to.normal = vec3(0);
}

SampledTriangle sampled(const SnappedTriangle& triangle, const TileFrame& frame) {
    std::array<dvec3, 3> corners; // in voxels, from the centre of the tile's first
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[corner][static_cast<int>(axis)] =
                static_cast<double>(triangle[corner][axis] - (frame.first_cell[axis] << frame.cell_bits)) /
                    (1 << step_bits) -
                0.5;
    SampledTriangle result{};
    std::array<double, 3> lengths;
    std::array<dvec3, 3> edges; // opposite to each corner
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const dvec3 &from = corners[(corner + 1) % 3], edge = corners[(corner + 2) % 3] - from;
        const double squared = glm::dot(edge, edge);
        edges[corner] = edge;
        lengths[corner] = std::sqrt(squared);
        const dvec3 gradient = squared > 0 ? edge / squared : dvec3(0);
        lay({-glm::dot(gradient, from), gradient}, corner, result.along);
        result.edge_lengths[corner] = static_cast<float>(lengths[corner]);
    }
    const dvec3 n = glm::cross(edges[2], -edges[1]);
    const double squared = glm::dot(n, n), length = std::sqrt(squared);
    if (!(length > least_height * std::ranges::max(lengths))) {
        make_line(lengths, 0.5 * length, result);
        return result;
    }
    const dvec3 unit = n / length;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const dvec3 gradient = glm::cross(n, edges[corner]) / squared;
        lay({-glm::dot(gradient, corners[(corner + 1) % 3]), gradient}, corner, result.shares);
        result.cover_scale[corner] = static_cast<float>(length / lengths[corner]); // its height
        result.cover_offset[corner] = 0.5f;                                        // half is left where the edge passes
    }
    // A plane between two voxels belongs to the upper one, as voxelize.hpp has it: all is a quarter step higher.
    constexpr double e = 0.25 / (1 << step_bits);
    lay({-glm::dot(unit, corners[0] + e), unit}, 3, result.shares);
    // Seen along the main axis the plane leaves a voxel gradually, over a distance of the other two components.
    const dvec3 sides = glm::abs(unit);
    const double most = std::max({sides.x, sides.y, sides.z}), sum = sides.x + sides.y + sides.z;
    const double fade = std::max(sum - most, e);
    result.cover_scale[3] = static_cast<float>(-1.0 / fade);
    result.cover_offset[3] = static_cast<float>(0.5 * sum / fade);
    result.weight_scale = static_cast<float>(whole_weight / most);
    result.most_weight = static_cast<float>(0.5 * length * whole_weight);
    result.normal = vec3(unit);
    return result;
}
} // namespace tyndall::voxel_dag
#endif
