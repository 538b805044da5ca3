// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_patterns.hpp"
#include "shading/patterns/brick.hpp"
#include "shading/patterns/checker.hpp"
#include "shading/patterns/gabor.hpp"
#include "shading/patterns/gradient.hpp"
#include "shading/patterns/magic.hpp"
#include "shading/patterns/musgrave.hpp"
#include "shading/patterns/noise.hpp"
#include "shading/patterns/voronoi.hpp"
#include "shading/patterns/wave.hpp"
#include "shading/patterns/white_noise.hpp"

namespace tyndall {
namespace {
using namespace patterns;
using Code = SurfaceOp::Code;
constexpr int permuted_points = 8, begins_far = 16; // of Voronoi's selector

int bits(const SurfaceOp& op, int first, int count) { return (op.option >> first) & ((1 << count) - 1); }

Rgb noise_value(const SurfaceOp& op, const Operands& in) {
    const NoiseConfig config{
        .dimensions = bits(op, 0, 2) + 1,
        .fractal = static_cast<Fractal>(bits(op, 2, 3)),
        .is_normalized = bits(op, 5, 1) != 0,
        .w = in.b.x,
        .scale = in.b.y,
        .distortion = in.c.z,
        .octaves = {.detail = in.b.z, .factor = in.c.x, .lacunarity = in.c.y, .offset = in.d.x, .gain = in.d.y}};
    return op.selector == 0 ? Rgb(noise(in.a, config)) : noise_colour(in.a, config);
}

Rgb musgrave_value(const SurfaceOp& op, const Operands& in) {
    return Rgb(musgrave(in.a, {.dimensions = bits(op, 0, 2) + 1,
                               .fractal = static_cast<Fractal>(bits(op, 2, 3)),
                               .w = in.b.x,
                               .scale = in.b.y,
                               .detail = in.b.z,
                               .dimension = in.c.x,
                               .lacunarity = in.c.y,
                               .offset = in.c.z,
                               .gain = in.d.x}));
}

Rgb voronoi_value(const SurfaceOp& op, const Operands& in) {
    const Voronoi found = voronoi(in.a, {.dimensions = bits(op, 0, 2) + 1,
                                         .feature = static_cast<VoronoiConfig::Feature>(bits(op, 2, 3)),
                                         .metric = static_cast<VoronoiConfig::Metric>(bits(op, 5, 2)),
                                         .is_normalized = bits(op, 7, 1) != 0,
                                         .has_permuted_points = (op.selector & permuted_points) != 0,
                                         .begins_far = (op.selector & begins_far) != 0,
                                         .has_colour = (op.selector & 3) == 1,
                                         .w = in.b.x,
                                         .scale = in.b.y,
                                         .randomness = in.b.z,
                                         .smoothness = in.c.x,
                                         .exponent = in.c.y,
                                         .detail = in.c.z,
                                         .roughness = in.d.x,
                                         .lacunarity = in.d.y});
    switch (op.selector & 3) {
    case 0:
        return Rgb(found.distance);
    case 1:
        return found.colour;
    case 2:
        return Rgb(found.place);
    default:
        return Rgb(found.place.w);
    }
}

Rgb wave_value(const SurfaceOp& op, const Operands& in) {
    return Rgb(wave(in.a, {.kind = static_cast<WaveConfig::Kind>(bits(op, 0, 1)),
                           .direction = static_cast<WaveConfig::Direction>(bits(op, 1, 2)),
                           .profile = static_cast<WaveConfig::Profile>(bits(op, 3, 2)),
                           .scale = in.b.x,
                           .distortion = in.b.y,
                           .phase_rad = in.c.z,
                           .detail = in.b.z,
                           .detail_scale = in.c.x,
                           .detail_roughness = in.c.y}));
}

Rgb brick_value(const SurfaceOp& op, const Operands& in) {
    const Brick found = brick(in.a, {.scale = in.e.x,
                                     .mortar_size = in.e.y,
                                     .mortar_smooth = in.e.z,
                                     .bias = in.f.x,
                                     .brick_width = in.f.y,
                                     .row_height = in.f.z,
                                     .offset = op.value.x,
                                     .squash = op.value.y,
                                     .offset_frequency = op.option,
                                     .squash_frequency = static_cast<int>(op.value.z)});
    if (op.selector == 1)
        return Rgb(found.mortar_share);
    const Rgb tinted = in.b * (1.0f - found.tint) + in.c * found.tint;
    return tinted * (1.0f - found.mortar_share) + in.d * found.mortar_share;
}

Rgb gabor_value(const SurfaceOp& op, const Operands& in) {
    const Gabor found = gabor(in.a, {.dimensions = op.option + 2,
                                     .scale = in.b.x,
                                     .frequency = in.b.y,
                                     .anisotropy = in.b.z,
                                     .angle_rad = in.c.x,
                                     .direction = in.c});
    return Rgb(op.selector == 0 ? found.value : op.selector == 1 ? found.phase : found.intensity);
}
} // namespace

std::optional<OpFacts> pattern_facts(const SurfaceOp& op) {
    const auto facts = [&](bool is_known, int operand_count, bool is_number) -> std::optional<OpFacts> {
        if (!is_known)
            return {};
        return OpFacts{static_cast<std::uint8_t>(operand_count), OpReads::nothing,
                       is_number ? Channels::Equal : Channels::Own};
    };
    const std::uint8_t option = op.option, selector = op.selector;
    const bool is_fractal = bits(op, 2, 3) <= static_cast<int>(Fractal::HeteroTerrain);
    switch (op.code) {
    case Code::Noise:
        return facts(selector < 2 && option < 64 && is_fractal, 4, selector == 0);
    case Code::Musgrave:
        return facts(selector == 0 && option < 32 && is_fractal, 4, true);
    case Code::Voronoi: {
        const bool is_feature = bits(op, 2, 3) <= static_cast<int>(VoronoiConfig::Feature::SphereRadius);
        const int result = selector & 3;
        return facts(selector < 32 && (selector & 4) == 0 && is_feature, 4, result == 0 || result == 3);
    }
    case Code::Wave:
        return facts(selector == 0 && option < 32 && bits(op, 3, 2) <= static_cast<int>(WaveConfig::Profile::Triangle),
                     3, true);
    case Code::Magic:
        return facts(selector < 2 && option <= 10, 2, selector == 1);
    case Code::Gradient:
        return facts(selector == 0 && option <= static_cast<int>(Gradient::Spherical), 1, true);
    case Code::Checker:
        return facts(selector < 2 && option == 0, 4, selector == 1);
    case Code::Brick:
        return facts(selector < 2 && op.value.z >= 0.0f && op.value.z <= 255.0f, 6, selector == 1);
    case Code::WhiteNoise:
        return facts(selector < 2 && option < 4, 2, selector == 0);
    case Code::Gabor:
        return facts(selector < 3 && option < 2, 3, true);
    default:
        return {};
    }
}

Rgb pattern_value(const SurfaceOp& op, const Operands& in) {
    switch (op.code) {
    case Code::Noise:
        return noise_value(op, in);
    case Code::Musgrave:
        return musgrave_value(op, in);
    case Code::Voronoi:
        return voronoi_value(op, in);
    case Code::Wave:
        return wave_value(op, in);
    case Code::Magic: {
        const Rgb colour = magic(in.a, in.b.x, in.b.y, op.option);
        return op.selector == 0 ? colour : Rgb(average(colour));
    }
    case Code::Gradient:
        return Rgb(gradient(in.a, static_cast<Gradient>(op.option)));
    case Code::Checker: {
        const bool is_first = checker(in.a, in.d.x);
        return op.selector == 1 ? Rgb(is_first ? 1.0f : 0.0f) : is_first ? in.b : in.c;
    }
    case Code::Brick:
        return brick_value(op, in);
    case Code::WhiteNoise:
        return op.selector == 0 ? Rgb(white_noise(in.a, in.b.x, op.option + 1))
                                : white_noise_colour(in.a, in.b.x, op.option + 1);
    case Code::Gabor:
        return gabor_value(op, in);
    default:
        return Rgb(0.0f);
    }
}
} // namespace tyndall
