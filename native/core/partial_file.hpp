// SPDX-License-Identifier: GPL-3.0-or-later
// A file appears whole or not at all: it is written under a temporary name beside its own and renamed.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace tyndall {
/// Throws IoError: "path: reason".
[[noreturn]] void refuse_file(const std::filesystem::path& path, std::string_view reason);

/// The temporary name of a file; what lies there is removed unless it becomes the file.
class PartialFile {
public:
    explicit PartialFile(const std::filesystem::path& path);
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    ~PartialFile();
    [[nodiscard]] std::string name() const { return part_.string(); }
    /// Gives it the name of the file, whose old content is lost. Throws IoError that names the path.
    void complete();

private:
    std::filesystem::path path_, part_;
};
} // namespace tyndall
