// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/checked_file.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <zlib.h>

namespace tyndall::voxel_dag {
/// Calls work(first, count) for stretches, between which the call can be cancelled.
template <class Work>
static void in_stretches(std::size_t size, const Progress& progress, const Work& work) {
    constexpr std::size_t bytes_at_once = std::size_t{4} << 20;
    for (std::size_t first = 0; first < size; first += bytes_at_once) {
        progress.poll();
        work(first, std::min(bytes_at_once, size - first));
    }
}

std::uint32_t checksum_of(std::span<const std::byte> bytes, std::uint32_t checksum_before) {
    if (bytes.empty()) // without an address zlib would begin anew
        return checksum_before;
    return static_cast<std::uint32_t>(
        crc32_z(checksum_before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}
std::uint32_t checksum_of(std::span<const std::byte> bytes) {
    return checksum_of(bytes, static_cast<std::uint32_t>(crc32_z(0, nullptr, 0)));
}

FileWriter::FileWriter(const std::filesystem::path& path, const Progress& progress)
    : path_(path), part_(path), file_(std::fopen(part_.name().c_str(), "wb")), progress_(progress) {
    if (!file_)
        fail();
}

void FileWriter::write(std::span<const std::byte> bytes) {
    in_stretches(bytes.size(), progress_, [&](std::size_t first, std::size_t count) {
        if (std::fwrite(bytes.data() + first, 1, count, file_.get()) != count)
            fail();
    });
    at_ += bytes.size();
}

void FileWriter::pad_to(std::uint64_t offset) {
    const std::array<std::byte, 64> zeros{};
    while (at_ < offset)
        write(std::span(zeros).first(std::min<std::uint64_t>(zeros.size(), offset - at_)));
}

void FileWriter::rewrite(std::uint64_t offset, std::span<const std::byte> bytes) {
    if (std::fseek(file_.get(), static_cast<long>(offset), SEEK_SET) != 0 ||
        std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
        std::fseek(file_.get(), 0, SEEK_END) != 0)
        fail();
}

void FileWriter::complete() {
    if (std::fclose(file_.release()) != 0)
        fail();
    part_.complete();
}

void FileWriter::fail() const {
    refuse_file(path_, std::generic_category().message(errno) + ": see that the folder can be written to and has room");
}

FileReader::FileReader(const std::filesystem::path& path, const Progress& progress)
    : path_(path), file_(std::fopen(path.c_str(), "rb")), progress_(progress) {
    std::error_code error;
    if (!file_ || (size_ = std::filesystem::file_size(path, error), error))
        refuse_file(path, error ? error.message() : std::generic_category().message(errno));
}

void FileReader::read(std::uint64_t offset, std::span<std::byte> bytes, const std::string& what) const {
    if (offset > size_ || bytes.size() > size_ - offset)
        refuse("it ends within " + what + ": copy or save it again");
    if (std::fseek(file_.get(), static_cast<long>(offset), SEEK_SET) != 0)
        refuse(std::generic_category().message(errno));
    in_stretches(bytes.size(), progress_, [&](std::size_t first, std::size_t count) {
        if (std::fread(bytes.data() + first, 1, count, file_.get()) != count)
            refuse("reading " + what + " failed");
    });
}
} // namespace tyndall::voxel_dag
