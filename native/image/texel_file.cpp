// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/texel_file.hpp"
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace tyndall {
static std::string reason(int error) { return std::generic_category().message(error); }

TexelFile::TexelFile(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::string name = (folder_ / "tyndall-texels-XXXXXX").string();
    file_ = mkostemp(name.data(), O_CLOEXEC);
    if (file_ < 0)
        refuse_file(folder_, "no room for textures: " + reason(errno));
    // Nobody but this process ever sees it, half written or left over.
    unlink(name.c_str());
}

TexelFile::~TexelFile() { close(file_); }

std::uint64_t TexelFile::reserve(std::uint64_t byte_count) {
    const std::lock_guard lock(reserving_);
    return std::exchange(end_, end_ + byte_count);
}

void TexelFile::write(std::uint64_t place, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(place));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            refuse_file(folder_, "no room for textures: " + reason(written < 0 ? errno : ENOSPC));
        bytes = bytes.subspan(static_cast<std::size_t>(written));
        place += static_cast<std::uint64_t>(written);
    }
}

int TexelFile::read(std::uint64_t place, std::span<std::byte> bytes) const {
    while (!bytes.empty()) {
        const ssize_t found = pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(place));
        if (found < 0 && errno == EINTR)
            continue;
        if (found <= 0)
            return found < 0 ? errno : EIO; // shorter than it was written
        bytes = bytes.subspan(static_cast<std::size_t>(found));
        place += static_cast<std::uint64_t>(found);
    }
    return 0;
}

void TexelFile::release(std::uint64_t place, std::uint64_t byte_count) {
#ifdef FALLOC_FL_PUNCH_HOLE
    // Where it fails, the room comes back with the end of the file.
    (void)fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(place),
                    static_cast<off_t>(byte_count));
#else
    (void)place, (void)byte_count;
#endif
}
} // namespace tyndall
