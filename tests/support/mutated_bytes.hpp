// SPDX-License-Identifier: GPL-3.0-or-later
// Files as a bad disk, a broken copy or a clumsy program leave them: what readers must read or refuse.
#pragma once
#include <cstdint>
#include <random>
#include <string>

namespace tyndall::support {
/// 1 to 4 changes: a byte, a bit, a few bytes gone or a few that are new, or an early end.
inline std::string mutated(std::string bytes, std::mt19937& random) {
    for (std::uint32_t left = 1 + random() % 4; left > 0 && !bytes.empty(); --left) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 9) {
        case 0:
        case 1:
            bytes[at] = static_cast<char>(random());
            break;
        case 2:
        case 3:
            bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(1u << random() % 8));
            break;
        case 4:
        case 5:
            bytes.erase(at, 1 + random() % 5);
            break;
        case 6:
        case 7:
            bytes.insert(at, 1 + random() % 4, static_cast<char>(random()));
            break;
        default:
            bytes.resize(at);
        }
    }
    return bytes;
}
} // namespace tyndall::support
