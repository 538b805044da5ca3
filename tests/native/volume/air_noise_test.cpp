// SPDX-License-Identifier: GPL-3.0-or-later
// The noise volume: it tiles, its mean is known to rounding, its contrast is that of a normal distribution whatever the
// octaves, and it looks alike in all directions to a stated bound.
#include "core/errors.hpp"
#include "volume/air_noise.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

namespace air_noise_test {
using namespace tyndall;

namespace {
AirNoiseVolume volume_of(const AirNoise& noise) { return {noise, Progress()}; }

/// Of the finest level, in units of its range.
double deviation(const AirNoiseVolume& volume) {
    double sum = 0.0;
    for (const std::uint8_t texel : volume.texels(0)) {
        const double away = (static_cast<double>(texel) - double{volume.mean(0)}) / 255.0;
        sum += away * away;
    }
    return std::sqrt(sum / static_cast<double>(volume.texels(0).size()));
}
/// Mean squared difference between texels that lie `offset` apart, around the cube.
double structure(const AirNoiseVolume& volume, const glm::ivec3& offset) {
    const int side = static_cast<int>(volume.side(0));
    const auto at = [&](int x, int y, int z) {
        const int mask = side - 1;
        return static_cast<double>(
            volume.texels(0)[static_cast<std::size_t>(((z & mask) * side + (y & mask)) * side + (x & mask))]);
    };
    double sum = 0.0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double difference = at(x + offset.x, y + offset.y, z + offset.z) - at(x, y, z);
                sum += difference * difference;
            }
    return sum / std::pow(side, 3);
}
} // namespace

TEST_CASE("the cube tiles: across its border the noise changes as little as inside") {
    const AirNoiseVolume volume = volume_of({.octaves = 2, .resolution = 64});
    const auto side = static_cast<int>(volume.side(0));
    int largest_inside = 0, largest_across = 0;
    for (int b = 0; b < side; ++b)
        for (int a = 0; a < side; ++a)
            for (int c = 0; c < side; ++c)
                for (const int axis : {0, 1, 2}) {
                    const auto texel = [&](int along) {
                        const int x = axis == 0 ? along : a, y = axis == 1 ? along : (axis == 0 ? a : b),
                                  z = axis == 2 ? along : b;
                        return int{volume.texels(0)[static_cast<std::size_t>((z * side + y) * side + x)]};
                    };
                    int& largest = c + 1 < side ? largest_inside : largest_across;
                    largest = std::max(largest, std::abs(texel((c + 1) % side) - texel(c)));
                }
    CHECK(largest_across <= largest_inside);
    for (const dvec3& place : {dvec3(0.1, 0.7, 0.4), dvec3(0.999, 0.001, 0.5)})
        for (const dvec3& period : {dvec3(1, 0, 0), dvec3(0, -3, 0), dvec3(7, 5, 11)})
            CHECK(std::abs(volume.relative_at(place + period, 1) / volume.relative_at(place, 1) - 1.0f) < 1e-5f);
}

TEST_CASE("divided by its mean the noise keeps the light, at every level") {
    for (const AirNoise& noise : {AirNoise{.resolution = 64}, AirNoise{.octaves = 1, .resolution = 32, .seed = 3},
                                  AirNoise{.octaves = 8, .persistence = 1.0f, .resolution = 16}}) {
        const AirNoiseVolume volume = volume_of(noise);
        REQUIRE(volume.level_count() == static_cast<std::uint32_t>(std::log2(noise.resolution)) + 1);
        for (std::uint32_t level = 0; level < volume.level_count(); ++level) {
            const std::uint32_t side = volume.side(level);
            double sum = 0.0;
            for (std::uint32_t z = 0; z < side; ++z)
                for (std::uint32_t y = 0; y < side; ++y)
                    for (std::uint32_t x = 0; x < side; ++x)
                        sum += double{volume.relative_at((dvec3(x, y, z) + 0.5) / static_cast<double>(side), level)};
            CHECK(std::abs(sum / std::pow(side, 3) - 1.0) < 1e-6); // sums of floats with 24 bits
        }
        // The last level is one texel: the air is even there.
        CHECK(volume.relative_at(dvec3(0.3, 0.2, 0.9), volume.level_count() - 1) == 1.0f);
    }
}

TEST_CASE("a level is the box-filtered one before it") {
    const AirNoiseVolume volume = volume_of({.resolution = 32});
    const auto coarse = volume.texels(1), fine = volume.texels(0);
    for (std::size_t z = 0; z < 16; ++z)
        for (std::size_t y = 0; y < 16; ++y)
            for (std::size_t x = 0; x < 16; ++x) {
                int sum = 0;
                for (std::size_t corner = 0; corner < 8; ++corner)
                    sum += fine[((2 * z + corner / 4) * 32 + 2 * y + corner / 2 % 2) * 32 + 2 * x + corner % 2];
                REQUIRE(std::abs(coarse[(z * 16 + y) * 16 + x] - sum / 8.0) <= 0.5);
            }
}

// Seen to fail with the amplitudes not divided by the deviation of their sum.
TEST_CASE("its contrast is a sixth of its range, whatever the octaves: three deviations fill it") {
    for (const AirNoise& noise : {AirNoise{.octaves = 1, .resolution = 128}, AirNoise{.octaves = 4, .resolution = 128},
                                  AirNoise{.octaves = 4, .persistence = 1.0f, .resolution = 128, .seed = 9},
                                  AirNoise{.octaves = 8, .persistence = 0.7f, .resolution = 128}}) {
        const AirNoiseVolume volume = volume_of(noise);
        // 512 independent cells of the coarsest octave: a deviation of their variance of some 6 %, of which 3 count.
        CHECK(std::abs(deviation(volume) * 6.0 - 1.0) < 0.1);
        CHECK(std::abs(double{volume.mean(0)} / 127.5 - 1.0) < 0.05);
    }
}

TEST_CASE("contrast spreads the noise around its middle; what it cuts does not change its mean") {
    const AirNoise even{.octaves = 3, .contrast = 0.0f, .resolution = 64},
        half{.octaves = 3, .contrast = 0.5f, .resolution = 64}, cut{.octaves = 3, .contrast = 6.0f, .resolution = 64};
    CHECK(deviation(volume_of(even)) == 0.0);
    CHECK(std::abs(deviation(volume_of(half)) / deviation(volume_of({.octaves = 3, .resolution = 64})) - 0.5) < 0.01);
    const AirNoiseVolume volume = volume_of(cut);
    CHECK(std::ranges::count(volume.texels(0), 0) > std::ssize(volume.texels(0)) / 5); // beyond half a deviation: 31 %
    CHECK(std::abs(double{volume.mean(0)} / 127.5 - 1.0) < 0.1);
}

TEST_CASE("octaves double their frequency, fade with the persistence, and differ by their seed") {
    const auto texels = [](const AirNoise& noise) {
        const AirNoiseVolume volume = volume_of(noise);
        return std::vector<std::uint8_t>(volume.texels(0).begin(), volume.texels(0).end());
    };
    // Without persistence the first octave is all there is.
    CHECK(texels({.octaves = 1, .resolution = 64}) == texels({.octaves = 3, .persistence = 0.0f, .resolution = 64}));
    // Octaves that texels cannot show are none.
    CHECK(texels({.octaves = 3, .resolution = 64}) == texels({.octaves = 8, .resolution = 64}));
    CHECK(texels({.resolution = 64}) != texels({.resolution = 64, .seed = 1}));
    // Half a feature apart the second octave differs as much as the first does a whole feature apart.
    const AirNoiseVolume one = volume_of({.octaves = 1, .resolution = 64}),
                         two = volume_of({.octaves = 2, .persistence = 1.0f, .resolution = 64});
    CHECK(structure(two, {1, 0, 0}) > 1.8 * structure(one, {1, 0, 0}));
    CHECK(structure(two, {1, 0, 0}) < 4.0 * structure(one, {1, 0, 0}));
}

// Seen to fail with gradients that have no y.
TEST_CASE("no direction is preferred by more than a quarter") {
    // Of 4 texels in 8 per feature: along axes, diagonals of faces (4.24) and of the cube (3.46), scaled to one length.
    const AirNoiseVolume volume = volume_of({.octaves = 3, .resolution = 64});
    double least = 1e9, most = 0.0;
    for (const glm::ivec3& offset :
         {glm::ivec3(4, 0, 0), glm::ivec3(0, 4, 0), glm::ivec3(0, 0, 4), glm::ivec3(3, 3, 0), glm::ivec3(3, 0, -3),
          glm::ivec3(0, 3, 3), glm::ivec3(2, 2, 2), glm::ivec3(-2, 2, 2)}) {
        const double length = glm::length(dvec3(offset));
        const double per_length = structure(volume, offset) / length;
        CAPTURE(offset.x);
        CAPTURE(offset.y);
        CAPTURE(offset.z);
        CAPTURE(per_length);
        least = std::min(least, per_length);
        most = std::max(most, per_length);
    }
    CAPTURE(least);
    CAPTURE(most);
    CHECK(most / least < 1.25);
}

TEST_CASE("bits do not depend on threads, and the last two volumes are kept") {
    const AirNoise noise{.resolution = 64};
    AirNoiseCache cache;
    const auto first = cache.find_or_make(noise, Progress());
    AirNoise scaled = noise;
    scaled.scale_m = 7.0f; // no part of the volume
    CHECK(cache.find_or_make(scaled, Progress()) == first);
    const auto other = cache.find_or_make({.resolution = 32}, Progress());
    CHECK(cache.find_or_make(noise, Progress()) == first);
    (void)cache.find_or_make({.resolution = 16}, Progress());
    CHECK(cache.find_or_make(noise, Progress()) == first);
    CHECK(cache.find_or_make({.resolution = 32}, Progress()) != other);
}

TEST_CASE("a noise that cannot be is refused by name") {
    const auto refused = [](const AirNoise& noise, const char* message) {
        CHECK_THROWS_WITH_AS((void)volume_of(noise), message, InvalidInput);
    };
    refused({.octaves = 0}, "octaves of the air's noise is 0, outside [1, 8]");
    refused({.persistence = -0.5f}, "persistence of the air's noise is -0.5, outside [0, 1]");
    refused({.contrast = 11.0f}, "contrast of the air's noise is 11, outside [0, 10]");
    refused({.resolution = 48}, "resolution of the air's noise is 48, not a power of two in [16, 512]");
    refused({.resolution = 8}, "resolution of the air's noise is 8, not a power of two in [16, 512]");
    Progress cancelled;
    cancelled.cancel();
    CHECK_THROWS_AS(AirNoiseVolume({.resolution = 16}, cancelled), Cancelled);
}
} // namespace air_noise_test
