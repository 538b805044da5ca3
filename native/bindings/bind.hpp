// SPDX-License-Identifier: GPL-3.0-or-later
// One function per room that adds its part to the module.
#pragma once
#include "scene/media.hpp"
#include "scene/scene.hpp"
#include <pybind11/pybind11.h>

namespace tyndall::bindings {
namespace py = pybind11;

/// A scene with its media: found once, however often it is rendered, and under whatever lights.
struct SceneWithMedia {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const Media> media; ///< Found in a scene of the same geometry, which they hold on to.

    SceneWithMedia(SceneDescription description, const Progress& progress)
        : SceneWithMedia(std::make_shared<const Scene>(std::move(description), progress), progress) {}
    SceneWithMedia(std::shared_ptr<const Scene> made, const Progress& progress) : scene(std::move(made)) {
        struct Found {
            std::shared_ptr<const Scene> in;
            Media media;
        };
        const auto found = std::shared_ptr<const Found>(new Found{scene, Media(*scene, progress)});
        media = {found, &found->media};
    }
    /// The other with some instances elsewhere.
    SceneWithMedia(const SceneWithMedia& other, std::span<const MovedInstance> moved, TreeUpdate update,
                   const Progress& progress)
        : SceneWithMedia(std::make_shared<const Scene>(*other.scene, moved, update, progress), progress) {}
    /// The other's geometry, materials and media.
    SceneWithMedia(const SceneWithMedia& other, std::vector<Light> lights, World world)
        : scene(std::make_shared<const Scene>(*other.scene, std::move(lights), std::move(world))), media(other.media) {}
};

void bind_core(py::module_& native);
void bind_textures(py::module_& native);
void bind_materials(py::module_& native);
void bind_displacement(py::module_& native);
void bind_occluder_edits(py::module_& native);
void bind_light_textures(py::module_& native);
void bind_volumes(py::module_& native);
void bind_scene(py::module_& native);
void bind_sky(py::module_& native);
void bind_transfer_functions(py::module_& native);
void bind_heterogeneity(py::module_& native);
void bind_render(py::module_& native);
void bind_light_map_fit(py::module_& native);
void bind_voxel_dag(py::module_& native);
} // namespace tyndall::bindings
