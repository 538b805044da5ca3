// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "scene/occluder_edit.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static HoleNoise make_noise(float scale_m, std::uint32_t octaves, float persistence, float probability, float sway,
                            float turn_rad, std::uint32_t seed) {
    return {.scale_m = scale_m,
            .octaves = octaves,
            .persistence = persistence,
            .probability = probability,
            .sway = sway,
            .turn_rad = turn_rad,
            .seed = seed};
}

static std::shared_ptr<LightMask> make_mask(std::string name, const py::array& values, float size_m) {
    auto mask = std::make_shared<LightMask>();
    mask->name = std::move(name);
    mask->values = to_vector<float, float>(values, {-1, -1}, "values");
    mask->height = static_cast<std::uint32_t>(values.shape(0));
    mask->width = static_cast<std::uint32_t>(values.shape(1));
    mask->size_m = size_m;
    return mask;
}

static OccluderEdit make_edit(std::string name, int kind, int shape, float size_m, float distance_m,
                              const HoleNoise& noise, bool affects_surfaces, const std::optional<py::array>& objects,
                              const std::optional<std::shared_ptr<LightMask>>& mask) {
    OccluderEdit edit{.name = std::move(name),
                      .kind = static_cast<EditKind>(kind),
                      .shape = static_cast<KernelShape>(shape),
                      .size_m = size_m,
                      .distance_m = distance_m,
                      .noise = noise,
                      .affects_surfaces = affects_surfaces,
                      .affects_all = !objects,
                      .objects = {},
                      .mask = mask.value_or(nullptr)};
    if (objects)
        edit.objects = to_vector<std::uint32_t, std::uint32_t>(*objects, {-1}, "objects");
    require_usable(edit);
    return edit;
}

void bind_occluder_edits(py::module_& native) {
    py::class_<HoleNoise>(native, "HoleNoise")
        .def(py::init(&make_noise), "scale_m"_a, "octaves"_a, "persistence"_a, "probability"_a, "sway"_a, "turn_rad"_a,
             "seed"_a);
    py::class_<LightMask, std::shared_ptr<LightMask>>(native, "LightMask")
        .def(py::init(&make_mask), "name"_a, "values"_a, "size_m"_a,
             "values: float32 (height, width), rows bottom to top; keeps a copy.");
    py::class_<OccluderEdit>(native, "OccluderEdit")
        .def(py::init(&make_edit), "name"_a, "kind"_a, "shape"_a, "size_m"_a, "distance_m"_a, "noise"_a,
             "affects_surfaces"_a, "objects"_a, "mask"_a,
             "objects: uint32 (n,), rising, into the scene's object_names, or None: all. InvalidInput names what is "
             "out of "
             "its range.");
}
} // namespace tyndall::bindings
