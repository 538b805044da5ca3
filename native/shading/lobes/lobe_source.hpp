// SPDX-License-Identifier: GPL-3.0-or-later
// A shader that becomes lobes at a point: which it is, and where its inputs come from.
#pragma once
#include "core/math.hpp"
#include <cstdint>
#include <vector>

namespace tyndall {
enum class LobeModel : std::uint8_t; // lobe_models.hpp

struct LobeSource {
    static constexpr std::uint16_t no_register = 0xffff; ///< The constant counts.
    LobeModel model{};
    bool preserves_energy = false; ///< What facets hide from one another comes back, too.
    std::vector<Rgb> constants = {};
    std::vector<std::uint16_t> registers = {}; ///< As many.
    bool operator==(const LobeSource&) const = default;
};
} // namespace tyndall
