// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/matte_id.hpp"
#include <algorithm>
#include <bit>
#include <cstddef>

namespace tyndall::render {
static std::uint32_t byte_at(std::string_view name, std::size_t index) {
    return static_cast<std::uint8_t>(name[index]);
}

static std::uint32_t mixed(std::uint32_t block) { return std::rotl(block * 0xcc9e2d51u, 15) * 0x1b873593u; }

std::uint32_t matte_hash(std::string_view name) {
    std::uint32_t hash = 0;
    const std::size_t whole = name.size() / 4 * 4;
    for (std::size_t at = 0; at < whole; at += 4) {
        const std::uint32_t block =
            byte_at(name, at) | byte_at(name, at + 1) << 8 | byte_at(name, at + 2) << 16 | byte_at(name, at + 3) << 24;
        hash = std::rotl(hash ^ mixed(block), 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t rest = 0;
    for (std::size_t at = whole; at < name.size(); ++at)
        rest |= byte_at(name, at) << (8 * (at - whole));
    if (whole < name.size())
        hash ^= mixed(rest);
    hash ^= static_cast<std::uint32_t>(name.size());
    hash = (hash ^ hash >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

float matte_id(std::uint32_t hash) {
    const std::uint32_t exponent = std::clamp(hash >> 23 & 0xffu, 1u, 254u);
    return std::bit_cast<float>((hash & 0x807fffffu) | exponent << 23);
}
} // namespace tyndall::render
