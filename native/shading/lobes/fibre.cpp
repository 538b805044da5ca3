// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/fibre.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::fibre {
namespace {
constexpr float quarter_turn = 0.5f * std::numbers::pi_v<float>;
/// Next to the fibre's own direction, theta tells no phi, and the Hair BSDF's lobes end.
constexpr float least_cosine = 1e-3f;

float root(float x) { return std::sqrt(std::max(x, 0.0f)); }

/// To (-pi, pi].
float wrapped(float phi) { return phi - 2.0f * pi * std::round(phi / (2.0f * pi)); }

struct Theta {
    float sine, cosine;
};
/// By what a lobe's tilt holds; what goes beyond the fibre's end comes back.
Theta tilted(const Theta& theta, const Lobe& lobe) {
    return {theta.sine * lobe.a.y + theta.cosine * lobe.a.x, std::abs(theta.cosine * lobe.a.y - theta.sine * lobe.a.x)};
}
Theta theta_of(const Lobe& lobe, const vec3& direction) {
    const float sine = std::clamp(glm::dot(direction, lobe.normal), -1.0f, 1.0f);
    return {sine, root(1.0f - sine * sine)};
}

/// The Hair BSDF's distribution along, of Cauchy's shape over half of theta_light + theta_viewer; in angles on the fibre.
struct Cauchy {
    float width, offset, low, high; ///< Of its integral, where the light goes along the fibre, this way and that.

    Cauchy(const Lobe& lobe, float viewer_theta)
        : width(lobe.alpha), offset(lobe.a.x), low(std::atan((0.5f * (viewer_theta - quarter_turn) - offset) / width)),
          high(std::atan((0.5f * (viewer_theta + quarter_turn) - offset) / width)) {}
    [[nodiscard]] float pdf(float theta, float viewer_theta) const {
        const float t = 0.5f * (theta + viewer_theta) - offset;
        return 0.5f * width / ((t * t + width * width) * (high - low));
    }
    [[nodiscard]] float sample(float u, float viewer_theta) const {
        return 2.0f * (width * std::tan(low + u * (high - low)) + offset) - viewer_theta;
    }
};

float asin_of(const Angles& angles) { return std::atan2(angles.sine_theta, angles.cosine_theta); }

/// Around the fibre; `is_drawn`: the transmission's are drawn from the far half alone.
float around(const Lobe& lobe, float phi, bool is_drawn) {
    const float away = std::abs(phi), width = lobe.ior;
    if (lobe.kind == Lobe::Kind::FibreReflection)
        return away < quarter_turn || is_drawn
                   ? 0.25f / width * std::max(std::cos(0.5f * std::min(away / width, pi)), 0.0f)
                   : 0.0f;
    const float p = pi - away;
    if (is_drawn && p > quarter_turn)
        return 0.0f;
    return 0.5f * width / (std::atan(quarter_turn / width) * (p * p + width * width));
}

float of_hair_bsdf(const Lobe& lobe, const Meeting& meeting, bool is_drawn) {
    const Angles& light = meeting.light;
    if (light.cosine_theta < least_cosine)
        return 0.0f;
    const float viewer_theta = std::atan2(meeting.viewer_sine, meeting.viewer_cosine);
    const Cauchy along(lobe, viewer_theta);
    return along.pdf(std::atan2(light.sine_theta, light.cosine_theta), viewer_theta) / light.cosine_theta *
           around(lobe, light.phi, is_drawn);
}

/// M times its integral.
float unscaled_along(const Theta& a, const Theta& b, float variance) {
    const float sum = a.sine + b.sine, difference = a.cosine - b.cosine;
    const float exponent = 0.5f * (sum * sum + difference * difference) / variance;
    return exponent > 80.0f ? 0.0f : scaled_bessel_i0(a.cosine * b.cosine / variance) * std::exp(-exponent);
}
float unscaled_logistic(float phi, float scale) {
    const float e = std::exp(-std::abs(phi) / scale);
    return e / ((1.0f + e) * (1.0f + e));
}

float of_principled(const Lobe& lobe, const Meeting& meeting, bool is_drawn) {
    Theta light{meeting.light.sine_theta, meeting.light.cosine_theta},
        viewer{meeting.viewer_sine, meeting.viewer_cosine};
    Theta& turned = lobe.is_separable && !is_drawn ? light : viewer;
    turned = tilted(turned, lobe);
    const float along = unscaled_along(light, viewer, lobe.alpha) * lobe.b.x;
    if (along == 0.0f)
        return 0.0f;
    return along * (lobe.ior > 0.0f ? unscaled_logistic(wrapped(meeting.light.phi - lobe.a.z), lobe.ior) * lobe.b.y
                                    : 0.5f / pi);
}
} // namespace

Frame::Frame(const vec3& fibre, const vec3& outgoing) : along(fibre) {
    const vec3 side = glm::cross(fibre, outgoing);
    const float length = glm::length(side);
    across = length > 1e-6f ? side / length : orthonormal_basis(fibre).first;
    towards_viewer = glm::cross(across, along);
}

vec3 Frame::direction(float sine_theta, float cosine_theta, float phi) const {
    return glm::normalize(sine_theta * along +
                          cosine_theta * (std::cos(phi) * towards_viewer + std::sin(phi) * across));
}

Angles angles_of(const Frame& frame, const vec3& direction) {
    const float x = glm::dot(direction, frame.towards_viewer), y = glm::dot(direction, frame.across);
    return {.sine_theta = std::clamp(glm::dot(direction, frame.along), -1.0f, 1.0f),
            .cosine_theta = std::sqrt(x * x + y * y),
            .phi = std::atan2(y, x)};
}

float scaled_bessel_i0(float x) {
    if (x < 3.75f) {
        const float t = x / 3.75f, t2 = t * t;
        return std::exp(-x) *
               (1.0f +
                t2 * (3.5156229f +
                      t2 * (3.0899424f + t2 * (1.2067492f + t2 * (0.2659732f + t2 * (0.0360768f + t2 * 0.0045813f))))));
    }
    const float t = 3.75f / x;
    return (0.39894228f +
            t * (0.01328592f +
                 t * (0.00225319f +
                      t * (-0.00157565f +
                           t * (0.00916281f +
                                t * (-0.02057706f + t * (0.02635537f + t * (-0.01647633f + t * 0.00392377f)))))))) /
           std::sqrt(x);
}

Rgb inverse_integrals(float variance_along, float scale_around) {
    return {1.0f / (variance_along * -std::expm1(-2.0f / variance_along)),
            scale_around > 0.0f ? 1.0f / (scale_around * std::tanh(quarter_turn / scale_around)) : 0.0f, 0.0f};
}

float along_fibre(float sine, float cosine, float viewer_sine, float viewer_cosine, float variance) {
    return unscaled_along({sine, cosine}, {viewer_sine, viewer_cosine}, variance) * inverse_integrals(variance, 1.0f).x;
}

float trimmed_logistic(float phi, float scale) {
    return unscaled_logistic(phi, scale) * inverse_integrals(1.0f, scale).y;
}

float sample_trimmed_logistic(float u, float scale) {
    // The logistic's integral up to x is (1 + tanh(x / (2 s))) / 2.
    const float t = (2.0f * u - 1.0f) * std::tanh(quarter_turn / scale);
    return std::clamp(2.0f * scale * std::atanh(std::clamp(t, -0.9999999f, 0.9999999f)), -pi, pi);
}

Meeting::Meeting(const vec3& along, const vec3& outgoing, const vec3& incoming)
    : frame(along, outgoing), light(angles_of(frame, incoming)),
      viewer_sine(std::clamp(glm::dot(outgoing, along), -1.0f, 1.0f)),
      viewer_cosine(root(1.0f - viewer_sine * viewer_sine)) {}

float scattered(const Lobe& lobe, const Meeting& meeting) {
    return lobe.kind == Lobe::Kind::Fibre ? of_principled(lobe, meeting, false) : of_hair_bsdf(lobe, meeting, false);
}

float pdf_per_sr(const Lobe& lobe, const Meeting& meeting) {
    return lobe.kind == Lobe::Kind::Fibre ? of_principled(lobe, meeting, true) : of_hair_bsdf(lobe, meeting, true);
}

vec3 sample(const Lobe& lobe, const vec3& outgoing, vec2 u) {
    const Frame frame(lobe.normal, outgoing);
    if (lobe.kind != Lobe::Kind::Fibre) {
        const float viewer_theta = asin_of(angles_of(frame, outgoing));
        const float theta = Cauchy(lobe, viewer_theta).sample(u.y, viewer_theta);
        const float share = 2.0f * u.x - 1.0f;
        const float phi = lobe.kind == Lobe::Kind::FibreReflection
                              ? 2.0f * lobe.ior * std::asin(share)
                              : pi + lobe.ior * std::tan(share * std::atan(quarter_turn / lobe.ior));
        return frame.direction(std::sin(theta), std::max(std::cos(theta), 0.0f), phi);
    }
    const Theta viewer = tilted(theta_of(lobe, outgoing), lobe);
    // Around where the viewer's theta is mirrored, by the angle whose 1 - cosine this is; and the number's last digits
    // turn about that: densely enough for what is so smooth.
    const float scattered = std::clamp(
        -lobe.alpha * std::log(std::max(u.y + (1.0f - u.y) * std::exp(-2.0f / lobe.alpha), 1e-30f)), 0.0f, 2.0f);
    const float turn = 2.0f * pi * (u.y * 4096.0f - std::floor(u.y * 4096.0f));
    const float light_sine = std::clamp(-(1.0f - scattered) * viewer.sine +
                                            root(scattered * (2.0f - scattered)) * std::cos(turn) * viewer.cosine,
                                        -1.0f, 1.0f);
    const float phi = lobe.ior > 0.0f ? lobe.a.z + sample_trimmed_logistic(u.x, lobe.ior) : 2.0f * pi * u.x;
    return frame.direction(light_sine, root(1.0f - light_sine * light_sine), phi);
}

float most_pdf_per_sr(const Lobe& lobe, const vec3& outgoing) {
    if (lobe.kind == Lobe::Kind::Fibre) {
        const Theta viewer = tilted(theta_of(lobe, outgoing), lobe);
        // M where the light is mirrored, which is where it is largest but for what narrows towards the fibre's end.
        const float most = 1.25f * scaled_bessel_i0(0.64f * viewer.cosine * viewer.cosine / lobe.alpha) /
                           (lobe.alpha * -std::expm1(-2.0f / lobe.alpha));
        return most * (lobe.ior > 0.0f ? trimmed_logistic(0.0f, lobe.ior) : 0.5f / pi);
    }
    const Cauchy along(lobe, std::asin(std::clamp(glm::dot(outgoing, lobe.normal), -1.0f, 1.0f)));
    const float most_around = lobe.kind == Lobe::Kind::FibreReflection
                                  ? 0.25f / lobe.ior
                                  : 0.5f / (lobe.ior * std::atan(quarter_turn / lobe.ior));
    return 0.5f / (along.width * (along.high - along.low)) * most_around / least_cosine;
}
} // namespace tyndall::fibre
