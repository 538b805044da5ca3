// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays that numpy and native code hold together: memory that needs no lock of the interpreter to end.
#pragma once
#include "bindings/arrays.hpp"
#include "core/errors.hpp"
#include "core/shared_array.hpp"

namespace tyndall::bindings {
using SharedBlock = std::shared_ptr<std::byte[]>;
inline constexpr const char* shared_block_name = "tyndall array";
inline constexpr std::size_t shared_slack_bytes = 16; ///< Behind the last value, for who reads a register at a time.

/// Uninitialised, C-contiguous, aligned for any scalar.
inline py::array make_shared_array(const std::vector<py::ssize_t>& shape, const py::dtype& type) {
    double bytes = static_cast<double>(type.itemsize());
    for (const py::ssize_t length : shape) {
        require(length >= 0, "an array of shape ", shape_text(shape));
        bytes *= static_cast<double>(length);
    }
    require(bytes < 0x1p46 && type.kind() != 'O', "an array of shape ", shape_text(shape), " of ",
            std::string(py::str(type)));
    auto block = std::make_unique<SharedBlock>(new std::byte[static_cast<std::size_t>(bytes) + shared_slack_bytes]);
    std::byte* const first = block->get();
    const py::capsule capsule(block.get(), shared_block_name, [](PyObject* object) {
        delete static_cast<SharedBlock*>(PyCapsule_GetPointer(object, shared_block_name));
    });
    block.release();
    return py::array(type, shape, first, capsule);
}

/// The values of an array, which are shared, and frozen, where make_shared_array made it, and copied from any other. Bytes
/// behind the last one can be read in either case.
template <typename Item, typename Scalar>
SharedArray<Item> to_shared(const py::array& array, const std::vector<py::ssize_t>& shape, std::string_view name) {
    check_array<Scalar>(array, shape, name);
    const auto* const first = static_cast<const Item*>(array.data());
    const std::size_t count = static_cast<std::size_t>(array.nbytes()) / sizeof(Item);
    const py::object base = array.base() ? array.base() : py::none();
    if (PyCapsule_IsValid(base.ptr(), shared_block_name) != 0) {
        const auto& block = *static_cast<SharedBlock*>(PyCapsule_GetPointer(base.ptr(), shared_block_name));
        if (static_cast<const void*>(block.get()) == array.data()) {
            array.attr("setflags")(py::arg("write") = false);
            return {block, std::span(first, count)};
        }
    }
    std::vector<Item> items;
    items.reserve(count + (shared_slack_bytes + sizeof(Item) - 1) / sizeof(Item));
    items.resize(count);
    if (count > 0)
        std::memcpy(static_cast<void*>(items.data()), array.data(), count * sizeof(Item));
    return items;
}
} // namespace tyndall::bindings
