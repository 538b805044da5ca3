// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/partial_file.hpp"
#include "core/errors.hpp"
#include <sstream>
#include <system_error>
#include <unistd.h>

namespace tyndall {
void refuse_file(const std::filesystem::path& path, std::string_view reason) {
    std::ostringstream message;
    message << path.string() << ": " << reason;
    throw IoError(message.str());
}

PartialFile::PartialFile(const std::filesystem::path& path) : path_(path), part_(path) {
    std::filesystem::path name(".");
    name += path.filename();
    name += ".";
    name += std::to_string(getpid());
    name += ".part";
    part_.replace_filename(name);
}

PartialFile::~PartialFile() {
    std::error_code ignored; // nothing to remove after a success, and nothing to do about a failure
    std::filesystem::remove(part_, ignored);
}

void PartialFile::complete() {
    std::error_code error;
    std::filesystem::rename(part_, path_, error);
    if (error)
        refuse_file(path_, error.message());
}
} // namespace tyndall
