// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/partial_shadow.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tyndall::light_shafts {
namespace {
/// Of a cut through a triangle whose transparency follows no texels, such as a pattern's.
constexpr int point_piece_count = 32;

/// A triangle's cut between the ray and the light, with barycentric coordinates (of the second and third corner).
struct BarycentricCut {
    CutSegment<double> segment;
    dvec2 from, to;
};

bool cut_between_ray_and_light(const PlaneCoordinates<double>& plane, const dvec3 (&corners)[3], const StripRay& ray,
                               BarycentricCut& cut) {
    constexpr dvec2 barycentrics[3] = {dvec2(0, 0), dvec2(1, 0), dvec2(0, 1)};
    // Heights in the kernel's precision might disagree on the side of a corner; a disagreement moves nothing visible.
    double height[3];
    int above = 0;
    for (int corner = 0; corner < 3; ++corner) {
        height[corner] = plane.height(corners[corner]);
        above |= (height[corner] >= 0.0) << corner;
    }
    if (above == 0 || above == 7)
        return false;
    const int lone = above == 1 || above == 6 ? 0 : above == 2 || above == 5 ? 1 : 2;
    struct End {
        double x, y;
        dvec2 at;
    };
    const auto end_towards = [&](int other) -> End {
        const double share = height[lone] / (height[lone] - height[other]);
        const dvec3 point = corners[lone] + share * (corners[other] - corners[lone]);
        return {plane.x(point), plane.y(point),
                barycentrics[lone] + share * (barycentrics[other] - barycentrics[lone])};
    };
    End a = end_towards((lone + 1) % 3), b = end_towards((lone + 2) % 3);
    const double top = ray.is_local ? double{ray.light_y} * (1.0 - 1e-6) : std::numeric_limits<double>::infinity();
    if (std::max(a.y, b.y) <= 0.0 || std::min(a.y, b.y) >= top)
        return false;
    const auto clip = [](End& end, const End& other, double y) {
        const double share = (y - end.y) / (other.y - end.y);
        end = {end.x + share * (other.x - end.x), y, end.at + share * (other.at - end.at)};
    };
    if (a.y < 0.0)
        clip(a, b, 0.0);
    if (b.y < 0.0)
        clip(b, a, 0.0);
    if (a.y > top)
        clip(a, b, top);
    if (b.y > top)
        clip(b, a, top);
    cut = {{a.x, a.y, b.x, b.y}, a.at, b.at};
    return true;
}

/// Where the light casts a point of the plane onto the ray.
double onto_ray(const StripRay& ray, double x, double y) {
    return ray.is_local ? x + y * (x - double{ray.light_x}) / (double{ray.light_y} - y) : x - double{ray.cotangent} * y;
}

/// UV coordinates of an image's operation at the corners of a triangle; nothing where the mesh lacks the UV map.
std::optional<std::array<dvec2, 3>> image_corners(const Material& material, const SurfaceOp& op,
                                                  const SharedMeshArrays& mesh, std::uint32_t triangle) {
    const SharedMeshArrays::UvMap* map = mesh.uv_map(material.uv_map_names[op.texture_uv]);
    if (map == nullptr)
        return std::nullopt;
    std::array<dvec2, 3> corners;
    for (std::size_t corner = 0; corner < 3; ++corner)
        corners[corner] =
            dvec2(glm::dmat3(op.uv_matrix) * dvec3(dvec2(map->corner_uvs[std::size_t{3} * triangle + corner]), 1.0));
    return corners;
}
dvec2 between(const std::array<dvec2, 3>& corners, const dvec2& at) {
    return corners[0] + at.x * (corners[1] - corners[0]) + at.y * (corners[2] - corners[0]);
}

/// Adds the shares of the way from one end of the cut to the other at which it crosses the borders of an image's texels;
/// keeps the order.
void add_texel_borders(const Texture& texture, const dvec2& uv_from, const dvec2& uv_to, std::vector<double>& borders) {
    constexpr double most_borders = 1024.0;
    // Linear interpolation bends at the centres of texels, unfiltered lookup jumps at their borders.
    const double shift = texture.interpolation == TextureInterpolation::Closest ? 0.0 : 0.5;
    const dvec2 size(texture.width, texture.height);
    const dvec2 from = uv_from * size - shift, to = uv_to * size - shift;
    if (!std::isfinite(from.x + from.y + to.x + to.y))
        return;
    const auto merge_from = [&](std::size_t first) {
        const auto middle = borders.begin() + static_cast<std::ptrdiff_t>(first);
        if (middle != borders.end() && *middle > borders.back())
            std::reverse(middle, borders.end());
        std::inplace_merge(borders.begin(), middle, borders.end());
    };
    const double crossed = std::abs(to.x - from.x) + std::abs(to.y - from.y);
    if (crossed > most_borders) {
        const std::size_t first = borders.size();
        for (double step = 1.0; step < most_borders; ++step)
            borders.push_back(step / most_borders);
        merge_from(first);
        return;
    }
    for (int axis = 0; axis < 2; ++axis) {
        const std::size_t first = borders.size();
        const double low = std::min(from[axis], to[axis]), high = std::max(from[axis], to[axis]);
        for (double border = std::floor(low) + 1.0; border < high; ++border)
            borders.push_back((border - from[axis]) / (to[axis] - from[axis]));
        merge_from(first);
    }
}
} // namespace

void append_partial_shadows(const Scene& scene, const StripScene& strip, const PartialCut& cut, const StripRay& ray,
                            std::vector<PartialShadow>& shadows) {
    const StripMesh& mesh = strip.meshes[cut.mesh];
    const SceneDescription& description = scene.description();
    const Instance& instance = description.instances[mesh.instance];
    const SharedMeshArrays& arrays = description.meshes[instance.mesh_index]->arrays();
    const Material& material = scene.material(mesh.instance, cut.triangle);
    const TransparencyLookup& lookup =
        *strip.lookups[static_cast<std::size_t>(&material - description.materials.data())];
    if (lookup.constant()) {
        shadows.push_back({cut.near_m, cut.far_m, *lookup.constant()});
        return;
    }
    const uvec3& triangle = arrays.triangles[cut.triangle];
    const dvec3 corners[3] = {dvec3(arrays.positions[triangle.x]), dvec3(arrays.positions[triangle.y]),
                              dvec3(arrays.positions[triangle.z])};
    BarycentricCut at;
    if (!cut_between_ray_and_light(ray.coordinates.in_object(instance.world_from_object), corners, ray, at))
        return;
    thread_local std::vector<double> borders;
    borders.assign({0.0});
    bool is_straight = false;
    dvec2 uv_from(0.0), uv_run(0.0); // in the deciding image
    for (const std::uint16_t place : lookup.operations().places) {
        const SurfaceOp& op = material.program[place];
        const bool reads_image = op.code == SurfaceOp::Code::Texture || op.code == SurfaceOp::Code::TextureAlpha;
        if (!reads_image || (lookup.image() != nullptr && lookup.image() != &op))
            continue;
        if (const auto uvs = image_corners(material, op, arrays, cut.triangle)) {
            uv_from = between(*uvs, at.from);
            uv_run = between(*uvs, at.to) - uv_from;
            is_straight = lookup.is_straight();
            add_texel_borders(*material.textures[op.texture], uv_from, uv_from + uv_run, borders);
        }
    }
    if (lookup.reads_point()) {
        for (int piece = 1; piece < point_piece_count; ++piece)
            borders.push_back(static_cast<double>(piece) / point_piece_count);
        std::ranges::sort(borders);
    }
    borders.push_back(1.0);
    const vec3 normal_in_object(glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0])));
    const dvec3 from_x = dvec3(ray.coordinates.x.direction), from_y = dvec3(ray.coordinates.y.direction);
    const auto x = [&](double share) { return at.segment.x0 + share * (at.segment.x1 - at.segment.x0); };
    const auto y = [&](double share) { return at.segment.y0 + share * (at.segment.y1 - at.segment.y0); };
    const auto transmittance_at = [&](double share) {
        if (is_straight)
            return lookup.at(vec2(uv_from + share * uv_run));
        // The shadow ray's own direction, from the ray's point to the light: a material may tell front from back.
        const dvec3 towards_light = (x(share) - onto_ray(ray, x(share), y(share))) * from_x + y(share) * from_y;
        const double length = glm::length(towards_light);
        const Ray shadow_ray{.origin = vec3(0.0f),
                             .direction = length > 0.0 ? vec3(towards_light / length) : vec3(from_y),
                             .near_m = 0.0f};
        const Hit hit{.distance_m = 0.0f,
                      .instance = mesh.instance,
                      .triangle = cut.triangle,
                      .barycentrics = vec2(at.from + share * (at.to - at.from)),
                      .geometric_normal = normal_in_object};
        return scene.passing_share(shadow_ray, hit);
    };
    // Most neighbours stop all light, or none: their shadows are one.
    double first = 0.0;
    Rgb transmittance(1.0f);
    const auto append_up_to = [&](double last) {
        if (!(first < last) || transmittance == Rgb(1.0f))
            return;
        const double a = onto_ray(ray, x(first), y(first)), b = onto_ray(ray, x(last), y(last));
        shadows.push_back({static_cast<float>(std::min(a, b)), static_cast<float>(std::max(a, b)), transmittance});
    };
    for (std::size_t border = 1; border < borders.size(); ++border) {
        if (!(borders[border - 1] < borders[border]))
            continue;
        // Gauss's two points: exact for the square that linear interpolation makes along a cut. Decoded sRGB bends it
        // upwards, so that the middle alone would be up to 1 % too dark for every image.
        constexpr double gauss = 0.21132486540518713;
        const double a = borders[border - 1], b = borders[border];
        const Rgb next = 0.5f * (transmittance_at(std::lerp(a, b, gauss)) + transmittance_at(std::lerp(b, a, gauss)));
        if (next == transmittance)
            continue;
        append_up_to(borders[border - 1]);
        first = borders[border - 1];
        transmittance = next;
    }
    append_up_to(1.0);
}

namespace {
/// Dims consecutive intervals by the partial shadows, which are sorted by their near ends.
class Dimmer {
public:
    explicit Dimmer(std::span<const PartialShadow> partial) : partial_(partial) {}

    /// Appends [near, far], cut at the ends of the shadows that overlap it. Calls must ascend.
    void append(float near_m, float far_m, std::vector<LitInterval>& lit) {
        const std::size_t first_of_call = lit.size();
        while (near_m < far_m) {
            for (; next_ < partial_.size() && partial_[next_].near_m <= near_m; ++next_)
                active_.push_back(partial_[next_]);
            std::erase_if(active_, [&](const PartialShadow& shadow) { return shadow.far_m <= near_m; });
            float end_m = next_ < partial_.size() ? std::min(far_m, partial_[next_].near_m) : far_m;
            Rgb transmittance(1.0f);
            for (const PartialShadow& shadow : active_) {
                end_m = std::min(end_m, shadow.far_m);
                transmittance *= shadow.transmittance;
            }
            if (lit.size() > first_of_call && lit.back().far_m == near_m && lit.back().transmittance == transmittance)
                lit.back().far_m = end_m;
            else if (transmittance != Rgb(0.0f))
                lit.push_back({near_m, end_m, transmittance});
            near_m = end_m;
        }
    }

private:
    std::span<const PartialShadow> partial_;
    std::size_t next_ = 0;
    std::vector<PartialShadow> active_; ///< In the order of partial_, which products keep.
};
} // namespace

void append_lit_intervals(const ShadowUnion& opaque, std::vector<PartialShadow>& partial,
                          std::vector<LitInterval>& lit) {
    if (opaque.is_complete())
        return;
    // Triangle and place break ties: the order of products must not depend on the order of traversal.
    std::ranges::sort(partial, [](const PartialShadow& a, const PartialShadow& b) {
        return std::tie(a.near_m, a.far_m, a.transmittance.x, a.transmittance.y, a.transmittance.z) <
               std::tie(b.near_m, b.far_m, b.transmittance.x, b.transmittance.y, b.transmittance.z);
    });
    float from_m = opaque.open_near_m();
    Dimmer dimmer(partial);
    const auto append = [&](float to_m) {
        if (!(from_m < to_m))
            return;
        if (partial.empty())
            lit.push_back({.near_m = from_m, .far_m = to_m});
        else
            dimmer.append(from_m, to_m, lit);
    };
    for (const ShadowInterval& shadow : opaque.intervals()) {
        append(shadow.near_m);
        from_m = shadow.far_m;
    }
    append(opaque.open_far_m());
}
} // namespace tyndall::light_shafts
