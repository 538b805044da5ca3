// SPDX-License-Identifier: GPL-3.0-or-later
// What stands in a scene beside meshes, and is instanced in Embree as they are: cells, strands, spheres.
#pragma once
#include "core/math.hpp"
#include <embree3/rtcore.h>
#include <string>

namespace tyndall {
class CellShape; // scene/cell_shape.hpp
class Strands;   // scene/strands.hpp

class ShapeGeometry {
public:
    ShapeGeometry() = default;
    ShapeGeometry(const ShapeGeometry&) = delete;
    ShapeGeometry& operator=(const ShapeGeometry&) = delete;
    virtual ~ShapeGeometry() = default;

    [[nodiscard]] virtual const std::string& name() const = 0; ///< For reports.
    [[nodiscard]] virtual const Bounds3& bounds() const = 0;   ///< Empty: there is nothing of it.
    [[nodiscard]] virtual RTCScene embree_scene() const = 0;   ///< Of one geometry.
    // What it is: one of these.
    [[nodiscard]] virtual const CellShape* cells() const { return nullptr; }
    [[nodiscard]] virtual const Strands* strands() const { return nullptr; }
};
} // namespace tyndall
