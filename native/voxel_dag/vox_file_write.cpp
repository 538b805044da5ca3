// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include "voxel_dag/vox_file.hpp"
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

namespace tyndall::voxel_dag::vox {
namespace {
constexpr std::size_t header_bytes = 12;

class Writer {
public:
    void number(std::uint32_t value) { append(&value, sizeof value); }
    void number(std::int32_t value) { append(&value, sizeof value); }
    void append(const void* first, std::size_t byte_count) {
        const std::size_t at = bytes_.size();
        bytes_.resize(at + byte_count);
        if (byte_count > 0)
            std::memcpy(bytes_.data() + at, first, byte_count);
    }
    void text(const std::string& text) {
        number(static_cast<std::uint32_t>(text.size()));
        append(text.data(), text.size());
    }
    void entries(const std::vector<std::pair<std::string, std::string>>& entries) {
        number(static_cast<std::uint32_t>(entries.size()));
        for (const auto& [key, value] : entries)
            text(key), text(value);
    }
    /// What `fill` writes is the content of a chunk.
    template <typename Fill>
    void chunk(const char* name, const Fill& fill) {
        append(name, 4);
        const std::size_t sizes = bytes_.size();
        number(0u), number(0u);
        fill();
        const auto size = static_cast<std::uint32_t>(bytes_.size() - sizes - 8);
        std::memcpy(bytes_.data() + sizes, &size, sizeof size);
    }
    void node(std::int32_t number_of_it, const Node& node) {
        const char* const name = node.kind == NodeKind::Transform ? "nTRN"
                                 : node.kind == NodeKind::Group   ? "nGRP"
                                                                  : "nSHP";
        chunk(name, [&] {
            number(number_of_it);
            entries(node.is_hidden ? std::vector<std::pair<std::string, std::string>>{{"_hidden", "1"}}
                                   : std::vector<std::pair<std::string, std::string>>{});
            if (node.kind == NodeKind::Transform) {
                number(node.children.front()), number(-1), number(node.layer), number(1);
                std::ostringstream translation;
                translation << node.translation[0] << ' ' << node.translation[1] << ' ' << node.translation[2];
                entries({{"_r", std::to_string(node.rotation)}, {"_t", translation.str()}});
                return;
            }
            number(static_cast<std::uint32_t>(node.children.size()));
            for (const std::int32_t child : node.children) {
                number(child);
                if (node.kind == NodeKind::Shape)
                    entries({});
            }
        });
    }
    [[nodiscard]] std::vector<std::uint8_t> take() { return std::move(bytes_); }

private:
    std::vector<std::uint8_t> bytes_;
};
} // namespace

std::vector<std::uint8_t> to_bytes(const File& file, const Progress& progress) {
    Writer writer;
    constexpr std::uint32_t version = 150;
    writer.append("VOX ", 4), writer.number(version);
    writer.chunk("MAIN", [] {});
    const std::size_t begin = 8 + header_bytes;
    for (const Model& model : file.models) {
        progress.poll();
        writer.chunk("SIZE", [&] { writer.append(model.sides.data(), sizeof model.sides); });
        writer.chunk("XYZI", [&] {
            writer.number(static_cast<std::uint32_t>(model.voxels.size()));
            writer.append(model.voxels.data(), model.voxels.size() * sizeof(ModelVoxel));
        });
    }
    for (const auto& [number, node] : file.nodes)
        writer.node(number, node);
    writer.chunk("RGBA", [&] {
        constexpr std::uint32_t opaque = 0xff000000;
        for (std::size_t index = 1; index <= 256; ++index) // of voxels; the last one is none's
            writer.number(opaque | file.palette[index % 256]);
    });
    std::vector<std::uint8_t> bytes = writer.take();
    const auto child_bytes = static_cast<std::uint32_t>(bytes.size() - begin);
    std::memcpy(bytes.data() + begin - sizeof child_bytes, &child_bytes, sizeof child_bytes);
    return bytes;
}

void write(const File& file, const std::filesystem::path& path, const Progress& progress) {
    const std::vector<std::uint8_t> bytes = to_bytes(file, progress);
    PartialFile part(path);
    std::ofstream stream(part.name(), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream)
        refuse_file(path,
                    std::generic_category().message(errno) + ": see that the folder can be written to and has room");
    part.complete();
}
} // namespace tyndall::voxel_dag::vox
