// SPDX-License-Identifier: GPL-3.0-or-later
// A string of bytes as sections one behind the other: a fixed header says how long each is, and whoever opens it learns
// which section is damaged. Numbers are little-endian.
#pragma once
#include "core/errors.hpp"
#include "voxel_dag/bit_packing.hpp"
#include <concepts>

namespace tyndall::voxel_dag {
class SectionReader {
public:
    /// name begins each message: "palette array".
    SectionReader(std::span<const std::uint8_t> bytes, std::string_view name) : rest_(bytes), name_(name) {}
    template <std::unsigned_integral Number>
    [[nodiscard]] Number number(std::string_view section) {
        Number value;
        std::memcpy(&value, take(sizeof(Number), section).data(), sizeof(Number));
        return value;
    }
    [[nodiscard]] std::span<const std::uint8_t> take(std::uint64_t byte_count, std::string_view section) {
        check(byte_count <= rest_.size(), section, "is cut off: ", byte_count, " bytes are due, ", rest_.size(),
              " are left");
        const auto part = rest_.first(static_cast<std::size_t>(byte_count));
        rest_ = rest_.subspan(part.size());
        return part;
    }
    /// Numbers of `width` bits each. What of count and width a damaged header says cannot overflow.
    [[nodiscard]] std::span<const std::uint8_t> take_packed(std::uint64_t count, std::uint32_t width,
                                                            std::string_view section) {
        check(width <= most_packed_bits, section, "has numbers of ", width, " bits");
        check(width == 0 || count <= 8 * std::uint64_t{rest_.size()} / width, section, "is cut off: ", count,
              " numbers of ", width, " bits are due, ", rest_.size(), " bytes are left");
        return take((count * width + 7) / 8, section);
    }
    /// The zeros behind the last section, which reads of bits may touch.
    void finish() {
        const auto slack = take(bit_slack_bytes, "end");
        for (const std::uint8_t byte : slack)
            check(byte == 0, "end", "is not 0");
        check(rest_.empty(), "end", "is followed by ", rest_.size(), " bytes");
    }
    /// Throws InvalidInput, which names the section.
    template <typename... Parts>
    void check(bool condition, std::string_view section, const Parts&... parts) const {
        require(condition, name_, ": section '", section, "' ", parts...);
    }

private:
    std::span<const std::uint8_t> rest_;
    std::string_view name_;
};

class SectionWriter {
public:
    template <std::unsigned_integral Number>
    void number(Number value) {
        const std::size_t at = bytes_.size();
        bytes_.resize(at + sizeof(Number));
        std::memcpy(bytes_.data() + at, &value, sizeof(Number));
    }
    void section(std::span<const std::uint8_t> part) { bytes_.insert(bytes_.end(), part.begin(), part.end()); }
    void packed(BitPacker& bits) { section(bits.take()); }
    [[nodiscard]] std::vector<std::uint8_t> finish() {
        bytes_.resize(bytes_.size() + bit_slack_bytes);
        return std::move(bytes_);
    }

private:
    std::vector<std::uint8_t> bytes_;
};
} // namespace tyndall::voxel_dag
