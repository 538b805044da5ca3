// SPDX-License-Identifier: GPL-3.0-or-later
// A kernel that says which target it was compiled for, as a model for tests of real kernels: force each target in turn.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/core/simd_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::HWY_NAMESPACE {
static std::size_t float_lanes() { return hwy::HWY_NAMESPACE::Lanes(hwy::HWY_NAMESPACE::ScalableTag<float>()); }
} // namespace tyndall::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "core/errors.hpp"
#include "core/simd.hpp"
#include <doctest/doctest.h>

namespace tyndall {
HWY_EXPORT(float_lanes);

TEST_CASE("forcing a target decides how many lanes a kernel has, and ends with the scope") {
    const std::string widest = simd_target_name();
    const std::size_t widest_lanes = HWY_DYNAMIC_DISPATCH(float_lanes)();
    for (const SimdTarget target : available_simd_targets()) {
        const ForcedSimdTarget forced(target);
        CHECK(HWY_DYNAMIC_DISPATCH(float_lanes)() == std::size_t{4} << static_cast<int>(target));
        CHECK(simd_target_name() != "SSE2");
    }
    CHECK(simd_target_name() == widest);
    CHECK(HWY_DYNAMIC_DISPATCH(float_lanes)() == widest_lanes);
}
} // namespace tyndall
#endif
