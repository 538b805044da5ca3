// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/bind.hpp"
#include "bindings/shared_arrays.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/simd.hpp"
#include "core/statistics.hpp"
#include <pybind11/stl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace tyndall::bindings {
using namespace py::literals;

static py::dict to_dict(const Statistics& statistics) {
    py::list stages, skipped;
    for (const Statistics::Stage& stage : statistics.stages)
        stages.append(py::dict("name"_a = stage.name, "seconds"_a = stage.seconds));
    for (const Statistics::Skipped& entry : statistics.skipped)
        skipped.append(py::dict("what"_a = entry.what, "reason"_a = entry.reason));
    py::dict counts;
    for (const Statistics::Count& count : statistics.counts)
        counts[py::str(count.name)] = count.value;
    return py::dict("stages"_a = stages, "skipped"_a = skipped, "counts"_a = counts, "reports"_a = statistics.reports);
}

static void return_free_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

/// By the name that simd_target_name() has for it.
static std::unique_ptr<ForcedSimdTarget> force_simd_target(const std::string& name) {
    for (const SimdTarget target : available_simd_targets()) {
        auto forced = std::make_unique<ForcedSimdTarget>(target);
        if (simd_target_name() == name)
            return forced;
    }
    throw InvalidInput("this CPU has no " + name);
}

void bind_core(py::module_& native) {
    py::class_<ForcedSimdTarget>(
        native, "ForcedSimdTarget",
        "While it lives, kernels run on \"SSE4\", \"AVX2\" or \"AVX-512\", one at a time; Embree, too, if there "
        "was no scene before. InvalidInput: the CPU lacks it.")
        .def(py::init(&force_simd_target), "name"_a);
    py::class_<Progress>(native, "Progress", "What a long call tells its caller, and how any thread stops it.")
        .def(py::init<>())
        .def("cancel", &Progress::cancel, "Make the call raise Cancelled within 0.25 s.")
        .def("poll", &Progress::poll, "Raise Cancelled after cancel().")
        .def("advance_to", &Progress::advance_to, "fraction"_a, "Raise the share that is done; it never goes back.")
        .def_property_readonly("is_cancelled", &Progress::is_cancelled)
        .def_property_readonly("fraction", &Progress::fraction, "Share of the job that is done, 0 to 1.")
        .def_property("message", &Progress::message, &Progress::set_message, "The stage at work.")
        .def_property_readonly("elapsed_s", &Progress::elapsed_s)
        .def_property_readonly("remaining_s", &Progress::remaining_s, "Negative while nothing is known yet.");
    native.def("return_free_memory", &return_free_memory,
               "Give the system what was freed and is kept for later, where the allocator keeps such memory.");
    native.def(
        "shared_array", &make_shared_array, "shape"_a, "dtype"_a,
        "An array, not yet filled, that meshes, textures and worlds share instead of copying it; from then on it "
        "cannot be written. Raises InvalidInput.");
    py::class_<Statistics>(native, "Statistics")
        .def("to_dict", &to_dict, "Stages, skipped, counts and reports as plain lists and dictionaries, for JSON.");
}
} // namespace tyndall::bindings
