// SPDX-License-Identifier: GPL-3.0-or-later
// A .tdag file whose checksums are right and whose contents lie: as docs/tdag.md has it, byte by byte.
#pragma once
#include "voxel_dag/checked_file.hpp"
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>

namespace tyndall::support {
class ForgedFile {
public:
    struct Section {
        std::uint32_t kind, level;
        std::uint64_t offset, bytes;
    };
    /// Of a file that is whole.
    explicit ForgedFile(std::string bytes) : bytes_(std::move(bytes)) {}

    template <class Number>
    [[nodiscard]] Number at(std::uint64_t offset) const {
        Number value;
        std::memcpy(&value, bytes_.data() + offset, sizeof(value));
        return value;
    }
    template <class Number>
    void put(std::uint64_t offset, Number value) {
        std::memcpy(bytes_.data() + offset, &value, sizeof(value));
    }
    [[nodiscard]] std::uint32_t section_count() const { return at<std::uint32_t>(88); }
    [[nodiscard]] static std::uint64_t entry_of(std::uint32_t section) { return 104 + 32 * std::uint64_t{section}; }
    [[nodiscard]] Section section(std::uint32_t number) const {
        const std::uint64_t entry = entry_of(number);
        return {at<std::uint32_t>(entry), at<std::uint32_t>(entry + 4), at<std::uint64_t>(entry + 8),
                at<std::uint64_t>(entry + 16)};
    }
    [[nodiscard]] Section section_of(std::uint32_t kind, std::uint32_t level = 0) const {
        for (std::uint32_t i = 0; i < section_count(); ++i)
            if (section(i).kind == kind && section(i).level == level)
                return section(i);
        throw std::out_of_range("the file has no section " + std::to_string(kind));
    }
    /// The file, with checksums that fit what it says; sections that lie outside keep theirs.
    [[nodiscard]] std::string sealed() const {
        ForgedFile sealed(bytes_);
        for (std::uint32_t i = 0; i < section_count(); ++i)
            if (const auto [kind, level, offset, bytes] = section(i);
                offset <= bytes_.size() && bytes <= bytes_.size() - offset)
                sealed.put(entry_of(i) + 24, checksum(sealed.bytes_, offset, bytes));
        if (entry_of(section_count()) <= bytes_.size())
            sealed.put(92, checksum(sealed.bytes_, 104, 32 * std::uint64_t{section_count()}));
        sealed.put(100, checksum(sealed.bytes_, 0, 100));
        return sealed.bytes_;
    }

    /// One to three lies somewhere: in a section, in the table of them, in the header.
    void lie(std::mt19937& random) {
        constexpr std::uint64_t header_fields[]{12, 16, 20, 24, 32, 40, 56, 80};
        for (std::uint32_t left = 1 + below(3, random); left > 0; --left) {
            const std::uint32_t number = below(section_count(), random);
            const std::uint32_t where = below(16, random);
            if (where == 0)
                lie_at(header_fields[random() % std::size(header_fields)], 8, random);
            else if (where == 1)
                lie_at(entry_of(number) + 4 * (random() % 6), 4, random);
            else if (const Section in = section(number);
                     in.offset <= bytes_.size() && in.bytes <= bytes_.size() - in.offset && in.bytes >= 8)
                lie_at(in.offset + (random() % 3 == 0 ? std::min<std::uint64_t>(random() % 64, in.bytes - 8)
                                                      : random() % (in.bytes - 7)),
                       8, random);
        }
    }

private:
    static std::uint32_t below(std::uint32_t count, std::mt19937& random) {
        return static_cast<std::uint32_t>(random() % count);
    }
    static std::uint32_t checksum(const std::string& bytes, std::uint64_t offset, std::uint64_t count) {
        return voxel_dag::checksum_of(std::as_bytes(std::span(bytes).subspan(offset, count)));
    }
    void lie_at(std::uint64_t offset, std::uint32_t bytes, std::mt19937& random) {
        char* const there = bytes_.data() + offset;
        const std::uint32_t byte = below(bytes, random);
        switch (random() % 8) {
        case 0: // a number that is too large, or none
            std::memset(there + byte, random() % 2 == 0 ? 0 : 0xff, std::min(bytes - byte, 1 + below(4, random)));
            break;
        case 1: // one more or less
            there[byte] = static_cast<char>(there[byte] + (random() % 2 == 0 ? 1 : -1));
            break;
        case 2: { // what stands elsewhere
            const std::uint64_t other = random() % (bytes_.size() - bytes);
            std::memmove(there, bytes_.data() + other, bytes);
            break;
        }
        case 3:
            there[byte] = static_cast<char>(random());
            break;
        default:
            there[byte] = static_cast<char>(there[byte] ^ static_cast<char>(1u << random() % 8));
        }
    }

    std::string bytes_;
};
} // namespace tyndall::support
