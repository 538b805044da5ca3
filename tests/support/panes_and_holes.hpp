// SPDX-License-Identifier: GPL-3.0-or-later
// What rays may pass: meshes and materials without an instance.
#pragma once
#include "support/scenes.hpp"

namespace tyndall::support {
/// A cube, a square, and a square with a hole where its second slot is; slots 0 and 1 are white with a hole, 2 and 3 a
/// coloured pane with a hole.
inline SceneDescription panes_and_holes() {
    Material pane{.name = "pane"};
    pane.constant = {.diffuse_albedo = Rgb(0.1f), .transparent = Rgb(0.5f, 0.7f, 0.9f), .emission = Rgb(0.0f)};
    Material nothing{.name = "nothing"};
    nothing.has_surface = false;
    SceneDescription description;
    description.meshes = {cube(), square()};
    MeshArrays with_hole = arrays_of(*square());
    with_hole.material_slots = {0, 1};
    description.meshes.push_back(mesh_of(with_hole));
    description.materials = {{.name = "white"}, pane, nothing};
    description.slot_materials = {0, 2, 1, 2};
    return description;
}
} // namespace tyndall::support
