// SPDX-License-Identifier: GPL-3.0-or-later
// Strata that are dealt out to several pictures: in all of them together there is each of them, equally often.
#include "light_shafts/dealt_strata.hpp"
#include "light_shafts/scattering_lights.hpp"
#include "support/close_to.hpp"
#include <array>
#include <doctest/doctest.h>
#include <numeric>
#include <vector>

namespace dealt_strata_test {
using namespace tyndall;
using namespace tyndall::support;
using namespace tyndall::light_shafts;

/// Of a picture of so many samples that is taken as so many pictures, in order.
static std::vector<SeriesPart> parts_of(std::uint32_t samples, std::uint32_t pictures) {
    std::vector<SeriesPart> parts;
    for (std::uint32_t index = 0; index < pictures; ++index)
        parts.push_back({samples * index / pictures, samples * (index + 1) / pictures, samples, pictures});
    return parts;
}

TEST_CASE("pictures of any number have each of any number of strata as often as the others") {
    for (const std::uint32_t count : {1u, 2u, 4u, 8u, 12u, 16u, 64u, 1024u})
        for (const std::uint32_t samples : {1u, 3u, 16u, 24u, 128u})
            for (const std::uint32_t pictures : {1u, 3u, 12u, 16u}) {
                if (pictures > samples)
                    continue;
                std::vector<double> sums(count, 0.0);
                for (const SeriesPart& part : parts_of(samples, pictures)) {
                    const std::vector<float> weights = dealt_weights(count, 4, part, 7, 1);
                    CHECK(std::accumulate(weights.begin(), weights.end(), 0.0) == close_to(double(count), 1e-5));
                    for (std::uint32_t index = 0; index < count; ++index)
                        sums[index] += double{weights[index]} * (part.end - part.first) / samples;
                }
                for (const double sum : sums)
                    CHECK(sum == close_to(1.0, 1e-5));
            }
}

TEST_CASE("pictures that are taken together have what they would have had one by one") {
    const std::vector<SeriesPart> parts = parts_of(16, 16);
    std::vector<float> sums(64, 0.0f);
    for (std::size_t index = 3; index < 8; ++index)
        for (std::size_t stratum = 0; const float weight : dealt_weights(64, 4, parts[index], 0, 0))
            sums[stratum++] += weight / 5.0f;
    const std::vector<float> together = dealt_weights(64, 4, {3, 8, 16, 16}, 0, 0);
    for (std::size_t stratum = 0; stratum < sums.size(); ++stratum)
        CHECK(together[stratum] == doctest::Approx(sums[stratum]));
}

TEST_CASE("a picture has few strata, one in each quarter of both of their numbers") {
    for (const SeriesPart& part : parts_of(16, 16)) {
        const std::vector<float> weights = dealt_weights(64, 4, part, 3, 2);
        std::array<int, 4> across{}, along{};
        for (std::uint32_t index = 0; index < 64; ++index)
            if (weights[index] > 0.0f) {
                const vec3 place = stratum(index, 64, 0); // which shifts all alike, by less than a stratum
                ++across[static_cast<std::size_t>(4.0f * place.x)];
                ++along[static_cast<std::size_t>(4.0f * (place.y - 0.5f / 64.0f))];
            }
        CHECK(across == std::array{1, 1, 1, 1});
        CHECK(along == std::array{1, 1, 1, 1});
    }
}
} // namespace dealt_strata_test
