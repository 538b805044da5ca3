// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/io/image_file.hpp"
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include <OpenImageIO/imageio.h>
#include <sstream>

namespace tyndall::image_io {
namespace fs = std::filesystem;

/// Writes all pixels of `specification`, rows bottom to top, by OpenImageIO's writer of `format`.
static void write(const fs::path& path, const char* format, const OIIO::ImageSpec& specification, OIIO::TypeDesc type,
                  const void* pixels) {
    PartialFile file(path);
    const auto output = OIIO::ImageOutput::create(format);
    if (!output)
        refuse_file(path, OIIO::geterror());
    const auto row_bytes = static_cast<OIIO::stride_t>(type.size()) * specification.nchannels * specification.width;
    const char* last_row = static_cast<const char*>(pixels) + (specification.height - 1) * row_bytes;
    // The file is whole only after close(): a full disk may show no earlier.
    if (!output->open(file.name(), specification) ||
        !output->write_image(type, last_row, OIIO::AutoStride, -row_bytes) || !output->close())
        refuse_file(path, output->geterror());
    file.complete();
}

static void require_size(const fs::path& path, std::uint32_t width, std::uint32_t height) {
    constexpr std::uint32_t largest = 1u << 20;
    require(width > 0 && height > 0 && width <= largest && height <= largest, path.string(), ": a size of ", width,
            " x ", height);
}

void write_exr(const fs::path& path, std::uint32_t width, std::uint32_t height, std::span<const Plane> planes,
               EXRPrecision precision, const Metadata& metadata) {
    require_size(path, width, height);
    const std::size_t pixel_count = std::size_t{width} * height;
    std::size_t channel_count = 0;
    for (const Plane& plane : planes) {
        require(!plane.channels.empty() && plane.pixels.size() == pixel_count * plane.channels.size(), path.string(),
                ": plane '", plane.name, "' has ", plane.pixels.size(), " values for ", plane.channels.size(),
                " channels of ", width, " x ", height);
        channel_count += plane.channels.size();
    }
    require(channel_count > 0, path.string(), ": no planes");

    OIIO::ImageSpec specification(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channel_count),
                                  OIIO::TypeDesc::FLOAT);
    specification.attribute("compression", "zip");
    for (const auto& [key, value] : metadata)
        specification.attribute(key, value);
    specification.channelnames.clear();
    for (const Plane& plane : planes)
        for (const char letter : plane.channels) {
            const bool is_colour = std::string_view("RGBA").find(letter) != std::string_view::npos;
            specification.channelformats.push_back(
                precision == EXRPrecision::Half && is_colour ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
            std::string name = plane.name;
            if (!name.empty())
                name.push_back('.');
            name.push_back(letter);
            specification.channelnames.push_back(std::move(name));
        }

    std::vector<float> interleaved(pixel_count * channel_count);
    std::size_t first_channel = 0;
    for (const Plane& plane : planes) {
        const std::size_t count = plane.channels.size();
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            for (std::size_t channel = 0; channel < count; ++channel)
                interleaved[pixel * channel_count + first_channel + channel] = plane.pixels[pixel * count + channel];
        first_channel += count;
    }
    write(path, "openexr", specification, OIIO::TypeDesc::FLOAT, interleaved.data());
}

template <typename Value>
static void write_png_of(const fs::path& path, std::uint32_t width, std::uint32_t height, std::span<const Value> pixels,
                         OIIO::TypeDesc type) {
    require_size(path, width, height);
    const std::size_t channel_count = pixels.size() / (std::size_t{width} * height);
    require(channel_count >= 1 && channel_count <= 4 && pixels.size() == channel_count * width * height, path.string(),
            ": ", pixels.size(), " values for ", width, " x ", height);
    OIIO::ImageSpec specification(static_cast<int>(width), static_cast<int>(height), static_cast<int>(channel_count),
                                  type);
    specification.attribute("oiio:UnassociatedAlpha", 1); // else colours would be divided by alpha
    write(path, "png", specification, type, pixels.data());
}
void write_png(const fs::path& path, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> pixels) {
    write_png_of(path, width, height, pixels, OIIO::TypeDesc::UINT8);
}
void write_png(const fs::path& path, std::uint32_t width, std::uint32_t height, std::span<const std::uint16_t> pixels) {
    write_png_of(path, width, height, pixels, OIIO::TypeDesc::UINT16);
}

Image read(const fs::path& path) {
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1); // values as stored
    const auto input = OIIO::ImageInput::open(path.string(), &wishes);
    if (!input)
        refuse_file(path, OIIO::geterror());
    const OIIO::ImageSpec& specification = input->spec();
    Image image{.width = static_cast<std::uint32_t>(specification.width),
                .height = static_cast<std::uint32_t>(specification.height),
                .channel_names = specification.channelnames,
                .pixels = {},
                .metadata = {}};
    for (const OIIO::ParamValue& attribute : specification.extra_attribs)
        if (attribute.type() == OIIO::TypeDesc::STRING)
            image.metadata.emplace(attribute.name().string(), attribute.get_string());
    const auto channel_count = static_cast<std::size_t>(specification.nchannels);
    image.pixels.resize(channel_count * image.width * image.height);
    const auto row_bytes = static_cast<OIIO::stride_t>(sizeof(float) * channel_count * image.width);
    char* last_row =
        reinterpret_cast<char*>(image.pixels.data()) + (static_cast<OIIO::stride_t>(image.height) - 1) * row_bytes;
    if (!input->read_image(0, 0, 0, specification.nchannels, OIIO::TypeDesc::FLOAT, last_row, OIIO::AutoStride,
                           -row_bytes))
        refuse_file(path, input->geterror());
    return image;
}

static std::string version_text(int version) { // 30202 is 3.2.2
    std::ostringstream text;
    text << version / 10000 << '.' << version / 100 % 100 << '.' << version % 100;
    return text.str();
}
std::string header_version() { return version_text(OIIO_VERSION); }
std::string library_version() { return version_text(OIIO::openimageio_version()); }
} // namespace tyndall::image_io
