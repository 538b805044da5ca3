// SPDX-License-Identifier: GPL-3.0-or-later
// The passes of the light map's solver over texels, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include "core/math.hpp"
#include <cstddef>

namespace tyndall::light_shafts::light_map_passes {
/// The solver's arrays; the passes read and write texels [begin, end) of them.
struct Arrays {
    vec4 *texels, *gradient, *direction, *displacement;
    const vec4 *prior, *scale;
    float lambda;
};
/// Of s = gradient and a direction d: s.d, d.d, d.(x - prior), and how far along d until a texel reaches 0.
struct Along {
    vec4 gradient, square, prior, limit;
};
/// Squares of the scaled gradient, of texels that may move and of those at 0 that would rise.
struct Norms {
    vec4 free, held;
};
/// x = max(0, x + length * d), with d of `direction`; gradient -= lambda * (x - prior).
[[nodiscard]] Norms move(const Arrays& arrays, const vec4* direction, const vec4& length, std::size_t begin,
                         std::size_t end);
/// direction = scale * gradient + conjugacy * direction where x > 0, else 0; where conjugacy is 0, texels at 0 that would
/// rise do, too.
[[nodiscard]] Along turn(const Arrays& arrays, const vec4& conjugacy, std::size_t begin, std::size_t end);
/// displacement = max(-x, length * direction); sums of the displacement, limit 1.
[[nodiscard]] Along project(const Arrays& arrays, const vec4& length, std::size_t begin, std::size_t end);
} // namespace tyndall::light_shafts::light_map_passes
