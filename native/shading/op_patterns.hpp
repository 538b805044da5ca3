// SPDX-License-Identifier: GPL-3.0-or-later
// The operations that draw a pattern at a vector, register a: patterns/. What each packs into the other registers, its
// option and its value; addon/sync/pattern_nodes.py packs them:
//   Noise       b: w, scale, detail          c: roughness, lacunarity, distortion   d: offset, gain
//               option: dimensions - 1 | fractal << 2 | is normalized << 5
//   Musgrave    b: w, scale, detail          c: dimension, lacunarity, offset       d: gain
//               option: dimensions - 1 | fractal << 2
//   Voronoi     b: w, scale, randomness      c: smoothness, exponent, detail        d: roughness, lacunarity
//               option: dimensions - 1 | feature << 2 | metric << 5 | is normalized << 7
//   Wave        b: scale, distortion, detail c: detail scale, its roughness, phase
//               option: kind | direction << 1 | profile << 3
//   Magic       b: scale, distortion         option: depth
//   Gradient    option: kind
//   Checker     b, c: colours                d: scale
//   Brick       b, c: colours                d: mortar's colour
//               e: scale, mortar size, mortar smooth      f: bias, brick width, row height
//               option: offset frequency     value: offset, squash, squash frequency
//   WhiteNoise  b: w                         option: dimensions - 1
//   Gabor       b: scale, frequency, anisotropy           c: direction; in the plane its angle
//               option: dimensions - 2
// The selector says which result. Of Checker, Brick and Magic 0 is the colour and 1 the number, of the others 0 is the
// number and 1 the colour. Voronoi has 2, the place, and 3, its w; plus 8 for the points of Blender 5.0, plus 16 for
// distances as Blender 3 has them. Gabor has the value, the phase and the intensity.
#pragma once
#include "shading/op_facts.hpp"
#include "shading/operands.hpp"

namespace tyndall {
/// Nothing of a pattern without such an option, selector or value, nor of any other operation.
[[nodiscard]] std::optional<OpFacts> pattern_facts(const SurfaceOp& op);
/// Of the codes Noise to Gabor, whose facts are known.
[[nodiscard]] Rgb pattern_value(const SurfaceOp& op, const Operands& in);
} // namespace tyndall
