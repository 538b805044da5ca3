// SPDX-License-Identifier: GPL-3.0-or-later
// Media along a ray, from every crossing of the ray with the media's boundaries.
// Based on: the winding number of closed curves; Cycles' volume stack for the meaning of overlaps.
// Differs:  Cycles shoots an extra ray to learn which media hold the camera, and forgets an object that is entered
//           twice. Here one query gives all crossings to infinity; a closed mesh ends outside, which tells the start.
// Bound:    an axis-aligned box costs three slabs and no query; other meshes one Embree query for all of them.
#include "scene/media.hpp"
#include "scene/box_transmittance.hpp"
#include "scene/medium_crossings.hpp"
#include "scene/medium_steps.hpp"
#include "volume/phase_function.hpp"
#include <algorithm>

namespace tyndall {
void MediumSet::insert(std::uint16_t medium) {
    if (count == capacity)
        return;
    std::size_t place = count++;
    for (; place > 0 && media[place - 1] > medium; --place)
        media[place] = media[place - 1];
    media[place] = medium;
}

BoxInterval clip_to_box(const Bounds3& box, const vec3& origin, const vec3& direction) {
    BoxInterval inside{-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0.0f) { // the slab's quotients would be NaN on its face
            if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis])
                return {1.0f, -1.0f};
            continue;
        }
        const float a = (box.min[axis] - origin[axis]) / direction[axis];
        const float b = (box.max[axis] - origin[axis]) / direction[axis];
        inside.near_m = std::max(inside.near_m, std::min(a, b));
        inside.far_m = std::min(inside.far_m, std::max(a, b));
    }
    return inside;
}

struct Media::Boundaries {
    std::vector<MediumBoundary> all;
    Bounds3 bounds;
    std::int32_t world_medium = -1;
    std::vector<Rgb> sigma_t_per_m, sigma_s_per_m; ///< Per medium of the scene.
    std::vector<std::uint32_t> boxes;              ///< Into all.
    std::unique_ptr<const MediumCrossings> meshes; ///< Of the boundaries that are not boxes; null without one.
    /// By who sees it, see emits(): per medium of the scene.
    std::array<std::vector<Rgb>, 2> emission_w_per_m3_sr;
    std::array<bool, 2> emits{}; ///< Some of these do.
    GridMedia grids;

    void find_emission(const SceneDescription& description);

    /// The boundary of all there is, if that is a box: most fog.
    [[nodiscard]] const MediumBoundary* only_box() const {
        return all.size() == 1 && all[0].is_box && world_medium < 0 ? &all[0] : nullptr;
    }

    /// Of a boundary that a ray from there leaves. An open one tells by what is above, as in Cycles: a sheet whose back
    /// is seen from afar, a picture on a wall, would else fill all the way to it.
    [[nodiscard]] bool starts_inside(std::uint32_t boundary, const vec3& origin) const {
        if (all[boundary].is_closed)
            return true;
        thread_local std::vector<MediumCrossing> above;
        above.clear();
        meshes->append(origin, {0.0f, 0.0f, 1.0f}, above);
        std::int32_t winding = 0;
        for (const MediumCrossing& crossing : above)
            winding += crossing.boundary == boundary ? crossing.winding_step : 0;
        return winding < 0;
    }
};

static bool acts(const Medium& medium) {
    return medium.sigma_t_per_m() != Rgb(0.0f) || medium.emission_w_per_m3_sr != Rgb(0.0f);
}

Media::Media(const Scene& scene, const Progress& progress) : scene_(scene) {
    auto boundaries = std::make_unique<Boundaries>();
    const SceneDescription& description = scene.description();
    for (const Medium& medium : description.media) {
        boundaries->sigma_t_per_m.push_back(medium.sigma_t_per_m());
        boundaries->sigma_s_per_m.push_back(medium.sigma_s_per_m());
    }
    if (description.world_medium_index >= 0 &&
        acts(description.media[static_cast<std::size_t>(description.world_medium_index)]))
        boundaries->world_medium = description.world_medium_index;
    boundaries->all = find_medium_boundaries(
        description, [&](std::uint16_t medium) { return acts(description.media[medium]); }, progress);
    bool has_meshes = false;
    for (std::uint32_t index = 0; index < boundaries->all.size(); ++index) {
        const MediumBoundary& boundary = boundaries->all[index];
        const mat4& world_from_object = description.instances[boundary.instance].world_from_object;
        for (std::size_t corner = 0; corner < 8; ++corner)
            boundaries->bounds.grow(vec3(world_from_object * vec4(boundary.object_bounds.corner(corner), 1.0f)));
        if (boundary.is_box)
            boundaries->boxes.push_back(index);
        has_meshes |= !boundary.is_box;
    }
    if (has_meshes)
        boundaries->meshes = std::make_unique<const MediumCrossings>(scene, boundaries->all, progress);
    boundaries->grids = GridMedia(description);
    boundaries->find_emission(description);
    for (const PlacedGrid& grid : boundaries->grids.all())
        boundaries->bounds.grow(grid.bounds);
    boundaries_ = std::move(boundaries);
}
Media::~Media() = default;

void Media::Boundaries::find_emission(const SceneDescription& description) {
    std::vector<std::uint8_t> lights_surfaces(description.media.size());
    if (world_medium >= 0)
        lights_surfaces[static_cast<std::size_t>(world_medium)] = 1;
    for (const VolumeInstance& volume : description.volumes)
        lights_surfaces[volume.medium_index] = 1;
    for (const MediumBoundary& boundary : all)
        if (description.instances[boundary.instance].is_bounce_visible)
            lights_surfaces[boundary.medium] = 1;
    for (std::size_t medium = 0; medium < description.media.size(); ++medium) {
        const Rgb& emission = description.media[medium].emission_w_per_m3_sr;
        emission_w_per_m3_sr[0].push_back(emission);
        emission_w_per_m3_sr[1].push_back(lights_surfaces[medium] != 0 ? emission : Rgb(0.0f));
    }
    for (std::size_t by = 0; by < emits.size(); ++by)
        emits[by] =
            std::ranges::any_of(emission_w_per_m3_sr[by], [](const Rgb& emission) { return emission != Rgb(0.0f); });
}

bool Media::is_empty() const { return boundaries_->all.empty() && !fills_world() && grids().is_empty(); }
bool Media::emits(GlowSeenBy by) const { return boundaries_->emits[static_cast<std::size_t>(by)]; }
Bounds3 Media::bounds() const { return boundaries_->bounds; }
bool Media::fills_world() const { return boundaries_->world_medium >= 0; }
std::int32_t Media::world_medium_index() const { return boundaries_->world_medium; }
const GridMedia& Media::grids() const { return boundaries_->grids; }
std::span<const MediumBoundary> Media::boundaries() const { return boundaries_->all; }

/// Of the ray's line, not of its range.
static BoxInterval inside_box(const MediumBoundary& boundary, const Ray& ray) {
    return clip_to_box(boundary.object_bounds, vec3(boundary.object_from_world * vec4(ray.origin, 1.0f)),
                       vec3(boundary.object_from_world * vec4(ray.direction, 0.0f)));
}

/// Of the ray; near >= far where it has none.
static BoxInterval part_in_box(const MediumBoundary& boundary, const Ray& ray) {
    const BoxInterval inside = inside_box(boundary, ray);
    return {std::max(inside.near_m, ray.near_m), std::min(inside.far_m, ray.far_m)};
}

/// Walks the sorted crossings with one winding number per boundary, and emits a segment wherever the set changes.
/// `starts_inside` tells of a boundary that the ray leaves more often than it enters it whether the ray begins there.
template <typename StartsInside>
static void sweep(std::vector<MediumCrossing>& crossings, std::span<const MediumBoundary> boundaries,
                  std::int32_t world_medium, const Ray& ray, const StartsInside& starts_inside,
                  std::vector<MediumSegment>& segments) {
    std::stable_sort(crossings.begin(), crossings.end(),
                     [](const MediumCrossing& a, const MediumCrossing& b) { return a.distance_m < b.distance_m; });
    struct Winding {
        std::uint32_t boundary;
        std::int32_t number;
    };
    thread_local std::vector<Winding> windings;
    windings.clear();
    const auto winding_of = [&](std::uint32_t boundary) -> Winding& {
        for (Winding& winding : windings)
            if (winding.boundary == boundary)
                return winding;
        return windings.emplace_back(Winding{boundary, 0});
    };
    for (const MediumCrossing& crossing : crossings)
        winding_of(crossing.boundary).number -= crossing.winding_step;
    for (Winding& winding : windings) // a closed mesh ends at 0; an open one that faces the ray starts there
        if (winding.number < 0 || (winding.number > 0 && !starts_inside(winding.boundary)))
            winding.number = 0;

    float from_m = ray.near_m;
    const auto emit_until = [&](float to_m) {
        to_m = std::min(to_m, ray.far_m);
        if (!(to_m > from_m))
            return;
        MediumSet set;
        if (world_medium >= 0)
            set.insert(static_cast<std::uint16_t>(world_medium));
        for (const Winding& winding : windings)
            if (winding.number > 0)
                set.insert(boundaries[winding.boundary].medium);
        if (!set.is_empty()) {
            if (!segments.empty() && segments.back().far_m == from_m && segments.back().set == set)
                segments.back().far_m = to_m;
            else
                segments.push_back({from_m, to_m, set});
        }
        from_m = to_m;
    };
    for (const MediumCrossing& crossing : crossings) {
        emit_until(crossing.distance_m);
        winding_of(crossing.boundary).number += crossing.winding_step;
    }
    emit_until(ray.far_m);
}

void Media::segments(const Ray& ray, std::vector<MediumSegment>& segments) const {
    if (grids().is_empty()) {
        homogeneous_segments(ray, segments);
        return;
    }
    thread_local std::vector<MediumSegment> homogeneous;
    thread_local std::vector<LinePart> dense;
    homogeneous.clear(), dense.clear();
    homogeneous_segments(ray, homogeneous);
    grids().append_dense_parts(ray, dense);
    append_union(homogeneous, dense, segments);
}

void Media::homogeneous_segments(const Ray& ray, std::vector<MediumSegment>& segments) const {
    const Boundaries& scene = *boundaries_;
    if ((scene.all.empty() && !fills_world()) || !(ray.near_m < ray.far_m))
        return;
    if (scene.all.empty()) {
        segments.push_back({ray.near_m, ray.far_m, {}});
        segments.back().set.insert(static_cast<std::uint16_t>(scene.world_medium));
        return;
    }
    if (const MediumBoundary* box = scene.only_box()) {
        const auto [near_m, far_m] = part_in_box(*box, ray);
        if (near_m < far_m) {
            segments.push_back({near_m, far_m, {}});
            segments.back().set.insert(box->medium);
        }
        return;
    }
    thread_local std::vector<MediumCrossing> crossings;
    crossings.clear();
    for (const std::uint32_t box : scene.boxes)
        if (const BoxInterval inside = inside_box(scene.all[box], ray);
            inside.near_m < inside.far_m && inside.far_m > ray.near_m) {
            crossings.push_back({inside.near_m, box, 1});
            crossings.push_back({inside.far_m, box, -1});
        }
    if (scene.meshes)
        scene.meshes->append(ray.origin, ray.direction, crossings);
    // A segment may only join one of the same ray.
    thread_local std::vector<MediumSegment> own;
    own.clear();
    sweep(
        crossings, scene.all, scene.world_medium, ray,
        [&](std::uint32_t boundary) { return scene.starts_inside(boundary, ray.origin); }, own);
    segments.insert(segments.end(), own.begin(), own.end());
}

Rgb Media::transmittance(const Ray& ray) const {
    const Rgb passing = homogeneous_transmittance(ray);
    return grids().is_empty() || passing == Rgb(0.0f) ? passing : passing * glm::exp(-grids().optical_depth(ray));
}

Rgb Media::homogeneous_depth(const Ray& ray) const {
    if (const MediumBoundary* box = boundaries_->only_box()) {
        const auto [near_m, far_m] = part_in_box(*box, ray);
        return near_m < far_m ? boundaries_->sigma_t_per_m[box->medium] * (far_m - near_m) : Rgb(0.0f);
    }
    thread_local std::vector<MediumSegment> along;
    along.clear();
    homogeneous_segments(ray, along);
    Rgb optical_depth(0.0f);
    for (const MediumSegment& segment : along) {
        const Rgb sigma_t = sigma_t_per_m(segment.set);
        for (int channel = 0; channel < 3; ++channel) // 0 * infinity is not the depth of an endless clear segment
            if (sigma_t[channel] > 0.0f)
                optical_depth[channel] += sigma_t[channel] * (segment.far_m - segment.near_m);
    }
    return optical_depth;
}

void Media::attenuate(std::span<const Ray> rays, std::span<Rgb> passing) const {
    if (const MediumBoundary* box = boundaries_->only_box()) {
        tyndall::attenuate({box->object_from_world, box->object_bounds, boundaries_->sigma_t_per_m[box->medium]}, rays,
                           passing);
        for (std::size_t index = 0; !grids().is_empty() && index < rays.size(); ++index)
            if (passing[index] != Rgb(0.0f))
                passing[index] *= glm::exp(-grids().optical_depth(rays[index]));
        return;
    }
    for (std::size_t index = 0; index < rays.size(); ++index)
        if (passing[index] != Rgb(0.0f))
            passing[index] *= transmittance(rays[index]);
}

namespace {
/// Adds up what a ray's stretches emit, near to far.
struct Emitted {
    Rgb radiance{0.0f}, optical_depth{0.0f};
    void add(const Rgb& emitted_per_m, const Rgb& sigma_t, float length_m) {
        for (int channel = 0; channel < 3; ++channel) {
            const float sigma = sigma_t[channel];
            const float transmittance = std::exp(-optical_depth[channel]);
            if (sigma > 0.0f) {
                radiance[channel] += emitted_per_m[channel] * transmittance * -std::expm1(-sigma * length_m) / sigma;
                optical_depth[channel] += sigma * length_m;
            } else if (std::isfinite(length_m)) {
                radiance[channel] += emitted_per_m[channel] * transmittance * length_m;
            }
        }
    }
};
} // namespace

Rgb Media::emission(const Ray& ray, GlowSeenBy by) const {
    if (!emits(by))
        return Rgb(0.0f);
    const std::vector<Rgb>& emission_w_per_m3_sr = boundaries_->emission_w_per_m3_sr[static_cast<std::size_t>(by)];
    thread_local std::vector<MediumSegment> along;
    along.clear();
    segments(ray, along);
    const auto of_set = [&](const MediumSet& set) {
        Rgb emitted_per_m(0.0f);
        for (std::size_t index = 0; index < set.count; ++index)
            emitted_per_m += emission_w_per_m3_sr[set.media[index]];
        return emitted_per_m;
    };
    Emitted emitted;
    if (grids().is_empty()) {
        for (const MediumSegment& segment : along)
            emitted.add(of_set(segment.set), sigma_t_per_m(segment.set), segment.far_m - segment.near_m);
        return emitted.radiance;
    }
    thread_local MediumSteps steps;
    steps.clear();
    append_steps(*this, ray, along, {}, steps);
    for (const MediumStep& step : steps.steps) {
        const MediumSet& set = along[step.segment].set;
        Rgb emitted_per_m = of_set(set), sigma_t = sigma_t_per_m(set);
        for (const GridShare& share : steps.shares_of(step)) {
            const GridField& field = grids().field(share.grid, share.channel);
            emitted_per_m += share.density * field.emission_w_per_m3_sr;
            sigma_t += share.density * field.sigma_t_per_m;
        }
        emitted.add(emitted_per_m, sigma_t, step.far_m - step.near_m);
    }
    return emitted.radiance;
}

Rgb Media::sigma_t_per_m(const MediumSet& set) const {
    Rgb sum(0.0f);
    for (std::size_t index = 0; index < set.count; ++index)
        sum += boundaries_->sigma_t_per_m[set.media[index]];
    return sum;
}

Rgb Media::sigma_s_per_m(const MediumSet& set) const {
    Rgb sum(0.0f);
    for (std::size_t index = 0; index < set.count; ++index)
        sum += boundaries_->sigma_s_per_m[set.media[index]];
    return sum;
}

static void add_scattered(const Medium& medium, float cosine, Rgb& sum) {
    for (const ScatterLobe& lobe : medium.lobes)
        sum += lobe.sigma_s_per_m * draine_per_sr(cosine, lobe.asymmetry_g, lobe.draine_alpha);
}

Rgb Media::scatter_per_m_sr(const MediumSet& set, float cosine) const {
    Rgb sum(0.0f);
    for (std::size_t index = 0; index < set.count; ++index)
        add_scattered(scene_.description().media[set.media[index]], cosine, sum);
    return sum;
}

Rgb Media::scatter_per_m_sr(std::uint16_t medium, float cosine) const {
    Rgb sum(0.0f);
    add_scattered(scene_.description().media[medium], cosine, sum);
    return sum;
}
} // namespace tyndall
