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

Rgb MeshEmitters::radiance(const Scene& scene, const EmissiveTriangle* triangle, const Ray& ray, const Hit& hit,
                           RayKind kind) {
    if (triangle != nullptr && triangle->is_constant)
        return triangle->emission;
    return scene.closures({.ray = ray, .kind = kind, .is_of_light = true}, scene.shading_point(ray, hit), hit).emission;
}

/// How far from dark it is: what glows below 0 takes light away, in Cycles, too.
static float size_of(const Rgb& radiance) { return average(glm::abs(radiance)); }

/// What its material emits there, from a metre away.
static Rgb emission_at(const Scene& scene, const EmissiveTriangle& triangle, vec2 barycentrics, bool from_front) {
    const auto& [a, b, c] = triangle.corners;
    const vec3 position = a + barycentrics.x * (b - a) + barycentrics.y * (c - a);
    const vec3 side = from_front ? triangle.normal : -triangle.normal;
    return MeshEmitters::radiance(scene, nullptr, {.origin = position + side, .direction = -side},
                                  hit_at(triangle, barycentrics, 1.0f));
}

/// Mean of some places, seen from both sides.
static float mean_radiance(const Scene& scene, const EmissiveTriangle& triangle, std::uint32_t place_count) {
    float sum = 0.0f;
    for (std::uint32_t place = 0; place < place_count; ++place) {
        const vec2 u = sobol_point(place, hash(triangle.instance, triangle.triangle));
        const float root = std::sqrt(u.x);
        sum += size_of(emission_at(scene, triangle, {root * (1.0f - u.y), root * u.y}, place % 2 == 0));
    }
    return sum / static_cast<float>(place_count);
}

/// Of an instance or a placed shape.
static bool lights_anything(const auto& placed) { return !placed.lights_surfaces().are_none() || placed.lights_media; }

MeshEmitters::MeshEmitters(const Scene& scene, const Progress& progress) {
    const SceneDescription& description = scene.description();
    first_of_instance_.assign(description.instances.size(), LightTree::none);
    std::vector<std::uint8_t> glows(description.materials.size());
    for (std::size_t index = 0; index < glows.size(); ++index)
        glows[index] = description.materials[index].has_surface && !glows_nowhere(description.materials[index]) ? 1 : 0;
    if (std::ranges::none_of(glows, [](std::uint8_t value) { return value != 0; }))
        return;
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        const Instance& instance = description.instances[index];
        const auto slots =
            std::span(description.slot_materials).subspan(instance.first_slot_material, instance.slot_count);
        if (std::ranges::any_of(slots, [&](std::uint32_t material) { return glows[material] != 0; }) &&
            lights_anything(instance))
            add_mesh(scene, index, glows);
    }
    add_shapes(scene, glows, progress);
    find_boxes(description);
    find_radiances(scene, progress);
}

void MeshEmitters::add_mesh(const Scene& scene, std::uint32_t index, std::span<const std::uint8_t> glows) {
    const SceneDescription& description = scene.description();
    const Instance& instance = description.instances[index];
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
    }
    if (volume < 0.0 && is_closed) // its normals look inwards: its back is what shines
        for (std::size_t triangle = first; triangle < triangles_.size(); ++triangle)
            triangles_[triangle].back = 1.0f;
}

void MeshEmitters::add_shapes(const Scene& scene, std::span<const std::uint8_t> glows, const Progress& progress) {
    const SceneDescription& description = scene.description();
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> alike; // by shape and material
    for (std::uint32_t number = 0; number < description.placed_shapes.size(); ++number) {
        const PlacedShape& placed = description.placed_shapes[number];
        if (glows[placed.material_index] != 0 && lights_anything(placed))
            alike[{placed.shape_index, placed.material_index}].push_back(
                static_cast<std::uint32_t>(description.instances.size()) + number);
    }
    std::size_t room = most_of_cells / 2; // faces
    for (const auto& [of, instances] : alike) {
        const std::size_t most = room / instances.size();
        std::optional<GlowingFaces> faces;
        if (description.shapes[of.first]->cells() != nullptr && most > 0)
            faces = glowing_faces(scene, instances, most, progress);
        if (!faces) {
            met_alone_.insert(met_alone_.end(), instances.begin(), instances.end());
            continue;
        }
        room -= faces->cells.size() * instances.size();
        const auto shared = std::make_shared<const GlowingFaces>(std::move(*faces));
        for (const std::uint32_t instance : instances)
            add_faces(scene, instance, shared);
    }
    std::ranges::sort(met_alone_);
}

void MeshEmitters::add_faces(const Scene& scene, std::uint32_t instance,
                             const std::shared_ptr<const GlowingFaces>& faces) {
    const PlacedShape& placed = *scene.placed_shape(instance);
    const CellShape& cells = *scene.description().shapes[placed.shape_index]->cells();
    faces_of_shape_[instance] = {static_cast<std::uint32_t>(triangles_.size()), faces};
    const mat3 to_scene(placed.world_from_object);
    for (const std::uint64_t cell : faces->cells) {
        const CellFace face = cells.face(cell);
        const vec3 corner(placed.world_from_object * vec4(face.corner, 1.0f)), first = to_scene * face.first_edge,
                                                                               second = to_scene * face.second_edge;
        const Bounds3 box = cells.box(cell);
        vec3 cross = glm::cross(first, second);
        if (glm::dot(cross, corner - vec3(placed.world_from_object * vec4(box.centre(), 1.0f))) < 0.0f)
            cross = -cross;
        EmissiveTriangle half{.instance = instance,
                              .triangle = 0,
                              .cell = cell,
                              .corners = {corner, corner + first, corner + second},
                              .normal = unit_or(cross, vec3(0, 0, 1)),
                              .area_m2 = 0.5f * glm::length(cross),
                              .radiance = 0.0f,
                              .is_constant = faces->follow_looks,
                              .back = 0.0f};
        triangles_.push_back(half);
        half.is_upper = true;
        half.corners = {corner + first + second, corner + second, corner + first};
        triangles_.push_back(half);
    }
}

void MeshEmitters::find_radiances(const Scene& scene, const Progress& progress) {
    struct Sum {
        float radiance_m2 = 0.0f, area_m2 = 0.0f;
    };
    std::map<const Material*, Sum> sums;
    const auto material_of = [&](const EmissiveTriangle& triangle) -> const Material& {
        return scene.material(triangle.instance, triangle.triangle);
    };
    const auto place_count =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(65536 / (triangles_.size() + 1), 2, 64));
    parallel_for(triangles_.size(), progress, [&](std::size_t index) {
        EmissiveTriangle& triangle = triangles_[index];
        if (triangle.is_constant)
            triangle.emission = emission_at(scene, triangle, vec2(1.0f / 3.0f), true);
        triangle.radiance =
            triangle.is_constant ? size_of(triangle.emission) : mean_radiance(scene, triangle, place_count);
    });
    for (const EmissiveTriangle& triangle : triangles_) {
        Sum& sum = sums[&material_of(triangle)];
        sum.radiance_m2 += triangle.radiance * triangle.area_m2;
        sum.area_m2 += triangle.area_m2;
    }
    for (EmissiveTriangle& triangle : triangles_)
        if (const auto& [radiance_m2, area_m2] = sums[&material_of(triangle)]; !triangle.is_constant && area_m2 > 0.0f)
            triangle.radiance = std::max({triangle.radiance, least_share * radiance_m2 / area_m2, 1e-6f});
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
    if (hit.instance < first_of_instance_.size())
        return first_of_instance_[hit.instance] == LightTree::none
                   ? LightTree::none
                   : index_of_triangle_[first_of_instance_[hit.instance] + hit.triangle];
    const auto of_shape = faces_of_shape_.find(hit.instance);
    if (of_shape == faces_of_shape_.end())
        return LightTree::none;
    const auto& [first, faces] = of_shape->second;
    const auto face = std::ranges::lower_bound(faces->cells, hit.cell);
    if (face == faces->cells.end() || *face != hit.cell)
        return LightTree::none;
    const bool is_upper = hit.barycentrics.x + hit.barycentrics.y > 1.0f;
    return first + 2 * static_cast<std::uint32_t>(face - faces->cells.begin()) + (is_upper ? 1u : 0u);
}
} // namespace tyndall::render
