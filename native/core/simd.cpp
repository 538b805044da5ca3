// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/simd.hpp"
#include "core/errors.hpp"
#include <array>
#include <hwy/targets.h>

namespace tyndall {
// By SimdTarget. AVX-512 has two levels in Highway 1.0; which of them is no question for a test.
static constexpr std::array<std::int64_t, 3> targets_of{HWY_SSE4, HWY_AVX2, HWY_AVX3 | HWY_AVX3_DL};
static constexpr std::array<const char*, 3> names{"SSE4", "AVX2", "AVX-512"};

static bool is_forced = false;

/// Lets the next dispatch choose among these; 0: among all.
static void restrict_to(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().DeInit();
}

std::vector<SimdTarget> available_simd_targets() {
    std::vector<SimdTarget> available;
    for (std::size_t target = 0; target < targets_of.size(); ++target)
        if ((hwy::SupportedTargets() & targets_of[target]) != 0)
            available.push_back(static_cast<SimdTarget>(target));
    return available;
}

std::string simd_target_name() {
    const std::vector<SimdTarget> available = available_simd_targets();
    return available.empty() ? "SSE2" : names[static_cast<std::size_t>(available.back())];
}

bool is_simd_target_forced() { return is_forced; }

ForcedSimdTarget::ForcedSimdTarget(SimdTarget target) {
    const auto index = static_cast<std::size_t>(target);
    const std::int64_t present = hwy::SupportedTargets() & targets_of[index];
    require(present != 0, "this CPU has no ", names[index]);
    restrict_to(present);
    is_forced = true;
}

ForcedSimdTarget::~ForcedSimdTarget() {
    restrict_to(0);
    is_forced = false;
}
} // namespace tyndall
