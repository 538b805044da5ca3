// SPDX-License-Identifier: GPL-3.0-or-later
// The module tyndall._image_io: numpy arrays to image files and back. Converts and nothing else.
#include "bindings/paths.hpp"
#include "bindings/shared_arrays.hpp"
#include "core/errors.hpp"
#include "image/io/image_file.hpp"
#include <memory>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace tyndall::image_io {
namespace py = pybind11;
using namespace py::literals;

using bindings::path_of;

/// A C-contiguous (height, width, channels) array of exactly this type; TypeError otherwise.
template <typename Value>
static std::span<const Value> values_of(const py::array& array, const std::string& name) {
    if (!py::isinstance<py::array_t<Value, py::array::c_style>>(array) || array.ndim() != 3)
        throw py::type_error(name + " must be a C-contiguous " + std::string(py::str(py::dtype::of<Value>())) +
                             " array of shape (height, width, channels)");
    return {static_cast<const Value*>(array.data()), static_cast<std::size_t>(array.size())};
}
static std::uint32_t length(const py::array& array, py::ssize_t axis) {
    return static_cast<std::uint32_t>(array.shape(axis));
}

using NamedPlane = std::tuple<std::string, std::string, py::array>;

static void write_planes(const py::object& path, const std::vector<NamedPlane>& named_planes, bool is_half,
                         const Metadata& metadata) {
    std::vector<Plane> planes;
    for (const auto& [name, channels, pixels] : named_planes) {
        planes.push_back(
            {.name = name, .channels = channels, .pixels = values_of<float>(pixels, "plane '" + name + "'")});
        const py::array& first = std::get<2>(named_planes.front());
        if (length(pixels, 0) != length(first, 0) || length(pixels, 1) != length(first, 1))
            throw py::type_error("plane '" + name + "' has another size than the first plane");
    }
    const std::uint32_t height = planes.empty() ? 0 : length(std::get<2>(named_planes.front()), 0);
    const std::uint32_t width = planes.empty() ? 0 : length(std::get<2>(named_planes.front()), 1);
    const std::string file = path_of(path);
    const py::gil_scoped_release released;
    write_exr(file, width, height, planes, is_half ? EXRPrecision::Half : EXRPrecision::Float, metadata);
}

static void write_pixels(const py::object& path, const py::array& pixels) {
    const std::string file = path_of(path);
    const auto write_as = [&]<typename Value>(Value) {
        const std::span<const Value> values = values_of<Value>(pixels, "pixels");
        const std::uint32_t width = length(pixels, 1), height = length(pixels, 0);
        const py::gil_scoped_release released;
        write_png(file, width, height, values);
    };
    if (pixels.dtype().is(py::dtype::of<std::uint16_t>()))
        write_as(std::uint16_t{});
    else
        write_as(std::uint8_t{});
}

static py::tuple read_pixels(const py::object& path) {
    const std::string file = path_of(path);
    Image image = [&] {
        const py::gil_scoped_release released;
        return read(file);
    }();
    // Handed over: a large image is in memory once.
    auto owner = std::make_unique<std::vector<float>>(std::move(image.pixels));
    const float* const first = owner->data();
    const py::capsule capsule(owner.get(), [](void* vector) { delete static_cast<std::vector<float>*>(vector); });
    owner.release();
    const py::array_t<float> pixels(
        {py::ssize_t{image.height}, py::ssize_t{image.width}, static_cast<py::ssize_t>(image.channel_names.size())},
        first, capsule);
    return py::make_tuple(pixels, image.channel_names, image.metadata);
}

/// Of a path, or of the bytes of a file.
static std::optional<py::array> read_rgba_bytes(const py::object& source, const std::string& name,
                                                const py::object& before) {
    std::optional<py::array> pixels;
    const RGBARoom room = [&](std::uint32_t width, std::uint32_t height) {
        const py::gil_scoped_acquire acquired;
        if (!before.is_none())
            before(width, height);
        py::array made =
            bindings::make_shared_array({py::ssize_t{height}, py::ssize_t{width}, 4}, py::dtype::of<std::uint8_t>());
        auto* const first = static_cast<std::uint8_t*>(made.mutable_data());
        pixels = std::move(made);
        return first;
    };
    if (py::isinstance<py::bytes>(source)) {
        const std::string_view file = source.cast<std::string_view>();
        const py::gil_scoped_release released;
        (void)read_rgba(std::as_bytes(std::span(file)), name, room);
    } else {
        const std::string file = path_of(source);
        const py::gil_scoped_release released;
        (void)read_rgba(file, room);
    }
    return pixels; // none, if there was no room to ask for
}

/// tyndall's own exceptions where the core can be loaded, their bases where it cannot.
static void raise(const char* name, PyObject* base, const char* message) {
    PyObject* type = base;
    py::object own;
    try {
        own = py::module_::import("tyndall").attr(name);
        type = own.ptr();
    } catch (const py::error_already_set&) {
    }
    PyErr_SetString(type, message);
}

PYBIND11_MODULE(_image_io, module) {
    module.doc() = "Image files in and out. Rows of arrays run bottom to top.";
    if (header_version() != library_version())
        throw py::import_error("built for OpenImageIO " + header_version() + ", but " + library_version() +
                               " was loaded: install the tyndall package again");
    py::register_local_exception_translator([](std::exception_ptr exception) {
        try {
            std::rethrow_exception(exception);
        } catch (const IoError& error) {
            raise("IoError", PyExc_OSError, error.what());
        } catch (const InvalidInput& error) {
            raise("InvalidInput", PyExc_ValueError, error.what());
        }
    });
    module.attr("openimageio_version") = library_version();
    module.def("write_exr", &write_planes, "path"_a, "planes"_a, "is_half"_a = false, "metadata"_a = Metadata(),
               R"(Write a multi-layer EXR, whole or not at all. Releases the GIL.

planes: (name, letters, pixels) each; pixels are float32 (height, width, len(letters)), written as channels
"<name>.<letter>". is_half: letters R, G, B, A as half floats. metadata: text attributes. TypeError: dtype or shape;
IoError names the path.)");
    module.def(
        "write_png", &write_pixels, "path"_a, "pixels"_a,
        R"(Write uint8 or uint16 (height, width, 1 to 4), encoded, alpha unassociated. IoError names the path.)");
    module.def("read", &read_pixels, "path"_a,
               R"(Pixels float32 (height, width, channels) as stored, names of the channels, text attributes.

IoError names the path.)");
    module.def("read_rgba", &read_rgba_bytes, "source"_a, "name"_a = "packed", "before"_a = py::none(),
               R"(Red, green, blue and alpha, uint8 (height, width, 4), as stored; None: it is another kind of file.

source: a path, or the bytes of a file, which errors call name. before(width, height) is called before there is memory for
the pixels; what it raises is raised. A PNG, JPEG, TIFF or, by its path, Targa of up to four
channels of bytes that lies upright: grey is all three colours, and alpha 255 where there is none. IoError names it.)");
}
} // namespace tyndall::image_io
