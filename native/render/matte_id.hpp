// SPDX-License-Identifier: GPL-3.0-or-later
// Names as Cryptomatte writes them into pixels.
// Based on: Friedman and Jones, Cryptomatte specification 1.2.0, 2016: MurmurHash3_x86_32 (Appleby) with seed 0, and its
//           bits as a float whose exponent is neither 0 nor 255, so that no name is denormal, infinite or no number.
#pragma once
#include <cstdint>
#include <string_view>

namespace tyndall::render {
[[nodiscard]] std::uint32_t matte_hash(std::string_view name);
[[nodiscard]] float matte_id(std::uint32_t hash);
[[nodiscard]] inline float matte_id(std::string_view name) { return matte_id(matte_hash(name)); }
} // namespace tyndall::render
