// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/strands.hpp"
#include "core/errors.hpp"
#include "scene/attribute_pairs.hpp"
#include "scene/embree.hpp"
#include "scene/tube_mesh.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
static bool is_traceable(const vec4& point) {
    for (int i = 0; i < 4; ++i)
        if (!(std::abs(point[i]) < largest_coordinate_m)) // true for a NaN, too
            return false;
    return true;
}

static void validate(const StrandArrays& arrays) {
    require(arrays.points.size() < 0xffffffffu / 2, "strands '", arrays.name, "': ", arrays.points.size(),
            " points are too many");
    require(arrays.ribbon_pieces >= 1 && arrays.ribbon_pieces <= 16, "strands '", arrays.name,
            "': ", arrays.ribbon_pieces, " pieces of a segment are not in [1, 16]");
    require(arrays.layers == 1 || arrays.layers == 2, "strands '", arrays.name, "': ", arrays.layers,
            " layers of a strand are neither 1 nor 2");
    const bool has_strands = arrays.form != StrandForm::Spheres;
    require(has_strands || arrays.first_points.empty(), "points '", arrays.name, "': spheres have no strands");
    const std::size_t count = has_strands ? arrays.first_points.size() : arrays.points.size();
    if (has_strands) {
        require(std::ranges::is_sorted(arrays.first_points), "strands '", arrays.name, "' do not follow each other");
        require(arrays.first_points.empty()
                    ? arrays.points.empty()
                    : arrays.first_points.front() == 0 && arrays.first_points.back() <= arrays.points.size(),
                "strands '", arrays.name, "' ask for points that are not there");
    }
    require(arrays.randoms.empty() || arrays.randoms.size() == count, "strands '", arrays.name,
            "': ", arrays.randoms.size(), " random numbers for ", count);
    for (const StrandArrays::Map& map : arrays.maps)
        require(map.values.size() == count || map.values.size() == arrays.points.size(), "strands '", arrays.name,
                "': map '", map.name, "' has ", map.values.size(), " values for ", count, " strands of ",
                arrays.points.size(), " points");
}

Strands::Strands(StrandArrays arrays, const Progress& progress) : arrays_(std::move(arrays)) {
    validate(arrays_);
    progress.poll();
    drop_unusable();
    build(progress);
}

Strands::~Strands() { rtcReleaseScene(embree_scene_); }

static bool has_extent(std::span<const vec4> points) {
    const bool has_width = std::ranges::any_of(points, [](const vec4& point) { return point.w > 0.0f; });
    return has_width && std::ranges::any_of(points, [&](const vec4& point) { return vec3(point) != vec3(points[0]); });
}

/// And doubles the ends of what is kept.
void Strands::drop_unusable() {
    StrandArrays kept{
        .name = arrays_.name, .form = arrays_.form, .ribbon_pieces = arrays_.ribbon_pieces, .layers = arrays_.layers};
    for (const StrandArrays::Map& map : arrays_.maps)
        kept.maps.push_back({.name = map.name, .values = {}});
    const bool has_strands = arrays_.form != StrandForm::Spheres;
    const std::size_t count = has_strands ? arrays_.first_points.size() : arrays_.points.size();
    kept.points.reserve(arrays_.points.size() + (has_strands ? 2 * count : 0));
    for (std::size_t strand = 0; strand < count; ++strand) {
        const std::size_t first = has_strands ? arrays_.first_points[strand] : strand;
        const std::size_t end = !has_strands          ? strand + 1
                                : strand + 1 == count ? arrays_.points.size()
                                                      : arrays_.first_points[strand + 1];
        const std::span<const vec4> points = std::span(arrays_.points).subspan(first, end - first);
        if (!std::ranges::all_of(points, is_traceable)) {
            ++non_finite_count_;
            continue;
        }
        if (has_strands ? points.size() < 2 || !has_extent(points) : !(points[0].w > 0.0f)) {
            ++degenerate_count_;
            continue;
        }
        const auto add = [&](const vec4& point) { kept.points.emplace_back(vec3(point), std::max(point.w, 0.0f)); };
        if (has_strands) {
            kept.first_points.push_back(static_cast<std::uint32_t>(kept.points.size()));
            add(points.front());
        }
        std::ranges::for_each(points, add);
        if (has_strands)
            add(points.back());
        for (std::size_t map = 0; map < kept.maps.size(); ++map) {
            const std::vector<vec2>& values = arrays_.maps[map].values;
            std::vector<vec2>& of_kept = kept.maps[map].values;
            if (values.size() == count) {
                of_kept.push_back(values[strand]);
                continue;
            }
            of_kept.push_back(values[first]);
            of_kept.insert(of_kept.end(), values.begin() + static_cast<std::ptrdiff_t>(first),
                           values.begin() + static_cast<std::ptrdiff_t>(end));
            of_kept.push_back(values[end - 1]);
        }
        if (!arrays_.randoms.empty())
            kept.randoms.push_back(arrays_.randoms[strand]);
    }
    arrays_ = std::move(kept);
}

std::size_t Strands::strand_count() const {
    return arrays_.form == StrandForm::Spheres ? arrays_.points.size() : arrays_.first_points.size();
}

std::size_t Strands::segment_count() const {
    return arrays_.points.size() - (arrays_.form == StrandForm::Spheres ? 0 : 3 * arrays_.first_points.size());
}

std::uint32_t Strands::strand_of(std::uint32_t segment) const {
    if (arrays_.form == StrandForm::Spheres)
        return segment;
    // A strand has three segments fewer than points, its ends being doubled.
    std::size_t low = 0, high = arrays_.first_points.size();
    while (high - low > 1) {
        const std::size_t middle = (low + high) / 2;
        (arrays_.first_points[middle] - 3 * middle <= segment ? low : high) = middle;
    }
    return static_cast<std::uint32_t>(low);
}

std::span<const vec4> Strands::points_of(std::uint32_t strand) const {
    const std::size_t first = arrays_.first_points[strand];
    const std::size_t end =
        strand + 1 < arrays_.first_points.size() ? arrays_.first_points[strand + 1] : arrays_.points.size();
    return std::span(arrays_.points).subspan(first, end - first);
}

static RTCGeometryType embree_type(StrandForm form) {
    switch (form) {
    case StrandForm::Ribbon:
        return RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE;
    case StrandForm::Round:
        return RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE;
    case StrandForm::RoundLinear:
        return RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE;
    case StrandForm::Spheres:
        break;
    }
    return RTC_GEOMETRY_TYPE_SPHERE_POINT;
}

/// Tubes and spheres are met from outside: light that passes a hair leaves it freely, as in Cycles.
static void pass_from_within(const RTCFilterFunctionNArguments* arguments) {
    const unsigned int count = arguments->N;
    for (unsigned int lane = 0; lane < count; ++lane) {
        const vec3 direction(RTCRayN_dir_x(arguments->ray, count, lane), RTCRayN_dir_y(arguments->ray, count, lane),
                             RTCRayN_dir_z(arguments->ray, count, lane));
        const vec3 normal(RTCHitN_Ng_x(arguments->hit, count, lane), RTCHitN_Ng_y(arguments->hit, count, lane),
                          RTCHitN_Ng_z(arguments->hit, count, lane));
        if (glm::dot(direction, normal) > 0.0f)
            arguments->valid[lane] = 0;
    }
}

void Strands::build(const Progress& progress) {
    const RTCDevice device = embree_device();
    embree_scene_ = rtcNewScene(device);
    rtcSetSceneFlags(embree_scene_, traced_scene_flags);
    if (segment_count() > 0) {
        const RTCGeometry geometry = rtcNewGeometry(device, embree_type(arrays_.form));
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, arrays_.points.data(), 0,
                                   sizeof(vec4), arrays_.points.size());
        if (arrays_.form != StrandForm::Spheres) {
            const std::size_t count = segment_count();
            const bool is_linear = arrays_.form == StrandForm::RoundLinear;
            auto* first_of = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
                geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(std::uint32_t), count));
            auto* neighbours = is_linear ? static_cast<std::uint8_t*>(rtcSetNewGeometryBuffer(
                                               geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, 1, count))
                                         : nullptr;
            std::size_t segment = 0;
            for (std::uint32_t strand = 0; first_of != nullptr && strand < arrays_.first_points.size(); ++strand) {
                const std::size_t of_strand = points_of(strand).size() - 3;
                for (std::size_t i = 0; i < of_strand; ++i, ++segment) {
                    first_of[segment] =
                        arrays_.first_points[strand] + static_cast<std::uint32_t>(i) + (is_linear ? 1 : 0);
                    if (neighbours != nullptr)
                        neighbours[segment] =
                            static_cast<std::uint8_t>((i > 0 ? int{RTC_CURVE_FLAG_NEIGHBOR_LEFT} : 0) |
                                                      (i + 1 < of_strand ? int{RTC_CURVE_FLAG_NEIGHBOR_RIGHT} : 0));
                }
            }
        }
        if (arrays_.form == StrandForm::Ribbon) {
            rtcSetGeometryTessellationRate(geometry, static_cast<float>(arrays_.ribbon_pieces));
        } else {
            rtcSetGeometryIntersectFilterFunction(geometry, pass_from_within);
            rtcSetGeometryOccludedFilterFunction(geometry, pass_from_within);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(embree_scene_, geometry, 0);
        rtcReleaseGeometry(geometry);
    }
    try {
        commit(embree_scene_, "strands '" + arrays_.name + "'", progress);
    } catch (...) {
        rtcReleaseScene(embree_scene_);
        throw;
    }
    for (std::uint32_t segment = 0; segment < segment_count(); ++segment)
        bounds_.grow(segment_bounds(segment));
}

StrandPoint Strands::on_spline(std::uint32_t segment, float along) const {
    if (arrays_.form == StrandForm::Spheres)
        return {.centre = vec3(arrays_.points[segment]), .radius_m = arrays_.points[segment].w};
    const vec4* p = &arrays_.points[segment + 3 * strand_of(segment)];
    if (arrays_.form == StrandForm::RoundLinear) {
        const vec4 at = p[1] + along * (p[2] - p[1]);
        return {.centre = vec3(at), .radius_m = at.w, .tangent = vec3(p[2] - p[1])};
    }
    const float t = along;
    // Around p[1], so that a strand far from its object's origin stays smooth.
    const vec4 before = p[0] - p[1], end = p[2] - p[1], after = p[3] - p[1];
    const vec4 linear = 0.5f * (end - before), square = before + 2.0f * end - 0.5f * after,
               cube = 0.5f * (after - before - 3.0f * end);
    const vec4 at = p[1] + t * (linear + t * (square + t * cube));
    const vec4 slope = linear + t * (2.0f * square + t * 3.0f * cube);
    vec3 tangent(slope);
    if (!(glm::dot(tangent, tangent) > 0.0f)) // where points coincide
        tangent = vec3(p[3] - p[0]);
    return {.centre = vec3(at), .radius_m = std::max(at.w, 0.0f), .tangent = tangent};
}

StrandPoint Strands::point(std::uint32_t segment, vec2 on, const vec3& direction, const vec3& normal) const {
    StrandPoint result = on_spline(segment, on.x);
    const vec3 back = unit_or(-direction, {0, 0, 1});
    if (arrays_.form == StrandForm::Ribbon) {
        const vec3 tangent = unit_or(result.tangent, {0, 0, 1});
        const vec3 across = unit_or(glm::cross(tangent, back), orthonormal_basis(tangent).first);
        const float sine = std::clamp(on.y, -1.0f, 1.0f);
        result.normal = unit_or(sine * across - std::sqrt(1.0f - sine * sine) * glm::cross(tangent, across), back);
    } else { // not tilted where the tube becomes thinner, as in Cycles
        const float squared = glm::dot(result.tangent, result.tangent);
        result.normal = unit_or(
            squared > 0.0f ? normal - glm::dot(normal, result.tangent) / squared * result.tangent : normal, back);
    }
    return result;
}

Bounds3 Strands::segment_bounds(std::uint32_t segment) const {
    Bounds3 box;
    if (arrays_.form == StrandForm::Spheres) {
        const vec4& point = arrays_.points[segment];
        box.grow(vec3(point) - point.w);
        box.grow(vec3(point) + point.w);
        return box;
    }
    // A segment of the spline as Bezier curve: it lies within its four points.
    const vec4* p = &arrays_.points[segment + 3 * strand_of(segment)];
    for (const vec4& corner : {p[1], p[1] + (p[2] - p[0]) / 6.0f, p[2] - (p[3] - p[1]) / 6.0f, p[2]}) {
        box.grow(vec3(corner) - std::max(corner.w, 0.0f));
        box.grow(vec3(corner) + std::max(corner.w, 0.0f));
    }
    return box;
}

/// As Cycles tells thickness, while it draws the spline's.
float Strands::linear_radius(std::uint32_t segment, float along) const {
    if (arrays_.form == StrandForm::Spheres)
        return arrays_.points[segment].w;
    const vec4* p = &arrays_.points[segment + 3 * strand_of(segment)];
    return p[1].w + along * (p[2].w - p[1].w);
}

vec2 Strands::value_of(const StrandArrays::Map& map, std::uint32_t segment, float along) const {
    const std::uint32_t strand = strand_of(segment);
    if (map.values.size() != arrays_.points.size() || arrays_.form == StrandForm::Spheres)
        return map.values[strand];
    const vec2* ends = &map.values[segment + 3 * strand + 1];
    return ends[0] + along * (ends[1] - ends[0]);
}

vec2 strand_maps::of_edge(std::string_view name, const SharedMeshArrays& mesh, std::uint32_t triangle,
                          const mat4& world_from_object) {
    const bool is_xy = name.starts_with(along_xy);
    if (!is_xy && !name.starts_with(along_z))
        return vec2(0.0f);
    const auto corner = [&](std::size_t from_end) -> const vec3& {
        const auto number = static_cast<glm::length_t>(name[name.size() - from_end] - '0');
        return mesh.positions[mesh.triangles[triangle][std::clamp(number, 0, 2)]];
    };
    const vec3 along = mat3(world_from_object) * (corner(1) - corner(2));
    return is_xy ? vec2(along.x, along.y) : vec2(along.z, 0.0f);
}

vec2 Strands::look_up(std::string_view name, std::uint32_t segment, vec2 on, const vec3& normal, const vec3& along,
                      const vec3& place) const {
    if (name.starts_with(strand_maps::along_xy))
        return {along.x, along.y};
    if (name.starts_with(strand_maps::along_z))
        return {along.z, 0.0f};
    if (name == strand_maps::normal_xy)
        return {normal.x, normal.y};
    if (name == strand_maps::normal_z)
        return {normal.z, 0.0f};
    const std::uint32_t strand = strand_of(segment);
    const bool is_strand = arrays_.form != StrandForm::Spheres;
    if (name == strand_maps::is_strand)
        return {is_strand ? 1.0f : 0.0f, 0.0f};
    if (name == strand_maps::random_and_thickness)
        return {arrays_.randoms.empty() ? 0.0f : arrays_.randoms[strand], 2.0f * linear_radius(segment, on.x)};
    if (name == strand_maps::intercept_and_length) {
        if (!is_strand)
            return {0.0f, 0.0f};
        const std::span<const vec4> points = points_of(strand);
        const std::size_t here = segment - (arrays_.first_points[strand] - 3 * std::size_t{strand}) + 1;
        float length_m = 0.0f, before_m = 0.0f;
        for (std::size_t i = 1; i + 2 < points.size(); ++i) {
            const float step_m = glm::length(vec3(points[i + 1]) - vec3(points[i]));
            before_m += i < here ? step_m : i == here ? on.x * step_m : 0.0f;
            length_m += step_m;
        }
        return {length_m > 0.0f ? before_m / length_m : 0.0f, length_m};
    }
    if (name == attribute_pairs::red_green || name == attribute_pairs::blue_alpha)
        return {0.0f, 0.0f}; // hair and points have no active colour, as in Cycles
    const StrandArrays::Map* const map = find_map(name);
    if (map != nullptr)
        return value_of(*map, segment, on.x);
    return name == generated_xy ? vec2(place) : name == generated_zw ? vec2(place.z, 1.0f) : vec2(0.0f);
}

std::optional<vec2> Strands::active_uv(std::uint32_t segment, vec2 on) const {
    const StrandArrays::Map* const map = find_map("");
    return map == nullptr ? std::nullopt : std::optional(value_of(*map, segment, on.x));
}

const StrandArrays::Map* Strands::find_map(std::string_view name) const {
    const auto found = std::ranges::find_if(
        arrays_.maps, [&](const StrandArrays::Map& map) { return attribute_pairs::answers(map.name, name); });
    return found == arrays_.maps.end() ? nullptr : &*found;
}

const TriangleBvh& Strands::tubes(const Progress& progress) const {
    const std::lock_guard lock(tubes_mutex_);
    if (!tubes_)
        tubes_ = std::make_shared<const TriangleBvh>(TubeMesh(*this).bvh(progress));
    return *tubes_;
}
} // namespace tyndall
