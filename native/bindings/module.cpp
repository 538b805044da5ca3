// SPDX-License-Identifier: GPL-3.0-or-later
// The module tyndall._native: converts and nothing else. Native exceptions become Python's here, once.
#include "bindings/bind.hpp"
#include "core/errors.hpp"

namespace tyndall::bindings {
PYBIND11_MODULE(_native, native) {
    native.doc() = "Tyndall's native core. Use the classes of the tyndall package, which document units and shapes.";
    py::register_exception<InvalidInput>(native, "InvalidInput", PyExc_ValueError);
    py::register_exception<IoError>(native, "IoError", PyExc_OSError);
    py::register_exception<Cancelled>(native, "Cancelled", PyExc_Exception);
    bind_core(native);
    bind_textures(native);
    bind_materials(native);
    bind_displacement(native);
    bind_occluder_edits(native);
    bind_light_textures(native);
    bind_volumes(native);
    bind_sky(native);
    bind_scene(native);
    bind_transfer_functions(native);
    bind_heterogeneity(native);
    bind_render(native);
    bind_light_map_fit(native);
    bind_voxel_dag(native);
}
} // namespace tyndall::bindings
