// SPDX-License-Identifier: GPL-3.0-or-later
// The meshes that the tools around voxel DAGs are compared on, from TYNDALL_SHARED_DATA, or from shared/data beside the
// repository: the Stanford dragon (871,414 triangles) and Sponza-LowPoly as its file states it.
#pragma once
#include "core/math.hpp"
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tyndall::bench {
struct BareMesh {
    std::vector<vec3> positions;
    std::vector<uvec3> triangles;
};

inline std::string shared_data(const std::string& path) {
    const char* folder = std::getenv("TYNDALL_SHARED_DATA");
    return (folder ? std::string(folder) : std::string("../shared/data")) + "/" + path;
}

/// dragon_vrip.ply: a header, x y z per vertex, "3 a b c" per face; gzip unpacks it. Nothing where it is absent.
inline std::optional<BareMesh> load_dragon() {
    const std::string path = shared_data("dragon/dragon_vrip.ply.gz");
    if (!std::ifstream(path))
        return std::nullopt;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(("gzip -dc '" + path + "'").c_str(), "r"), pclose);
    std::string text;
    char part[1 << 16];
    for (std::size_t read = 0; pipe && (read = std::fread(part, 1, sizeof part, pipe.get())) > 0;)
        text.append(part, read);
    const char *at = text.data(), *const end = at + text.size();
    const auto count_behind = [&](const std::string& name) {
        std::size_t count = 0;
        const std::size_t found = text.find(name);
        if (found != std::string::npos)
            std::from_chars(at + found + name.size(), end, count);
        return count;
    };
    BareMesh mesh{std::vector<vec3>(count_behind("element vertex ")),
                  std::vector<uvec3>(count_behind("element face "))};
    const std::size_t header = text.find("end_header\n");
    if (mesh.triangles.empty() || header == std::string::npos)
        return std::nullopt;
    at += header + 11;
    const auto read = [&](auto& value) {
        while (at < end && (*at == ' ' || *at == '\n'))
            ++at;
        at = std::from_chars(at, end, value).ptr;
    };
    for (vec3& position : mesh.positions)
        for (int axis = 0; axis < 3; ++axis)
            read(position[axis]);
    for (uvec3& triangle : mesh.triangles) {
        unsigned corner_count = 0;
        read(corner_count);
        for (int corner = 0; corner < 3; ++corner)
            read(triangle[corner]);
    }
    return mesh;
}

/// Two meshes, offsets as the .gltf states them; +Y up, not scaled. Nothing where it is absent.
inline std::optional<BareMesh> load_bare_sponza() {
    std::ifstream file(shared_data("sponza_lowpoly/Sponza_LowPoly.bin"), std::ios::binary);
    if (!file)
        return std::nullopt;
    const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
    BareMesh mesh;
    struct Part {
        std::size_t positions, position_count, indices, index_count;
    };
    for (const Part part : {Part{0, 64806, 777672, 175905}, Part{1129484, 4697, 1185848, 13347}}) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const auto* position = reinterpret_cast<const vec3*>(bytes.data() + part.positions);
        mesh.positions.insert(mesh.positions.end(), position, position + part.position_count);
        const auto* index = reinterpret_cast<const std::uint16_t*>(bytes.data() + part.indices);
        for (std::size_t i = 0; i < part.index_count; i += 3)
            mesh.triangles.push_back(uvec3(index[i], index[i + 1], index[i + 2]) + first);
    }
    return mesh;
}

/// 0: the dragon, 1: Sponza, read once. Nothing where it is absent.
inline const BareMesh* bare_mesh(std::int64_t which) {
    static const std::optional<BareMesh> dragon = load_dragon(), sponza = load_bare_sponza();
    const std::optional<BareMesh>& wanted = which == 0 ? dragon : sponza;
    return wanted ? &*wanted : nullptr;
}
} // namespace tyndall::bench
