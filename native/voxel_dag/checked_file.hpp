// SPDX-License-Identifier: GPL-3.0-or-later
// Files of sections with a checksum each: written whole or not at all, read with an error that names the section.
// Bound:    a checksum is zlib's CRC-32, 1 to 3 GB/s.
#pragma once
#include "core/partial_file.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
[[nodiscard]] std::uint32_t checksum_of(std::span<const std::byte> bytes);
/// That of bytes which follow others.
[[nodiscard]] std::uint32_t checksum_of(std::span<const std::byte> bytes, std::uint32_t checksum_before);
template <class Value>
[[nodiscard]] std::span<const std::byte> bytes_of(const Value& value) {
    return std::as_bytes(std::span(&value, 1));
}

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// Throws IoError, which names the path and why, and Cancelled.
class FileWriter {
public:
    FileWriter(const std::filesystem::path& path, const Progress& progress);
    void write(std::span<const std::byte> bytes);
    /// Zeros up to there.
    void pad_to(std::uint64_t offset);
    /// In place of what was written there.
    void rewrite(std::uint64_t offset, std::span<const std::byte> bytes);
    /// The file appears.
    void complete();

private:
    [[noreturn]] void fail() const;

    const std::filesystem::path path_;
    PartialFile part_;
    File file_;
    const Progress& progress_;
    std::uint64_t at_ = 0;
};

/// Throws IoError, which names the path and what is wrong with it, and Cancelled.
class FileReader {
public:
    FileReader(const std::filesystem::path& path, const Progress& progress);
    [[nodiscard]] std::uint64_t size() const { return size_; }
    [[noreturn]] void refuse(const std::string& reason) const { refuse_file(path_, reason); }
    void read(std::uint64_t offset, std::span<std::byte> bytes, const std::string& what) const;
    /// All of a section, after its checksum was seen to fit. It has an offset, a size in bytes, a checksum, and a name_of().
    template <class Value, class Section>
    [[nodiscard]] std::vector<Value> values(const Section& section) const {
        if (section.offset > size_ || section.bytes > size_ - section.offset)
            refuse("it ends within " + name_of(section) + ": copy or save it again");
        if (section.bytes % sizeof(Value) != 0)
            refuse(name_of(section) + " have a size of " + std::to_string(section.bytes) + " bytes");
        std::vector<Value> values(section.bytes / sizeof(Value));
        read(section.offset, std::as_writable_bytes(std::span(values)), name_of(section));
        if (checksum_of(std::as_bytes(std::span(values))) != section.checksum)
            refuse(name_of(section) + " are damaged: copy or save the file again");
        return values;
    }

private:
    const std::filesystem::path path_;
    File file_;
    const Progress& progress_;
    std::uint64_t size_ = 0;
};
} // namespace tyndall::voxel_dag
