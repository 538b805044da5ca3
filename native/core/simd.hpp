// SPDX-License-Identifier: GPL-3.0-or-later
// Which instruction set the kernels written with Highway run on: the widest the CPU has, or the one a test forces.
// Embree chooses its own, unless one is forced when its device is made, which is when the first scene is.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tyndall {
enum class SimdTarget : std::uint8_t {
    Sse4 = 0, ///< The baseline, x86-64-v2.
    Avx2 = 1,
    Avx512 = 2,
};
/// Of this CPU, narrowest first.
[[nodiscard]] std::vector<SimdTarget> available_simd_targets();
/// "SSE4", "AVX2" or "AVX-512": what kernels run on now.
[[nodiscard]] std::string simd_target_name();

/// Whether a ForcedSimdTarget lives.
[[nodiscard]] bool is_simd_target_forced();

/// While one lives, kernels in every thread run on its target. For tests, benchmarks and pictures
/// whose bits several machines share: not while kernels run, and one at a time. Throws InvalidInput where the CPU lacks it.
class ForcedSimdTarget {
public:
    explicit ForcedSimdTarget(SimdTarget target);
    ForcedSimdTarget(const ForcedSimdTarget&) = delete;
    ForcedSimdTarget& operator=(const ForcedSimdTarget&) = delete;
    ~ForcedSimdTarget();
};
} // namespace tyndall
