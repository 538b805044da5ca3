// SPDX-License-Identifier: GPL-3.0-or-later
// A shape of cells that asks each of its boxes in turn, and a mesh of the same boxes: each other's truth.
#pragma once
#include "scene/cell_geometry.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <set>

namespace tyndall::support {
/// Cubes of a lattice, by their lowest corners in widths of a cube.
class BoxShape final : public CellShape {
public:
    /// `counted`: what it says of its number of cells, 0: the truth. `normal`: of all cells, 0: none of their own.
    BoxShape(std::vector<glm::ivec3> cells, float width_m, std::uint64_t counted = 0, vec3 normal = vec3(0.0f))
        : cells_(std::move(cells)), width_m_(width_m), counted_(counted), normal_(normal) {
        for (const glm::ivec3& cell : cells_)
            bounds_.grow(box(cell));
    }
    [[nodiscard]] const std::string& name() const override { return name_; }
    [[nodiscard]] std::uint64_t cell_count() const override { return counted_ != 0 ? counted_ : cells_.size(); }
    [[nodiscard]] const Bounds3& bounds() const override { return bounds_; }
    [[nodiscard]] CellHit closest_hit(const Ray& ray) const override {
        CellHit nearest;
        for (std::size_t i = 0; i < cells_.size(); ++i)
            ask(i, ray, nearest);
        return nearest;
    }
    [[nodiscard]] CellFace face(std::uint64_t cell) const override {
        const auto axis = static_cast<int>(cell % 8 / 2);
        const Bounds3 of = box(cells_[cell / 8]);
        CellFace face{.corner = of.min, .first_edge = vec3(0.0f), .second_edge = vec3(0.0f)};
        if (cell % 2 == 1)
            face.corner[axis] = of.max[axis];
        const int first = (axis + 1) % 3, second = (axis + 2) % 3;
        face.first_edge[first] = of.max[first] - of.min[first];
        face.second_edge[second] = of.max[second] - of.min[second];
        return face;
    }
    void visit(CellVisitor& visitor) const override {
        if (cells_.empty() || !visitor.enters(bounds_))
            return;
        for (const glm::ivec3& cell : cells_)
            visitor.meet(box(cell));
    }
    [[nodiscard]] Bounds3 box(std::uint64_t cell) const override { return box(cells_[cell / 8]); }
    [[nodiscard]] CellLook look(std::uint64_t) const override { return {.normal = normal_}; }
    [[nodiscard]] std::optional<std::vector<std::uint64_t>>
    open_faces(const std::function<bool(const CellLook&)>& is_wanted, std::size_t most,
               const Progress& /*progress*/) const override {
        std::vector<std::uint64_t> faces;
        for (std::uint64_t face = 0; face < 6 * cells_.size(); ++face) {
            const std::uint64_t number = face / 6 * 8 + face % 6;
            glm::ivec3 beside = cells_[face / 6];
            beside[static_cast<int>(face % 6 / 2)] += face % 2 == 1 ? 1 : -1;
            if (is_wanted(look(number)) && std::ranges::find(cells_, beside) == cells_.end())
                faces.push_back(number);
        }
        return faces.size() <= most ? std::optional(faces) : std::nullopt;
    }
    [[nodiscard]] std::span<const std::string> channel_names() const override { return {}; }
    [[nodiscard]] bool has_normals() const override { return normal_ != vec3(0.0f); }
    [[nodiscard]] bool is_occluded(const Ray& ray) const override { return closest_hit(ray).is_hit(); }
    [[nodiscard]] Bounds3 box(const glm::ivec3& cell) const {
        Bounds3 result;
        result.grow(width_m_ * vec3(cell));
        result.grow(width_m_ * vec3(cell + 1));
        return result;
    }
    /// 12 triangles per cube, those between two cubes, too.
    [[nodiscard]] std::shared_ptr<const TriangleMesh> mesh() const {
        const std::shared_ptr<const TriangleMesh> one = cube();
        MeshArrays arrays{.name = "boxes"};
        for (const glm::ivec3& cell : cells_) {
            const auto first = static_cast<std::uint32_t>(arrays.positions.size());
            for (std::size_t corner = 0; corner < 8; ++corner)
                arrays.positions.push_back(box(cell).corner(corner));
            for (const uvec3& triangle : one->arrays().triangles)
                arrays.triangles.push_back(first + triangle);
        }
        return mesh_of(std::move(arrays));
    }

private:
    void ask(std::size_t index, const Ray& ray, CellHit& nearest) const {
        const Bounds3 of = box(cells_[index]);
        double from = ray.near_m, end = std::min(ray.far_m, nearest.distance_m);
        int entered = -1;
        for (int axis = 0; axis < 3; ++axis) {
            const double per_m = 1.0 / double{ray.direction[axis]};
            const double a = (double{of.min[axis]} - double{ray.origin[axis]}) * per_m,
                         b = (double{of.max[axis]} - double{ray.origin[axis]}) * per_m;
            if (std::min(a, b) > from)
                from = std::min(a, b), entered = axis;
            end = std::min(end, std::max(a, b));
        }
        if (!(from < end))
            return;
        const vec3 size = glm::abs(ray.direction);
        if (entered < 0)
            entered = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const bool is_upper = ray.direction[entered] < 0.0f;
        nearest.distance_m = static_cast<float>(from);
        nearest.cell = 8 * index + 2 * static_cast<std::size_t>(entered) + (is_upper ? 1 : 0);
        nearest.normal = vec3(0.0f);
        nearest.normal[entered] = is_upper ? 1.0f : -1.0f;
        const vec3 at = ray.origin + static_cast<float>(from) * ray.direction;
        for (int edge = 0; edge < 2; ++edge) {
            const int axis = (entered + 1 + edge) % 3;
            nearest.on_face[edge] = glm::clamp((at[axis] - of.min[axis]) / width_m_, 0.0f, 1.0f);
        }
    }

    std::vector<glm::ivec3> cells_;
    float width_m_;
    std::uint64_t counted_;
    vec3 normal_;
    std::string name_ = "boxes";
    Bounds3 bounds_;
};

/// Different cubes, anywhere in a lattice of `side`^3.
inline std::vector<glm::ivec3> scattered_cells(std::size_t count, int side, std::uint64_t seed) {
    SceneRandom random(seed);
    std::set<std::array<int, 3>> places;
    while (places.size() < count) {
        std::array<int, 3> place;
        for (int& i : place)
            i = static_cast<int>(static_cast<float>(side) * random.uniform());
        places.insert(place);
    }
    std::vector<glm::ivec3> cells;
    for (const auto& [x, y, z] : places)
        cells.emplace_back(x, y, z);
    return cells;
}

/// The boxes as a shape, or as a mesh, wherever they are to stand; all is "boxes".
struct BoxScene {
    std::vector<mat4> places{mat4(1.0f)};
    bool is_camera_visible = true, casts_shadow = true;

    [[nodiscard]] SceneDescription description(const std::shared_ptr<const BoxShape>& boxes, bool as_mesh) const {
        SceneDescription result;
        result.object_names = {"boxes"};
        result.materials = {Material{.name = "white"}};
        result.slot_materials = {0};
        if (as_mesh)
            result.meshes = {boxes->mesh()};
        else
            result.shapes = {std::make_shared<const CellGeometry>(boxes)};
        for (const mat4& place : places)
            if (as_mesh)
                result.instances.push_back(
                    {.world_from_object = place, .is_camera_visible = is_camera_visible, .casts_shadow = casts_shadow});
            else
                result.placed_shapes.push_back(
                    {.world_from_object = place, .is_camera_visible = is_camera_visible, .casts_shadow = casts_shadow});
        return result;
    }
    [[nodiscard]] std::unique_ptr<Scene> scene(const std::shared_ptr<const BoxShape>& boxes, bool as_mesh) const {
        return std::make_unique<Scene>(description(boxes, as_mesh), Progress());
    }
};

/// A turned, a mirrored and a sheared place, apart from each other.
inline std::vector<mat4> various_places() {
    const mat4 turned = glm::rotate(translation({0.2f, -0.1f, 0.3f}), 0.7f, glm::normalize(vec3(1, 2, -1)));
    const mat4 mirrored = glm::scale(translation({3.0f, 0.5f, 0.1f}), vec3(-0.8f, 1.1f, 0.9f));
    mat4 sheared = translation({-2.5f, 0.3f, -0.2f});
    sheared[1] += vec4(0.4f, 0.0f, 0.3f, 0.0f);
    return {turned, mirrored, sheared};
}
} // namespace tyndall::support
