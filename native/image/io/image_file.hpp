// SPDX-License-Identifier: GPL-3.0-or-later
// Image files in and out, on OpenImageIO. Rows run bottom to top here and top to bottom in files. A file appears whole or
// not at all: it is written under a temporary name beside its own and renamed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tyndall::image_io {
/// A named plane of floats, as a multi-layer EXR holds it: channels "<name>.<letter>", or the letters alone for a plane
/// without a name.
struct Plane {
    std::string name;                ///< "ViewLayer.Combined"
    std::string channels;            ///< One letter each: "RGBA", "XYZ", "Z".
    std::span<const float> pixels{}; ///< height * width * channels.
};
enum class EXRPrecision : std::uint8_t { Half, Float };
using Metadata = std::map<std::string, std::string>;

/// All planes in one part, losslessly compressed (zip). Half keeps 11 bits and overflows at 65504: planes whose letters
/// are X, Y, Z or V stay float, being distances and positions. Throws IoError that names the path, and InvalidInput.
void write_exr(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
               std::span<const Plane> planes, EXRPrecision precision, const Metadata& metadata);
/// 8 or 16 bits per channel, 1 to 4 channels, values as they are to be stored (encoded, alpha unassociated). Throws
/// IoError and InvalidInput.
void write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
               std::span<const std::uint8_t> pixels);
void write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
               std::span<const std::uint16_t> pixels);

struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::string> channel_names; ///< As the file orders them.
    std::vector<float> pixels;              ///< height * width * channels, as stored: a PNG's stay encoded.
    Metadata metadata;                      ///< Text attributes.
};
/// The first part of any format that OpenImageIO knows. Throws IoError that names the path.
[[nodiscard]] Image read(const std::filesystem::path& path);

/// Where width * height * 4 bytes are to go.
using RGBARoom = std::function<std::uint8_t*(std::uint32_t width, std::uint32_t height)>;
/// Red, green, blue and alpha as stored, of a PNG, JPEG, TIFF or Targa of up to four channels of bytes that lies upright;
/// grey is all three colours, alpha 255 where there is none. False, and no room asked for: it is another file. Throws
/// IoError that names the path.
[[nodiscard]] bool read_rgba(const std::filesystem::path& path, const RGBARoom& room);
/// The same of what a PNG, JPEG or TIFF holds, which errors call `name`.
[[nodiscard]] bool read_rgba(std::span<const std::byte> file, const std::string& name, const RGBARoom& room);

/// "3.2.2": of the headers, and of the library that was loaded; they must agree.
[[nodiscard]] std::string header_version();
[[nodiscard]] std::string library_version();
} // namespace tyndall::image_io
