// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/subsurface.hpp"
#include <array>
#include <numbers>

namespace tyndall::subsurface {
namespace {
/// By Horner's rule, the constant first.
template <std::size_t count>
float polynomial(const std::array<float, count>& coefficients, float x) {
    float sum = 0.0f;
    for (std::size_t i = count; i-- > 0;)
        sum = sum * x + coefficients[i];
    return sum;
}

/// Of a semi-infinite piece, for a single scattering's reduced albedo.
float dipole_albedo(float reduced_albedo, float boundary) {
    const float root = std::sqrt(3.0f * (1.0f - reduced_albedo));
    return 0.5f * reduced_albedo * (1.0f + std::exp(-boundary * root)) * std::exp(-root);
}

float reduced_albedo_of(float albedo, float boundary) {
    constexpr int halvings = 12;
    if (albedo < 1e-4f)
        return 0.0f;
    if (albedo >= 0.995f)
        return 0.999999f;
    float low = 0.0f, high = 1.0f, middle = 0.5f;
    for (int i = 0; i < halvings; ++i) {
        middle = 0.5f * (low + high);
        (dipole_albedo(middle, boundary) < albedo ? low : high) = middle;
    }
    return middle;
}
} // namespace

float single_albedo(float albedo, float g) {
    constexpr std::array a{1.8260523782f,   -1.28451056436f, -1.79904629312f, 9.19393289202f,
                           -22.8215585862f, 32.0234874259f,  -23.6264803333f, 7.21067002658f};
    constexpr std::array b{0.0f,           31.1491581433f,  -201.847017512f, 841.576016723f, -2018.09288505f,
                           2731.71560286f, -1935.41424244f, 559.009054474f};
    constexpr std::array c{1.09686102424f, -0.394704063468f, 1.05258115941f, -8.83963712726f,
                           28.8643230661f, -46.8802913581f,  38.5402837518f, -12.7181042538f};
    constexpr std::array d{0.496310210422f, 0.360146581622f, -2.15139309747f, 17.8896899217f,
                           -55.2984010333f, 82.065982243f,   -58.5106008578f, 15.8478295021f};
    constexpr std::array e{0.0f,           76.7316253952f,  -594.356773233f, 2448.8834203f, -5576.68528998f,
                           7116.60171912f, -4763.54467887f, 1303.5318055f};
    constexpr std::array f{2.40602999408f, -2.51814844609f, 9.18494908356f, -79.2191708682f,
                           259.082868209f, -403.613804597f, 302.85712436f,  -87.4370473567f};
    const float bright = std::pow(albedo, 0.25f);
    const float inner = 4.98511194385f + 0.127355959438f * std::exp(polynomial(b, g));
    const float outer = 4.23190299701f + 0.00310603949088f * std::exp(polynomial(e, g));
    const float found = (1.0f - bright) * polynomial(a, g) * std::pow(std::atan(inner * albedo), polynomial(c, g)) +
                        bright * polynomial(d, g) * std::pow(std::atan(outer * albedo), polynomial(f, g));
    return std::clamp(found, 0.0f, 0.999999f);
}

Rgb mean_free_path(SubsurfaceMethod method, const Rgb& radius_m, const Rgb& albedo, float ior) {
    if (method != SubsurfaceMethod::CosineSkinWalk && method != SubsurfaceMethod::SkinWalk)
        return radius_m *
               (0.25f * std::numbers::inv_pi_v<float>); // as far as older profiles of that radius, says Cycles
    const float inverse = 1.0f / ior;
    const float reflected =
        inverse * (-1.440f * inverse + 0.710f) + 0.668f + 0.0636f * ior; // inside, of all directions
    const float boundary = 4.0f / 3.0f * (1.0f + reflected) / (1.0f - reflected);
    Rgb path_m;
    for (int channel = 0; channel < 3; ++channel)
        path_m[channel] = radius_m[channel] * std::sqrt(3.0f * (1.0f - reduced_albedo_of(albedo[channel], boundary)));
    return path_m;
}
} // namespace tyndall::subsurface
