// SPDX-License-Identifier: GPL-3.0-or-later
// A shape made of opaque cells, boxes along the axes of its own space: what a scene asks of voxels, whoever keeps them.
#pragma once
#include "core/progress.hpp"
#include "scene/camera.hpp"
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tyndall {
/// Where a ray meets the first cell on its way.
struct CellHit {
    float distance_m = std::numeric_limits<float>::infinity(); ///< In lengths of the ray's direction.
    std::uint64_t cell = 0; ///< The shape's own number of the cell, or cube, and of the face that is met; below 2^63.
    vec2 on_face{0.0f};     ///< Along the face's two edges, [0, 1].
    vec3 normal{0, 0, 1};   ///< Unit, out of that face.
    [[nodiscard]] bool is_hit() const { return distance_m < std::numeric_limits<float>::infinity(); }
};

/// What a cell looks like.
struct CellLook {
    Rgb color{1.0f};   ///< Linear: the diffuse colour of a material that does not read it is multiplied by it.
    vec3 normal{0.0f}; ///< For shading, of length 1, in the shape's space; 0: that of the face.
    std::array<float, 4> channels{}; ///< [0, 1], by CellShape::channel_names().
};

/// A face of a cell: `corner + u * first_edge + v * second_edge`.
struct CellFace {
    vec3 corner, first_edge, second_edge;
};

/// Follows a shape's boxes from the whole down to its cells.
class CellVisitor {
public:
    virtual ~CellVisitor() = default;
    /// Whether to go on into a box, which has cells.
    virtual bool enters(const Bounds3& box) = 0;
    virtual void meet(const Bounds3& cell) = 0;
};

/// Immutable; safe from any thread. Neighbouring cells have the same floats where they touch: nothing leaks between them.
class CellShape {
public:
    CellShape() = default;
    CellShape(const CellShape&) = delete;
    CellShape& operator=(const CellShape&) = delete;
    virtual ~CellShape() = default;

    [[nodiscard]] virtual const std::string& name() const = 0; ///< For reports.
    [[nodiscard]] virtual std::uint64_t cell_count() const = 0;
    /// Around all cells; empty: there are none.
    [[nodiscard]] virtual const Bounds3& bounds() const = 0;
    /// In the shape's own space, within [near_m, far_m); the direction may have any length. A ray that begins in a cell
    /// meets it there, on the face that looks against it most.
    [[nodiscard]] virtual CellHit closest_hit(const Ray& ray) const = 0;
    /// Of up to 16 rays that go much the same way, each with the detail that it wants, or all with every cell where there
    /// are no details. Shapes without levels know every cell only.
    virtual void closest_hits(std::span<const Ray> rays, std::span<const RayDetail> /*details*/,
                              std::span<CellHit> hits) const {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i] = closest_hit(rays[i]);
    }
    /// What rays with less detail than every cell need, once; before it, they meet every cell. Throws Cancelled.
    virtual void prepare_detail(const Progress& /*progress*/) const {}
    /// Of a number that closest_hit() gave.
    [[nodiscard]] virtual CellFace face(std::uint64_t cell) const = 0;
    virtual void visit(CellVisitor& visitor) const = 0;
    /// The cell of a number that closest_hit() gave.
    [[nodiscard]] virtual Bounds3 box(std::uint64_t cell) const = 0;
    /// Whether that number is of a cube of cells.
    [[nodiscard]] virtual bool is_cube(std::uint64_t /*cell*/) const { return false; }
    [[nodiscard]] virtual CellLook look(std::uint64_t cell) const = 0;
    /// Faces that no other cell covers, as closest_hit() numbers them, of cells that look as wanted; nothing where there
    /// are more than `most`, or they would have to be looked for among too many cells. Throws Cancelled.
    [[nodiscard]] virtual std::optional<std::vector<std::uint64_t>>
    open_faces(const std::function<bool(const CellLook&)>& is_wanted, std::size_t most,
               const Progress& progress) const = 0;
    /// Of what materials may read of cells, beside the colour; 4 at most.
    [[nodiscard]] virtual std::span<const std::string> channel_names() const = 0;
    /// Some cell has a normal of its own.
    [[nodiscard]] virtual bool has_normals() const = 0;
    /// Whether closest_hit() finds anything.
    [[nodiscard]] virtual bool is_occluded(const Ray& ray) const = 0;
};
} // namespace tyndall
