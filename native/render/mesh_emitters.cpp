// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/mesh_emitters.hpp"
#include "core/parallel.hpp"
#include "core/sobol.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <map>
#include <numbers>

namespace tyndall::render {
/// Share of what seems mean for its material that a triangle is counted with at least.
static constexpr float least_share = 0.02f;
/// More are one: each is asked for every ray.
static constexpr std::size_t most_boxes = 16;
/// The back of a closed mesh is drawn, too: it may be a dome around the scene.
static constexpr float back_of_closed = 0.05f;

static Hit hit_at(const EmissiveTriangle& triangle, vec2 barycentrics, float distance_m) {
    Hit hit;
    hit.distance_m = distance_m;
    hit.instance = triangle.instance;
    hit.triangle = triangle.triangle;
    hit.barycentrics = barycentrics;
    hit.geometric_normal = triangle.normal;
    return hit;
}

Rgb MeshEmitters::radiance(const Scene& scene, const Ray& ray, const Hit& hit, RayKind kind) {
    if (const Material& material = scene.material(hit.instance, hit.triangle); material.is_constant())
        return constant_emission(material);
    return scene.closures({.ray = ray, .kind = kind, .is_of_light = true}, scene.shading_point(ray, hit), hit).emission;
}

/// How far from dark it is: what glows below 0 takes light away, in Cycles, too.
static float size_of(const Rgb& radiance) { return average(glm::abs(radiance)); }

/// Mean of some places, seen from both sides.
static float mean_radiance(const Scene& scene, const EmissiveTriangle& triangle, std::uint32_t place_count) {
    float sum = 0.0f;
    for (std::uint32_t place = 0; place < place_count; ++place) {
        const vec2 u = sobol_point(place, hash(triangle.instance, triangle.triangle));
        const float root = std::sqrt(u.x);
        const vec2 barycentrics(root * (1.0f - u.y), root * u.y);
        const vec3 position = (1.0f - barycentrics.x - barycentrics.y) * triangle.corners[0] +
                              barycentrics.x * triangle.corners[1] + barycentrics.y * triangle.corners[2];
        const vec3 side = place % 2 == 0 ? triangle.normal : -triangle.normal;
        const Ray ray{.origin = position + side, .direction = -side};
        sum += size_of(MeshEmitters::radiance(scene, ray, hit_at(triangle, barycentrics, 1.0f)));
    }
    return sum / static_cast<float>(place_count);
}

MeshEmitters::MeshEmitters(const Scene& scene) {
    const SceneDescription& description = scene.description();
    std::vector<const Material*> materials;
    first_of_instance_.assign(description.instances.size(), LightTree::none);
    std::vector<std::uint8_t> glows(description.materials.size());
    for (std::size_t index = 0; index < glows.size(); ++index)
        glows[index] = description.materials[index].has_surface && !glows_nowhere(description.materials[index]) ? 1 : 0;
    if (std::ranges::none_of(glows, [](std::uint8_t value) { return value != 0; }))
        return;
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        const Instance& instance = description.instances[index];
        bool has_light = false;
        for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot)
            has_light |= glows[description.slot_materials[instance.first_slot_material + slot]] != 0;
        if (!has_light || (instance.lights_surfaces().are_none() && !instance.lights_media))
            continue;
        const TriangleMesh& whole = *description.meshes[instance.mesh_index];
        const SharedMeshArrays& mesh = whole.arrays();
        const bool is_closed = whole.is_closed();
        first_of_instance_[index] = static_cast<std::uint32_t>(index_of_triangle_.size());
        const float sign = glm::determinant(glm::dmat3(mat3(instance.world_from_object))) < 0.0 ? -1.0f : 1.0f;
        double volume = 0.0;
        const std::size_t first = triangles_.size();
        for (std::uint32_t number = 0; number < mesh.triangles.size(); ++number) {
            index_of_triangle_.push_back(LightTree::none);
            const Material& material = scene.material(index, number);
            const bool is_lit = glows[static_cast<std::size_t>(&material - description.materials.data())] != 0;
            EmissiveTriangle triangle{.instance = index,
                                      .triangle = number,
                                      .corners = {},
                                      .normal = {},
                                      .area_m2 = 0.0f,
                                      .radiance = 0.0f,
                                      .is_constant = material.is_constant(),
                                      .back = is_closed ? back_of_closed : 1.0f};
            for (int corner = 0; corner < 3; ++corner)
                triangle.corners[static_cast<std::size_t>(corner)] =
                    vec3(instance.world_from_object * vec4(mesh.positions[mesh.triangles[number][corner]], 1.0f));
            const auto& [a, b, c] = triangle.corners;
            const vec3 cross = sign * glm::cross(b - a, c - a);
            volume += glm::dot(dvec3(a), dvec3(cross)); // six times that of the solid, where it is one
            triangle.area_m2 = 0.5f * glm::length(cross);
            if (!is_lit || !(triangle.area_m2 > 0.0f))
                continue;
            triangle.normal = cross / (2.0f * triangle.area_m2);
            index_of_triangle_.back() = static_cast<std::uint32_t>(triangles_.size());
            triangles_.push_back(triangle);
            materials.push_back(&material);
        }
        if (volume < 0.0 && is_closed) // its normals look inwards: its back is what shines
            for (std::size_t triangle = first; triangle < triangles_.size(); ++triangle)
                triangles_[triangle].back = 1.0f;
    }
    for (std::uint32_t number = 0; number < description.placed_shapes.size(); ++number) {
        const PlacedShape& placed = description.placed_shapes[number];
        if (glows[placed.material_index] != 0 && (!placed.lights_surfaces().are_none() || placed.lights_media))
            met_alone_.push_back(static_cast<std::uint32_t>(description.instances.size()) + number);
    }
    find_boxes(description);
    struct Sum {
        float radiance_m2 = 0.0f, area_m2 = 0.0f;
    };
    std::map<const Material*, Sum> sums;
    const auto place_count =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(65536 / (triangles_.size() + 1), 2, 64));
    parallel_for(triangles_.size(), Progress{}, [&](std::size_t index) {
        EmissiveTriangle& triangle = triangles_[index];
        triangle.radiance = triangle.is_constant ? size_of(constant_emission(*materials[index]))
                                                 : mean_radiance(scene, triangle, place_count);
    });
    for (std::size_t index = 0; index < triangles_.size(); ++index) {
        Sum& sum = sums[materials[index]];
        sum.radiance_m2 += triangles_[index].radiance * triangles_[index].area_m2;
        sum.area_m2 += triangles_[index].area_m2;
    }
    for (std::size_t index = 0; index < triangles_.size(); ++index)
        if (const auto& [radiance_m2, area_m2] = sums[materials[index]]; !triangles_[index].is_constant)
            triangles_[index].radiance =
                std::max({triangles_[index].radiance, least_share * radiance_m2 / area_m2, 1e-6f});
}

std::vector<std::uint32_t> MeshEmitters::instances() const {
    std::vector<std::uint32_t> found;
    for (const EmissiveTriangle& triangle : triangles_)
        if (found.empty() || found.back() != triangle.instance)
            found.push_back(triangle.instance);
    found.insert(found.end(), met_alone_.begin(), met_alone_.end());
    return found;
}

void MeshEmitters::find_boxes(const SceneDescription& scene) {
    std::uint32_t instance = ~0u;
    const auto box_of = [&](std::uint32_t next) -> Bounds3& {
        if (boxes_.empty() || (next != instance && boxes_.size() < most_boxes))
            boxes_.emplace_back();
        instance = next;
        return boxes_.back();
    };
    for (const EmissiveTriangle& triangle : triangles_)
        for (const vec3& corner : triangle.corners)
            box_of(triangle.instance).grow(corner);
    for (const std::uint32_t shape : met_alone_)
        box_of(shape).grow(tyndall::bounds_of(scene, scene.placed_shapes[shape - scene.instances.size()]));
    for (Bounds3& box : boxes_) { // with what rounding may add
        const vec3 margin = 1e-5f * (glm::abs(box.min) + glm::abs(box.max)) + 1e-3f * (box.max - box.min) + 1e-6f;
        box.min -= margin, box.max += margin;
    }
}

bool MeshEmitters::may_meet(const Ray& ray) const {
    return std::ranges::any_of(boxes_, [&](const Bounds3& box) {
        float near_m = 0.0f, far_m = ray.far_m;
        for (int axis = 0; axis < 3; ++axis) {
            const float low_m = box.min[axis] - ray.origin[axis], high_m = box.max[axis] - ray.origin[axis];
            if (ray.direction[axis] == 0.0f) {
                if (low_m > 0.0f || high_m < 0.0f)
                    return false;
                continue;
            }
            const float a = low_m / ray.direction[axis], b = high_m / ray.direction[axis];
            near_m = std::max(near_m, std::min(a, b));
            far_m = std::min(far_m, std::max(a, b));
        }
        return near_m <= far_m;
    });
}

LightBounds MeshEmitters::bounds_of(const EmissiveTriangle& triangle) {
    LightBounds bounds;
    for (const vec3& corner : triangle.corners)
        bounds.box.grow(corner);
    bounds.axis = triangle.normal;
    bounds.reach_rad = 0.5f * std::numbers::pi_v<float>;
    bounds.power = triangle.radiance * triangle.area_m2;
    bounds.back = triangle.back;
    return bounds;
}

std::uint32_t MeshEmitters::index_of(const Hit& hit) const {
    if (hit.instance >= first_of_instance_.size() || first_of_instance_[hit.instance] == LightTree::none)
        return LightTree::none;
    return index_of_triangle_[first_of_instance_[hit.instance] + hit.triangle];
}
} // namespace tyndall::render
