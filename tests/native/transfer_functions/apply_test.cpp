// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "transfer_functions/apply.hpp"
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <random>

namespace apply_test {
using namespace tyndall;
using namespace tyndall::transfer_functions;

namespace {
constexpr Use all_uses[] = {Use::Replace, Use::Multiply, Use::Tint};

struct Rays {
    std::vector<vec2> parameters;
    std::vector<Rgb> radiance, change;
    std::vector<float> share;
};
/// Parameters in and around [0, 1]^2, borders and corners included; a change that is there already.
Rays random_rays(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform, around(-0.2f, 1.2f);
    Rays rays;
    for (std::size_t i = 0; i < count; ++i) {
        const auto parameter = [&] { return random() % 16 == 0 ? static_cast<float>(random() % 2) : around(random); };
        rays.parameters.emplace_back(parameter(), parameter());
        rays.radiance.emplace_back(uniform(random), 10.0f * uniform(random), 0.1f * uniform(random));
        rays.change.emplace_back(uniform(random), -uniform(random), 0.0f);
        rays.share.push_back(uniform(random));
    }
    return rays;
}
ComposedFunction random_function(std::uint32_t size, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform;
    ComposedFunction function{.size = size, .texels = std::vector<vec4>(std::size_t{size} * size)};
    for (vec4& texel : function.texels)
        for (int c = 0; c < 4; ++c)
            texel[c] = uniform(random);
    return function;
}
std::vector<Rgb> changed(const ComposedFunction& function, const Application& application, Rays rays) {
    apply(function, application, rays.parameters, rays.radiance, rays.share, rays.change, Progress());
    return rays.change;
}
bool has_same_bits(const std::vector<Rgb>& a, const std::vector<Rgb>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Rgb)) == 0;
}

/// The function at a parameter pair, in double precision.
std::array<double, 4> looked_up(const ComposedFunction& function, vec2 parameters) {
    const auto size = static_cast<double>(function.size);
    std::array<double, 4> sum{};
    const auto position = [&](float parameter) { return std::clamp(double{parameter} * size - 0.5, 0.0, size - 1); };
    const double x = position(parameters.x), y = position(parameters.y);
    for (std::size_t j = 0; j < function.size; ++j)
        for (std::size_t i = 0; i < function.size; ++i) { // each texel's tent
            const double weight = std::max(1 - std::abs(x - static_cast<double>(i)), 0.0) *
                                  std::max(1 - std::abs(y - static_cast<double>(j)), 0.0);
            for (std::size_t c = 0; c < 4; ++c)
                sum[c] += weight * double{function.texels[j * function.size + i][static_cast<int>(c)]};
        }
    return sum;
}
} // namespace

TEST_CASE("a neutral function, and one without weight, change nothing bit for bit") {
    const Rays rays = random_rays(100, 1);
    for (const Use use : all_uses) {
        CHECK(has_same_bits(changed({}, {.use = use}, rays), rays.change));
        CHECK(has_same_bits(changed(random_function(8, 1), {.use = use, .weight = 0.0f}, rays), rays.change));
    }
}

// Seen to fail with L * C - alpha * L planted: the two products round alike only where nothing is fused.
TEST_CASE("white changes nothing in Multiply, bit for bit, and transparent texels nothing in any use") {
    const Rays rays = random_rays(1000, 2);
    ComposedFunction white = random_function(16, 2), clear = white;
    for (vec4& texel : white.texels)
        texel = vec4(texel.w);
    for (vec4& texel : clear.texels)
        texel = vec4(0.0f);
    CHECK(has_same_bits(changed(white, {.use = Use::Multiply, .weight = 0.7f}, rays), rays.change));
    for (const Use use : all_uses)
        CHECK(has_same_bits(changed(clear, {.use = use, .strength = 3.0f}, rays), rays.change));
}

// Seen to fail with texels taken to lie at i / size.
TEST_CASE("the change is that of the function read between its texels") {
    for (const std::uint32_t size : {1u, 2u, 5u, 32u})
        for (const Use use : all_uses) {
            const ComposedFunction function = random_function(size, 3);
            const Rays rays = random_rays(203, 4);
            const Application application{.use = use, .strength = 2.5f, .weight = 0.4f};
            const std::vector<Rgb> change = changed(function, application, rays);
            for (std::size_t i = 0; i < change.size(); ++i) {
                const auto colour = looked_up(function, rays.parameters[i]);
                const Rgb radiance = rays.radiance[i];
                const double luminance =
                    0.2126 * double{radiance.x} + 0.7152 * double{radiance.y} + 0.0722 * double{radiance.z};
                for (int c = 0; c < 3; ++c) {
                    const double l{radiance[c]};
                    const double factor = use == Use::Replace    ? 2.5 * double{rays.share[i]}
                                          : use == Use::Multiply ? l
                                                                 : luminance;
                    const double expected =
                        double{rays.change[i][c]} +
                        double{application.weight} * (factor * colour[static_cast<std::size_t>(c)] - colour[3] * l);
                    // Some 20 roundings, and a position that errs by size * 2^-24 between texels that differ by up to 1.
                    const double bound = (20.0 + size) * 6e-8 * (1.0 + factor + l);
                    CHECK(std::abs(double{change[i][c]} - expected) < bound);
                }
            }
        }
}

TEST_CASE("the share of a pixel scales what replaces, and nothing else") {
    const ComposedFunction function = random_function(8, 5);
    Rays rays = random_rays(50, 6);
    const auto without_share = [&](Application application) {
        std::vector<Rgb> change = rays.change;
        apply(function, application, rays.parameters, rays.radiance, {}, change, Progress());
        return change;
    };
    for (const Use use : {Use::Multiply, Use::Tint})
        CHECK(has_same_bits(without_share({.use = use}), changed(function, {.use = use}, rays)));
    rays.share.assign(rays.share.size(), 0.5f);
    CHECK(has_same_bits(without_share({.strength = 3.0f}), changed(function, {.strength = 6.0f}, rays)));
}

TEST_CASE("what is no number reads a texel, and no memory beyond") {
    Rays rays = random_rays(3, 7);
    rays.parameters = {{std::nanf(""), 0.0f}, {1e30f, -1e30f}, {std::numeric_limits<float>::infinity(), std::nanf("")}};
    for (const Rgb& change : changed(random_function(4, 8), {}, rays))
        CHECK(std::isfinite(change.x));
}

TEST_CASE("neither instruction sets nor threads nor the length of the last stretch change a bit") {
    const ComposedFunction function = random_function(64, 9);
    const Rays rays = random_rays(30011, 10);
    for (const Use use : all_uses) {
        const std::vector<Rgb> change = changed(function, {.use = use, .strength = 1.7f, .weight = 0.3f}, rays);
        const auto again = [&] { return changed(function, {.use = use, .strength = 1.7f, .weight = 0.3f}, rays); };
        CHECK(has_same_bits(with_threads(1, again), change));
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            CHECK(has_same_bits(again(), change));
        }
        for (const std::size_t first : {30010u, 30003u, 29990u}) { // rays of their own
            Rays some;
            some.parameters.assign(rays.parameters.begin() + static_cast<std::ptrdiff_t>(first), rays.parameters.end());
            some.radiance.assign(rays.radiance.begin() + static_cast<std::ptrdiff_t>(first), rays.radiance.end());
            some.change.assign(rays.change.begin() + static_cast<std::ptrdiff_t>(first), rays.change.end());
            some.share.assign(rays.share.begin() + static_cast<std::ptrdiff_t>(first), rays.share.end());
            CHECK(has_same_bits(changed(function, {.use = use, .strength = 1.7f, .weight = 0.3f}, some),
                                {change.begin() + static_cast<std::ptrdiff_t>(first), change.end()}));
        }
    }
}

TEST_CASE("spans of different lengths and numbers that are none are named") {
    Rays rays = random_rays(3, 11);
    const ComposedFunction function = random_function(2, 12);
    rays.share.pop_back();
    CHECK_THROWS_WITH_AS(changed(function, {}, rays), "3 rays have 3 radiances, 2 shares and 3 changes", InvalidInput);
    rays.share.clear();
    CHECK_THROWS_WITH_AS(changed(function, {.weight = std::nanf("")}, rays), "strength or weight is not finite",
                         InvalidInput);
}
} // namespace apply_test
