// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes that are appended, and read once they are all there: in memory, or in a file that has no name, so that whatever
// ends the process leaves nothing behind.
// Bound:    beside the bytes in memory, or on disk, a buffer of 1 MiB.
#pragma once
#include "voxel_dag/checked_file.hpp"
#include <functional>

namespace tyndall::voxel_dag {
class SpilledBytes {
public:
    /// In memory.
    SpilledBytes() = default;
    /// On the disk of a folder that is there. Throws IoError, which names the folder.
    explicit SpilledBytes(const std::filesystem::path& folder);

    [[nodiscard]] std::uint64_t size() const { return size_; }
    /// Throws IoError, which names the folder and why.
    void append(std::span<const std::uint8_t> bytes);
    /// use(bytes) for all of them, in pieces: whole words where only such were appended. Throws as append() does.
    void read(const std::function<void(std::span<const std::uint8_t>)>& use) const;

private:
    [[noreturn]] void fail() const;

    std::filesystem::path folder_;
    File file_;                      ///< None: they are in memory.
    std::vector<std::uint8_t> held_; ///< All of them, or those that are not yet in the file.
    std::uint64_t size_ = 0;
};
} // namespace tyndall::voxel_dag
