// SPDX-License-Identifier: GPL-3.0-or-later
// .vox files put together byte by byte, as the format's text says: what its reader is tested with, which writes none of it.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tyndall::support::vox_bytes {
inline std::string number(std::int64_t value) {
    std::string bytes;
    for (int byte = 0; byte < 4; ++byte)
        bytes += static_cast<char>(static_cast<std::uint32_t>(value) >> 8 * byte & 0xff);
    return bytes;
}
inline std::string text(const std::string& letters) { return number(std::ssize(letters)) + letters; }
using Entries = std::vector<std::pair<std::string, std::string>>;
inline std::string entries(const Entries& pairs) {
    std::string bytes = number(std::ssize(pairs));
    for (const auto& [key, value] : pairs)
        bytes += text(key) + text(value);
    return bytes;
}
inline std::string chunk(const std::string& name, const std::string& content, const std::string& children = "") {
    return name + number(std::ssize(content)) + number(std::ssize(children)) + content + children;
}
inline std::string file(const std::string& chunks) { return "VOX " + number(150) + chunk("MAIN", "", chunks); }

using Voxel4 = std::array<std::uint8_t, 4>; ///< x, y, z and colour.
inline std::string model(int x, int y, int z, const std::vector<Voxel4>& voxels) {
    std::string content = number(std::ssize(voxels));
    for (const Voxel4& voxel : voxels)
        content.append(voxel.begin(), voxel.end());
    return chunk("SIZE", number(x) + number(y) + number(z)) + chunk("XYZI", content);
}
/// One frame per pair of rotation and translation; an empty text is left out.
inline std::string transform(int id, int child, const std::vector<std::pair<std::string, std::string>>& frames,
                             const Entries& of_node = {}, int layer = -1) {
    std::string content =
        number(id) + entries(of_node) + number(child) + number(-1) + number(layer) + number(std::ssize(frames));
    for (const auto& [rotation, translation] : frames) {
        Entries frame;
        if (!rotation.empty())
            frame.emplace_back("_r", rotation);
        if (!translation.empty())
            frame.emplace_back("_t", translation);
        content += entries(frame);
    }
    return chunk("nTRN", content);
}
inline std::string group(int id, const std::vector<int>& children) {
    std::string content = number(id) + entries({}) + number(std::ssize(children));
    for (const int child : children)
        content += number(child);
    return chunk("nGRP", content);
}
inline std::string shape(int id, const std::vector<int>& models) {
    std::string content = number(id) + entries({}) + number(std::ssize(models));
    for (const int model : models)
        content += number(model) + entries({});
    return chunk("nSHP", content);
}
inline std::vector<std::uint8_t> bytes_of(const std::string& file) { return {file.begin(), file.end()}; }
} // namespace tyndall::support::vox_bytes
