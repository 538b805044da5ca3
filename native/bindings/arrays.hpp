// SPDX-License-Identifier: GPL-3.0-or-later
// Numpy arrays in and out: dtype, shape and contiguity are checked once, and the argument is named. TypeError otherwise.
#pragma once
#include "core/math.hpp"
#include <array>
#include <cstring>
#include <memory>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tyndall::bindings {
namespace py = pybind11;

/// Shape with -1 for any length: "(-1, 3)".
inline std::string shape_text(const std::vector<py::ssize_t>& shape) {
    std::string text = "(";
    for (const py::ssize_t length : shape)
        text += (text.size() > 1 ? ", " : "") + (length < 0 ? std::string("n") : std::to_string(length));
    return text + (shape.size() == 1 ? ",)" : ")");
}

/// Throws TypeError unless the array has this scalar type and shape and is C-contiguous.
template <typename Scalar>
void check_array(const py::array& array, const std::vector<py::ssize_t>& shape, std::string_view name) {
    bool fits = py::isinstance<py::array_t<Scalar, py::array::c_style>>(array) &&
                array.ndim() == static_cast<py::ssize_t>(shape.size());
    for (py::ssize_t axis = 0; fits && axis < array.ndim(); ++axis)
        fits = shape[static_cast<std::size_t>(axis)] < 0 || array.shape(axis) == shape[static_cast<std::size_t>(axis)];
    if (fits)
        return;
    const std::vector<py::ssize_t> found(array.shape(), array.shape() + array.ndim());
    throw py::type_error(std::string(name) + " must be a C-contiguous " +
                         std::string(py::str(py::dtype::of<Scalar>())) + " array of shape " + shape_text(shape) +
                         ", not " + std::string(py::str(array.dtype())) + " " + shape_text(found));
}

/// An array whose rows are Items, as long as it lives.
template <typename Item, typename Scalar>
std::span<const Item> rows(const py::array& array, const std::vector<py::ssize_t>& shape, std::string_view name) {
    check_array<Scalar>(array, shape, name);
    return {static_cast<const Item*>(array.data()), static_cast<std::size_t>(array.nbytes()) / sizeof(Item)};
}

/// A copy of an array whose rows are Items: the native side keeps it beyond the call.
template <typename Item, typename Scalar>
std::vector<Item> to_vector(const py::array& array, const std::vector<py::ssize_t>& shape, std::string_view name) {
    check_array<Scalar>(array, shape, name);
    std::vector<Item> items(static_cast<std::size_t>(array.nbytes()) / sizeof(Item));
    if (!items.empty())
        std::memcpy(static_cast<void*>(items.data()), array.data(), items.size() * sizeof(Item));
    return items;
}

/// Hands a vector over to numpy without a copy; the array owns it.
template <typename Scalar>
py::array_t<Scalar> to_numpy(std::vector<Scalar> values, const std::vector<py::ssize_t>& shape) {
    auto owner = std::make_unique<std::vector<Scalar>>(std::move(values));
    Scalar* const first = owner->data();
    const py::capsule capsule(owner.get(), [](void* vector) { delete static_cast<std::vector<Scalar>*>(vector); });
    owner.release();
    return py::array_t<Scalar>(shape, first, capsule);
}

/// A matrix from one indexed [row, column], as numpy and Blender write them; GLM stores columns.
template <typename Matrix, int size>
Matrix to_matrix(const float* rows) {
    Matrix matrix;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
            matrix[column][row] = rows[row * size + column];
    return matrix;
}
template <typename Matrix, int size>
Matrix to_matrix(const py::array& array, std::string_view name) {
    check_array<float>(array, {size, size}, name);
    return to_matrix<Matrix, size>(static_cast<const float*>(array.data()));
}

using Triple = std::array<float, 3>;
inline vec3 to_vec3(const Triple& triple) { return {triple[0], triple[1], triple[2]}; }

template <typename Work>
auto without_gil(Work&& work) {
    const py::gil_scoped_release released;
    return work();
}
} // namespace tyndall::bindings
