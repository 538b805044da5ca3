// SPDX-License-Identifier: GPL-3.0-or-later
// A shape of cells in Embree: a scene of its own with one user geometry, instanced as a mesh's is.
// Based on: Embree 3's user geometries.
// Differs:  a cell has more bits than a primitive's number: its lower half is primID, its upper half geomID.
// Bound:    what the shape takes for rays; the lanes of a packet that are asked for nearest cells go together.
#pragma once
#include "scene/cell_shape.hpp"
#include "scene/shape_geometry.hpp"
#include <memory>
#include <span>

namespace tyndall {
/// Embree's context of each query that may meet cells, first in it: Embree hands callbacks the pointer to it.
struct CellQuery {
    CellQuery() { rtcInitIntersectContext(&embree); }
    RTCIntersectContext embree;
    /// By RTCRay::id, in the scene's space; empty: rays meet every cell.
    std::span<const RayDetail> details;
    /// By the number of an Embree instance less first_shape: the shape's metres in one of the scene, at least.
    std::span<const float> shape_lengths;
    unsigned int first_shape = 0;
};

class CellGeometry final : public ShapeGeometry {
public:
    /// Throws Error where Embree refuses.
    explicit CellGeometry(std::shared_ptr<const CellShape> shape);
    ~CellGeometry() override;

    [[nodiscard]] const CellShape& shape() const { return *shape_; }
    [[nodiscard]] const std::string& name() const override { return shape_->name(); }
    [[nodiscard]] const Bounds3& bounds() const override { return shape_->bounds(); }
    [[nodiscard]] RTCScene embree_scene() const override { return embree_scene_; }
    [[nodiscard]] const CellShape* cells() const override { return shape_.get(); }

private:
    std::shared_ptr<const CellShape> shape_;
    RTCScene embree_scene_ = nullptr;
};

/// What Embree's hits keep of a cell. A triangle's is its number.
[[nodiscard]] inline std::uint64_t cell_of(unsigned int primitive, unsigned int geometry) {
    return std::uint64_t{geometry} << 32 | primitive;
}
} // namespace tyndall
