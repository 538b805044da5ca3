// SPDX-License-Identifier: GPL-3.0-or-later
// One function per room that adds its part to the module.
#pragma once
#include "scene/media.hpp"
#include "scene/scene.hpp"
#include <pybind11/pybind11.h>

namespace tyndall::bindings {
namespace py = pybind11;

/// A scene with its media: found once, however often it is rendered.
struct SceneWithMedia {
    Scene scene;
    Media media;
    SceneWithMedia(SceneDescription description, const Progress& progress)
        : scene(std::move(description), progress), media(scene, progress) {}
};

void bind_core(py::module_& native);
void bind_materials(py::module_& native);
void bind_occluder_edits(py::module_& native);
void bind_light_textures(py::module_& native);
void bind_volumes(py::module_& native);
void bind_scene(py::module_& native);
void bind_transfer_functions(py::module_& native);
void bind_heterogeneity(py::module_& native);
void bind_render(py::module_& native);
void bind_light_map_fit(py::module_& native);
} // namespace tyndall::bindings
