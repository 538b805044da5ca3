// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/air_columns_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/air_columns_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void find_cells_of(const AirGrid& grid, std::span<const ViewRay> rays, std::uint32_t* cells, std::uint32_t* steps) {
    static constexpr hn::CappedTag<float, 16> d;
    static constexpr hn::RebindToSigned<decltype(d)> di;
    static constexpr std::size_t lanes = hn::MaxLanes(d);
    static_assert(sizeof(ViewRay) == 8 * sizeof(float));
    const auto set = [](float value) { return hn::Set(d, value); };
    const auto within = [&](auto value, std::uint32_t past) {
        const auto most = set(static_cast<float>(past - 1));
        return hn::ConvertTo(di, hn::Min(hn::Max(value, hn::Zero(d)), most)); // a NaN becomes one of the two
    };
    const auto* const floats = reinterpret_cast<const float*>(rays.data());
    const std::size_t along = grid.is_orthographic ? 0 : 3; // the origin, or the direction
    const auto last = hn::Set(di, static_cast<std::int32_t>(rays.size() - 1));
    for (std::size_t i = 0; i < rays.size(); i += lanes) {
        const auto number = hn::Min(hn::Iota(di, static_cast<std::int32_t>(i)), last);
        const auto field = [&](std::size_t at) { return hn::GatherIndex(d, floats + at, hn::ShiftLeft<3>(number)); };
        const auto ax = field(along), ay = field(along + 1), az = field(along + 2), far = field(7);
        const auto dot = [&](const vec3& v) {
            return hn::MulAdd(set(v.x), ax, hn::MulAdd(set(v.y), ay, hn::Mul(set(v.z), az)));
        };
        auto x = dot(grid.x), y = dot(grid.y), far_m = far;
        if (grid.is_orthographic) {
            far_m = hn::Add(far, hn::Sub(dot(grid.depth), set(grid.plane_m)));
        } else {
            const auto scale = hn::Div(set(1.0f), dot(grid.depth));
            x = hn::Mul(x, scale), y = hn::Mul(y, scale);
        }
        const auto column = within(hn::Add(x, set(grid.offset.x)), grid.width),
                   row = within(hn::Add(y, set(grid.offset.y)), grid.height);
        const auto to_end =
            within(hn::Mul(hn::Sub(far_m, set(grid.first_m)), set(1.0f / grid.step_m)), grid.step_count);
        alignas(64) std::int32_t cell_of[lanes], steps_of[lanes];
        hn::Store(hn::Add(hn::Mul(row, hn::Set(di, static_cast<std::int32_t>(grid.width))), column), di, cell_of);
        hn::Store(hn::Add(to_end, hn::Set(di, 1)), di, steps_of);
        const std::size_t count = std::min(lanes, rays.size() - i);
        std::copy_n(cell_of, count, cells + i);
        std::copy_n(steps_of, count, steps + i);
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(find_cells_of);
namespace air_columns {
void find_cells(const AirGrid& grid, std::span<const ViewRay> rays, std::span<std::uint32_t> cells,
                std::span<std::uint32_t> steps) {
    if (!rays.empty())
        HWY_DYNAMIC_DISPATCH(find_cells_of)(grid, rays, cells.data(), steps.data());
}
} // namespace air_columns
} // namespace tyndall::light_shafts
#endif
