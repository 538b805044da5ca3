// SPDX-License-Identifier: GPL-3.0-or-later
// Which objects an emitter lights, which of them block it, and whose light a picture holds apart.
// Based on: Blender's light linking. Objects are sorted into up to 64 sets for each of the two; set 0 has those that no
//           emitter names. An emitter has a bit for each set.
#pragma once
#include <cstdint>

namespace tyndall {
/// Of an emitter.
struct LightLinks {
    static constexpr std::uint32_t most_sets = 64;
    std::uint64_t receiver_sets = ~std::uint64_t{0}; ///< Bit s: lights objects of receiver set s.
    std::uint64_t blocker_sets = ~std::uint64_t{0};  ///< Bit s: objects of blocker set s cast its shadows.
    [[nodiscard]] bool lights(std::uint8_t receiver_set) const { return (receiver_sets >> receiver_set & 1u) != 0; }
    [[nodiscard]] bool is_blocked_by(std::uint8_t blocker_set) const { return (blocker_sets >> blocker_set & 1u) != 0; }
    [[nodiscard]] bool lights_all() const { return receiver_sets == ~std::uint64_t{0}; }
    [[nodiscard]] bool is_blocked_by_all() const { return blocker_sets == ~std::uint64_t{0}; }
    bool operator==(const LightLinks&) const = default;
};

/// Light groups are counted from 0, as FrameConfig::light_groups names them.
inline constexpr std::uint8_t no_light_group = 0xFF;
} // namespace tyndall
