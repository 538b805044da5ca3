// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/retrieval_map.hpp"

namespace tyndall::voxel_dag {
RetrievalMap::RetrievalMap(std::span<const KeyedValue> values, const Progress& progress) {
    if (values.empty())
        return;
    // 1.23 entries per key are enough for nearly every seed; where one fails, the next is tried.
    third_ = static_cast<std::uint32_t>(static_cast<double>(values.size()) * (1.23 / 3.0)) + 11;
    for (seed_ = 1; !fill(values, progress); ++seed_) {
    }
}

bool RetrievalMap::fill(std::span<const KeyedValue> values, const Progress& progress) {
    constexpr std::size_t polled = 1 << 16;
    /// Of an entry, the keys that have it: how many, and their numbers combined, so that a last one names itself.
    struct Users {
        std::uint32_t count = 0, numbers = 0;
    };
    std::vector<Users> users(std::size_t{3} * third_);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % polled == 0)
            progress.poll();
        for (const std::uint32_t entry : entries_of(values[i].key)) {
            ++users[entry].count;
            users[entry].numbers ^= static_cast<std::uint32_t>(i);
        }
    }
    /// A key, and the entry that is its own when those peeled off after it are settled.
    struct Peeled {
        std::uint32_t number, own;
    };
    std::vector<Peeled> peeled;
    peeled.reserve(values.size());
    std::vector<std::uint32_t> alone;
    for (std::uint32_t entry = 0; entry < users.size(); ++entry)
        if (users[entry].count == 1)
            alone.push_back(entry);
    while (!alone.empty()) {
        if (peeled.size() % polled == 0)
            progress.poll();
        const std::uint32_t own = alone.back();
        alone.pop_back();
        if (users[own].count != 1)
            continue;
        const std::uint32_t number = users[own].numbers;
        peeled.push_back({number, own});
        for (const std::uint32_t entry : entries_of(values[number].key)) {
            users[entry].numbers ^= number;
            if (--users[entry].count == 1)
                alone.push_back(entry);
        }
    }
    if (peeled.size() != values.size())
        return false;
    bytes_.assign(entry_bytes * 3 * third_ + 1, 0);
    for (std::size_t i = peeled.size(); i-- > 0;) {
        const auto [number, own] = peeled[i];
        const std::uint32_t rest = at(values[number].key) ^ values[number].value; // its own entry is still 0
        for (std::uint64_t byte = 0; byte < entry_bytes; ++byte)
            bytes_[entry_bytes * own + byte] = static_cast<std::uint8_t>(rest >> 8 * byte);
    }
    return true;
}
} // namespace tyndall::voxel_dag
