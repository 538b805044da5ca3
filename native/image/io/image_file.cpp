// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/io/image_file.hpp"
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <cstring>
#include <sstream>
#include <string_view>

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

static OIIO::ImageSpec as_stored() {
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    return wishes;
}

Image read(const fs::path& path) {
    const OIIO::ImageSpec wishes = as_stored();
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

static bool is_of_bytes(const OIIO::ImageInput& input) {
    const OIIO::ImageSpec& specification = input.spec();
    const std::string_view format = input.format_name();
    const int count = specification.nchannels;
    const bool has_alpha = count == 2 || count == 4;
    return (format == "png" || format == "jpeg" || format == "tiff" || format == "targa") &&
           specification.format == OIIO::TypeDesc::UINT8 && specification.channelformats.empty() && count >= 1 &&
           count <= 4 && specification.alpha_channel == (has_alpha ? count - 1 : -1) && specification.width > 0 &&
           specification.height > 0 && specification.depth == 1 &&
           specification.get_int_attribute("Orientation", 1) == 1;
}

/// From the first `count` bytes of four each.
static void complete_rgba(std::uint8_t* pixels, std::size_t pixel_count, int count) {
    constexpr std::uint8_t opaque = 255;
    for (std::uint8_t* pixel = pixels; pixel != pixels + 4 * pixel_count; pixel += 4) {
        if (count != 4)
            pixel[3] = count == 2 ? pixel[1] : opaque;
        if (count < 3)
            pixel[1] = pixel[2] = pixel[0];
    }
}

static bool read_rgba_of(OIIO::ImageInput& input, const fs::path& path, const RGBARoom& room) {
    if (!is_of_bytes(input))
        return false;
    const auto width = static_cast<std::uint32_t>(input.spec().width);
    const auto height = static_cast<std::uint32_t>(input.spec().height);
    const int count = input.spec().nchannels;
    std::uint8_t* const first = room(width, height);
    const auto row_bytes = static_cast<OIIO::stride_t>(4) * width;
    std::uint8_t* const last_row = first + (static_cast<OIIO::stride_t>(height) - 1) * row_bytes;
    if (!input.read_image(0, 0, 0, count, OIIO::TypeDesc::UINT8, last_row, 4, -row_bytes))
        refuse_file(path, input.geterror());
    complete_rgba(first, std::size_t{width} * height, count);
    return true;
}

bool read_rgba(const fs::path& path, const RGBARoom& room) {
    const OIIO::ImageSpec wishes = as_stored();
    const auto input = OIIO::ImageInput::open(path.string(), &wishes);
    if (!input)
        refuse_file(path, OIIO::geterror());
    return read_rgba_of(*input, path, room);
}

/// Of what begins like this; nothing of any other. A Targa has no mark.
static const char* format_of(std::span<const std::byte> file) {
    const auto begins_with = [&](std::string_view mark) {
        return file.size() >= mark.size() && std::memcmp(file.data(), mark.data(), mark.size()) == 0;
    };
    if (begins_with("\x89PNG"))
        return "png";
    if (begins_with("\xff\xd8\xff"))
        return "jpeg";
    return begins_with({"II*\0", 4}) || begins_with({"MM\0*", 4}) ? "tiff" : nullptr;
}
bool read_rgba(std::span<const std::byte> file, const std::string& name, const RGBARoom& room) {
    const char* const format = format_of(file);
    if (format == nullptr)
        return false;
    OIIO::Filesystem::IOMemReader reader(file.data(), file.size());
    const auto input = OIIO::ImageInput::create(format);
    OIIO::ImageSpec specification;
    if (!input)
        refuse_file(name, OIIO::geterror());
    if (!input->set_ioproxy(&reader) || !input->open(name, specification, as_stored()))
        refuse_file(name, input->geterror());
    return read_rgba_of(*input, name, room);
}

static std::string version_text(int version) { // 30202 is 3.2.2
    std::ostringstream text;
    text << version / 10000 << '.' << version / 100 % 100 << '.' << version % 100;
    return text.str();
}
std::string header_version() { return version_text(OIIO_VERSION); }
std::string library_version() { return version_text(OIIO::openimageio_version()); }
} // namespace tyndall::image_io
