// SPDX-License-Identifier: GPL-3.0-or-later
// Paths from Python, as the native side takes them.
#pragma once
#include <pybind11/pybind11.h>
#include <string>

namespace tyndall::bindings {
/// Text of an os.PathLike or a str.
inline std::string path_of(const pybind11::object& path) {
    return pybind11::module_::import("os").attr("fspath")(path).cast<std::string>();
}
} // namespace tyndall::bindings
