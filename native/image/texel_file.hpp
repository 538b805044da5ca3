// SPDX-License-Identifier: GPL-3.0-or-later
// A file without a name, for texels that memory has no room for: gone with the process, whatever ends it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>

namespace tyndall {
/// All functions may be called from many threads at once.
class TexelFile {
public:
    /// Throws IoError, which names the folder.
    explicit TexelFile(std::filesystem::path folder);
    TexelFile(const TexelFile&) = delete;
    TexelFile& operator=(const TexelFile&) = delete;
    ~TexelFile();

    /// The place of so many bytes that nobody else has.
    [[nodiscard]] std::uint64_t reserve(std::uint64_t byte_count);
    /// Throws IoError: a full disk, mostly.
    void write(std::uint64_t place, std::span<const std::byte> bytes);
    /// Returns an error number; 0: read.
    [[nodiscard]] int read(std::uint64_t place, std::span<std::byte> bytes) const;
    /// The disk has the room again, where the file system knows how.
    void release(std::uint64_t place, std::uint64_t byte_count);
    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

private:
    std::filesystem::path folder_;
    int file_ = -1;
    std::mutex reserving_;
    std::uint64_t end_ = 0;
};
} // namespace tyndall
