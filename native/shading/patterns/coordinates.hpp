// SPDX-License-Identifier: GPL-3.0-or-later
// What a node with a choice of dimensions reads: W; X and Y; X, Y and Z; all four.
#pragma once
#include "shading/patterns/hash.hpp"

namespace tyndall::patterns {
template <int N>
[[nodiscard]] Point<N> coordinates(const vec3& vector, float w) {
    if constexpr (N == 1)
        return Point<1>(w);
    else if constexpr (N == 2)
        return {vector.x, vector.y};
    else if constexpr (N == 3)
        return vector;
    else
        return {vector, w};
}
/// compute.operator()<N>(), for a number of dimensions that is known at run time.
template <typename Compute>
decltype(auto) with_dimensions(int count, const Compute& compute) {
    switch (count) {
    case 1:
        return compute.template operator()<1>();
    case 2:
        return compute.template operator()<2>();
    case 3:
        return compute.template operator()<3>();
    default:
        return compute.template operator()<4>();
    }
}
} // namespace tyndall::patterns
