// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/spilled_bytes.hpp"
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <unistd.h>

namespace tyndall::voxel_dag {
static constexpr std::size_t bytes_at_once = std::size_t{1} << 20;

SpilledBytes::SpilledBytes(const std::filesystem::path& folder) : folder_(folder) {
    std::string name = (folder / "spilled-XXXXXX").string();
    const int descriptor = mkstemp(name.data());
    if (descriptor < 0)
        fail();
    unlink(name.c_str());
    file_.reset(fdopen(descriptor, "w+b"));
    if (!file_) {
        close(descriptor);
        fail();
    }
}

void SpilledBytes::append(std::span<const std::uint8_t> bytes) {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    size_ += bytes.size();
    if (file_ && held_.size() >= bytes_at_once) {
        if (std::fwrite(held_.data(), 1, held_.size(), file_.get()) != held_.size() || std::fflush(file_.get()) != 0)
            fail();
        held_.clear();
    }
}

void SpilledBytes::read(const std::function<void(std::span<const std::uint8_t>)>& use) const {
    if (file_) {
        if (std::fseek(file_.get(), 0, SEEK_SET) != 0)
            fail();
        std::vector<std::uint8_t> piece(bytes_at_once);
        for (std::uint64_t left = size_ - held_.size(); left > 0;) {
            const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size()));
            if (std::fread(piece.data(), 1, count, file_.get()) != count)
                fail();
            left -= count;
            use(std::span(piece).first(count));
        }
        if (std::fseek(file_.get(), 0, SEEK_END) != 0)
            fail();
    }
    use(held_);
}

void SpilledBytes::fail() const {
    refuse_file(folder_,
                std::generic_category().message(errno) + ": see that the folder can be written to and has room");
}
} // namespace tyndall::voxel_dag
