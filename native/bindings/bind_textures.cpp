// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "bindings/paths.hpp"
#include "bindings/shared_arrays.hpp"
#include "core/errors.hpp"
#include "image/texture.hpp"
#include "image/tiled_texels.hpp"
#include <pybind11/stl.h>
#include <variant>

namespace tyndall::bindings {
using namespace py::literals;
namespace {
std::shared_ptr<Texture> make_texture(std::string name,
                                      const std::variant<std::shared_ptr<TiledTexels>, py::array>& texels, bool is_srgb,
                                      bool has_alpha, int extension, int interpolation) {
    auto texture = std::make_shared<Texture>();
    if (const auto* const tiled = std::get_if<std::shared_ptr<TiledTexels>>(&texels)) {
        texture->tiles = *tiled;
        texture->width = (*tiled)->width(), texture->height = (*tiled)->height();
    } else {
        const auto& pixels = std::get<py::array>(texels);
        if (pixels.dtype().kind() == 'u')
            texture->bytes = to_shared<std::uint8_t, std::uint8_t>(pixels, {-1, -1, 4}, "pixels");
        else
            texture->floats = to_shared<float, float>(pixels, {-1, -1, 4}, "pixels");
        require(pixels.size() > 0, "image \"", name, "\" has no pixels");
        texture->height = static_cast<std::uint32_t>(pixels.shape(0));
        texture->width = static_cast<std::uint32_t>(pixels.shape(1));
    }
    texture->name = std::move(name);
    texture->is_srgb = is_srgb;
    texture->has_alpha = has_alpha;
    texture->extension = static_cast<TextureExtension>(extension);
    texture->interpolation = static_cast<TextureInterpolation>(interpolation);
    return texture;
}

std::shared_ptr<TiledTexels> make_tiled(const std::shared_ptr<TileCache>& cache, const std::string& name,
                                        const py::array& pixels) {
    const auto make = [&]<typename Value>(Value) {
        check_array<Value>(pixels, {-1, -1, 4}, "pixels");
        require(pixels.size() > 0, "image \"", name, "\" has no pixels");
        const std::span values(static_cast<const Value*>(pixels.data()), static_cast<std::size_t>(pixels.size()));
        const auto width = static_cast<std::uint32_t>(pixels.shape(1));
        const auto height = static_cast<std::uint32_t>(pixels.shape(0));
        return without_gil([&] { return std::make_shared<TiledTexels>(cache, name, width, height, values); });
    };
    return pixels.dtype().kind() == 'u' ? make(std::uint8_t{}) : make(float{});
}

py::array whole_texels(const TiledTexels& tiled) {
    const py::dtype type = tiled.is_float() ? py::dtype::of<float>() : py::dtype::of<std::uint8_t>();
    py::array texels = make_shared_array({tiled.height(), tiled.width(), 4}, type);
    const std::span bytes(static_cast<std::byte*>(texels.mutable_data()), static_cast<std::size_t>(texels.nbytes()));
    without_gil([&] { tiled.copy_to(bytes); });
    return texels;
}
} // namespace

void bind_textures(py::module_& native) {
    py::class_<TileCache, std::shared_ptr<TileCache>>(
        native, "TileCache", "Tiles of images that lie in a file without a name, some of them in memory.")
        .def(py::init([](const py::object& folder, std::size_t budget_bytes) {
                 return std::make_shared<TileCache>(path_of(folder), budget_bytes);
             }),
             "folder"_a, "budget_bytes"_a, "Raises IoError, which names the folder.")
        .def("require_whole", &TileCache::require_whole,
             "Raises IoError where a tile could not be read since the last call.")
        .def_property_readonly("tiles_read", [](const TileCache& cache) { return cache.counts().tiles_read; })
        .def_property_readonly("resident_bytes", [](const TileCache& cache) { return cache.counts().resident_bytes; })
        .def_property_readonly("budget_bytes", [](const TileCache& cache) { return cache.counts().budget_bytes; });
    py::class_<TiledTexels, std::shared_ptr<TiledTexels>>(native, "TiledTexels", "An image in the file of a cache.")
        .def(py::init(&make_tiled), "cache"_a, "name"_a, "pixels"_a,
             "pixels: uint8 or float32 (height, width, 4), rows bottom to top. Raises IoError: the disk is full.")
        .def_property_readonly("cache", &TiledTexels::shared_cache)
        .def_property_readonly("file_bytes", &TiledTexels::file_bytes)
        .def_property_readonly(
            "shape", [](const TiledTexels& tiled) { return py::make_tuple(tiled.height(), tiled.width(), 4); })
        .def("whole", &whole_texels, "All texels, as they were given. Raises IoError.");
    py::class_<Texture, std::shared_ptr<Texture>>(native, "Texture",
                                                  "An image as one node uses it; copies all but a shared_array.")
        .def(py::init(&make_texture), "name"_a, "pixels"_a, "is_srgb"_a, "has_alpha"_a, "extension"_a,
             "interpolation"_a, "pixels: uint8 or float32 (height, width, 4), rows bottom to top; or tiled ones.");
}
} // namespace tyndall::bindings
