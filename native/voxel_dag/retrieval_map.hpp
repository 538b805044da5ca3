// SPDX-License-Identifier: GPL-3.0-or-later
// Values of 24 bits by key, for keys that are known to be there: keys are not kept.
// Based on: Graf and Lemire, Xor Filters, 2020 (after Botelho, Pagh, Ziviani 2007): a value is the exclusive or of three
//           entries, which are found by peeling off keys that have an entry for themselves.
// Bound:    3.7 bytes per key; three loads that do not wait for each other.
#pragma once
#include "core/progress.hpp"
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
struct KeyedValue {
    std::uint64_t key;
    std::uint32_t value; ///< Below 2^24.
};

class RetrievalMap {
public:
    RetrievalMap() = default;
    /// Keys are all different. Throws Cancelled.
    RetrievalMap(std::span<const KeyedValue> values, const Progress& progress);

    /// Of a key that was given; of others, anything.
    [[nodiscard]] std::uint32_t at(std::uint64_t key) const {
        std::uint32_t value = 0;
        for (const std::uint32_t entry : entries_of(key))
            value ^= read(entry);
        return value & 0xffffff;
    }
    [[nodiscard]] std::uint64_t byte_count() const { return bytes_.size(); }

private:
    static constexpr std::uint64_t entry_bytes = 3;
    [[nodiscard]] std::array<std::uint32_t, 3> entries_of(std::uint64_t key) const;
    [[nodiscard]] std::uint32_t read(std::uint32_t entry) const {
        std::uint32_t value; // and a byte of the next one
        std::memcpy(&value, bytes_.data() + entry_bytes * entry, sizeof(value));
        return value;
    }
    [[nodiscard]] bool fill(std::span<const KeyedValue> values, const Progress& progress);

    std::uint64_t seed_ = 0;
    std::uint32_t third_ = 0; ///< Each key has an entry in each third.
    std::vector<std::uint8_t> bytes_;
};

inline std::array<std::uint32_t, 3> RetrievalMap::entries_of(std::uint64_t key) const {
    std::uint64_t mixed = (key + seed_) * 0x9e3779b97f4a7c15u;
    mixed = (mixed ^ mixed >> 32) * 0xd6e8feb86659fd93u;
    mixed ^= mixed >> 32;
    const auto within = [&](std::uint32_t turn) {
        const std::uint64_t turned = mixed << turn | mixed >> (64 - turn);
        return static_cast<std::uint32_t>((turned & 0xffffffffu) * third_ >> 32);
    };
    return {within(1), third_ + within(22), 2 * third_ + within(43)};
}
} // namespace tyndall::voxel_dag
