// SPDX-License-Identifier: GPL-3.0-or-later
#include "image/srgb.hpp"
#include "support/close_to.hpp"
#include "support/packed_voxels.hpp"
#include "support/random_attributes.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/cielab.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace dag_attributes_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
const Progress progress;

vec3 normal_of(std::uint32_t code) { return vec3(octahedral::decode(code, 32)); }

/// Voxel `number`, as it was given.
VoxelSample given(const VoxelAttributes& attributes, std::size_t number) {
    VoxelSample sample{.color = attributes.colors[number], .normal = normal_of(attributes.normals[number])};
    for (std::size_t i = 0; i < attributes.channels.size(); ++i)
        sample.channels[i] = attributes.channels[i].values[number];
    return sample;
}

/// How many voxels come back as they were given, before the first that does not.
std::size_t right_count(const PackedDag& dag, const DagAttributes& kept, const std::vector<Voxel>& voxels,
                        const VoxelAttributes& attributes) {
    std::size_t number = 0;
    while (number < voxels.size() && kept.sample_at(dag, voxels[number], 0) == given(attributes, number))
        ++number;
    return number;
}

void require_lossless(const LeafMasks& voxels, Symmetry symmetry, std::uint32_t seed) {
    const PackedDag dag = packed(voxels, symmetry);
    const VoxelAttributes attributes = random_attributes(dag.voxel_count, seed);
    const auto kept = encode_attributes(dag, attributes, {}, progress);
    REQUIRE(right_count(dag, *kept, listed(voxels), attributes) == dag.voxel_count);
    REQUIRE(kept->parts().errors == AttributeErrors{});
}
double degrees_between(const vec3& a, const vec3& b) {
    const dvec3 u(a), v(b);
    return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v)) * 180.0 / std::numbers::pi;
}
PackedColor packed_color(std::uint32_t color) { return (color & 255) << 16 | (color & 0xff00) | color >> 16; }

/// Attributes of one kind of the two.
VoxelAttributes colors_only(std::vector<std::uint32_t> colors) {
    return {.colors = std::move(colors), .normals = {}, .channels = {}};
}
} // namespace

// Seen to fail with values in Morton order in place of stored order.
TEST_CASE("every voxel's colour, normal and channels come back as they were given, under each symmetry") {
    for (const Symmetry symmetry : all_symmetries) {
        for (std::uint32_t level = leaf_level; level <= 8; ++level)
            require_lossless(random_voxels(level, level < 6 ? 0.1 : 3e-4, level), symmetry, level);
        for (std::uint32_t seed = 0; seed < 4; ++seed)
            require_lossless(kaleidoscope_voxels(5, seed), symmetry, seed);
        require_lossless(sphere_voxels(8, {99.3, 130, 140}, 30), symmetry, 3);
        require_lossless(leaf_masks_of({{131071, 7, 65536}}, 17), symmetry, 4);
    }
}

TEST_SUITE("long") {
    TEST_CASE("every voxel of dense sets comes back, up to 256^3") {
        for (const Symmetry symmetry : all_symmetries)
            for (const double probability : {0.01, 0.3, 1.0})
                require_lossless(random_voxels(8, probability, 1), symmetry, 5);
    }
}

TEST_CASE("means of cubes are those of their voxels, in linear light, at every level") {
    const LeafMasks voxels = sphere_voxels(7, {49.3, 60, 70}, 40);
    const std::vector<Voxel> list = listed(voxels);
    std::vector<VoxelSample> of_none; // at the first voxel, whatever the symmetry
    for (const Symmetry symmetry : all_symmetries) {
        const PackedDag dag = packed(voxels, symmetry);
        const VoxelAttributes attributes = random_attributes(dag.voxel_count, 6);
        const auto kept = encode_attributes(dag, attributes, {}, progress);
        for (std::uint32_t level = 1; level <= 8; ++level) {
            for (std::size_t asked = 0; asked < list.size(); asked += 2999) {
                dvec3 light(0.0), normal(0.0), channels(0.0);
                double count = 0.0;
                for (std::size_t i = 0; i < list.size(); ++i) {
                    if (morton_code(list[i]) >> 3 * level != morton_code(list[asked]) >> 3 * level)
                        continue;
                    for (std::uint32_t k = 0; k < 3; ++k)
                        light[static_cast<int>(k)] += static_cast<double>(
                            linear_from_srgb(static_cast<float>(attributes.colors[i] >> 8 * k & 255) / 255.0f));
                    normal += dvec3(normal_of(attributes.normals[i]));
                    for (std::size_t k = 0; k < 2; ++k)
                        channels[static_cast<int>(k)] += attributes.channels[k].values[i];
                    ++count;
                }
                const VoxelSample mean = *kept->sample_at(dag, list[asked], level);
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const auto linear = static_cast<float>(light[static_cast<int>(k)] / count);
                    REQUIRE(std::abs(static_cast<float>(mean.color >> 8 * k & 255) -
                                     255.0f * srgb_from_linear(linear)) < 0.51f);
                }
                REQUIRE(degrees_between(mean.normal, vec3(glm::normalize(normal))) <
                        octahedral::most_error_degrees(16) + 1e-3);
                for (std::size_t k = 0; k < 2; ++k)
                    REQUIRE(std::abs(mean.channels[k] - channels[static_cast<int>(k)] / count) <= 0.5);
                if (asked == 0 && symmetry == Symmetry::None)
                    of_none.push_back(mean);
                else if (asked == 0)
                    REQUIRE(mean == of_none[level - 1]);
            }
        }
    }
}

TEST_CASE("normals that cancel out have a mean all the same, of length 1") {
    const LeafMasks voxels = full_voxels(2);
    const PackedDag dag = packed(voxels, Symmetry::None);
    VoxelAttributes attributes{.colors = {}, .normals = {}, .channels = {}};
    for (std::uint32_t i = 0; i < 64; ++i)
        attributes.normals.push_back(octahedral::encode({i % 2 == 0 ? 1.0 : -1.0, 0.0, 0.0}, 32));
    const auto kept = encode_attributes(dag, attributes, {}, progress);
    CHECK(kept->sample_at(dag, {0, 0, 0}, 2)->normal == vec3(0, 0, 1));
    CHECK(kept->sample_at(dag, {1, 0, 0}, 0)->normal == vec3(-1, 0, 0));
}

TEST_CASE("colours stay within the chosen difference, or are as few as chosen, and errors are those of all voxels") {
    const LeafMasks voxels = sphere_voxels(7, {49.3, 60, 70}, 40);
    const PackedDag dag = packed(voxels, Symmetry::Cube);
    const std::vector<Voxel> list = listed(voxels);
    const VoxelAttributes attributes = colors_only(random_attributes(dag.voxel_count, 7).colors);
    for (const AttributeConfig& config :
         {AttributeConfig{.color_count = 100}, AttributeConfig{.most_color_difference = 3.0}}) {
        const auto kept = encode_attributes(dag, attributes, config, progress);
        std::vector<std::uint32_t> used;
        double sum = 0.0, most = 0.0;
        for (std::size_t i = 0; i < list.size(); ++i) {
            used.push_back(kept->sample_at(dag, list[i], 0)->color);
            const double difference =
                cie94(lab_of(packed_color(attributes.colors[i])), lab_of(packed_color(used.back())));
            sum += difference, most = std::max(most, difference);
        }
        CHECK(most == close_to(kept->parts().errors.most_cie94, 1e-9));
        CHECK(sum / static_cast<double>(list.size()) == close_to(kept->parts().errors.mean_cie94, 1e-9));
        std::ranges::sort(used);
        used.erase(std::ranges::unique(used).begin(), used.end());
        if (config.color_count > 0)
            CHECK(used.size() <= 100);
        else
            CHECK(most <= 3.0 + 1e-9);
        CHECK(kept->parts().voxels.materials.size() <
              encode_attributes(dag, attributes, {}, progress)->parts().voxels.materials.size());
    }
}

TEST_CASE("normals of fewer bits are within their bound, and errors are those of all voxels") {
    const LeafMasks voxels = sphere_voxels(6, {30, 30, 30}, 25);
    const PackedDag dag = packed(voxels, Symmetry::Cube);
    const std::vector<Voxel> list = listed(voxels);
    VoxelAttributes attributes = random_attributes(dag.voxel_count, 8);
    for (const std::uint32_t bits : {8u, 12u, 16u, 31u}) {
        const auto kept = encode_attributes(dag, attributes, {.normal_bits = bits}, progress);
        double sum = 0.0, most = 0.0;
        for (std::size_t i = 0; i < list.size(); ++i) {
            const VoxelSample sample = *kept->sample_at(dag, list[i], 0);
            REQUIRE(sample.color == attributes.colors[i]);
            const double degrees = degrees_between(sample.normal, normal_of(attributes.normals[i]));
            sum += degrees, most = std::max(most, degrees);
        }
        CHECK(most < octahedral::most_error_degrees(bits) + 1e-5);
        CHECK(std::abs(most - kept->parts().errors.most_degrees) < 1e-5); // directions here are of floats
        CHECK(std::abs(sum / static_cast<double>(list.size()) - kept->parts().errors.mean_degrees) < 1e-5);
    }
}

TEST_CASE("the same bytes for 1, 2 and 7 threads") {
    const LeafMasks voxels = sphere_voxels(10, {500.7, 512, 470.2}, 61.3);
    const PackedDag dag = packed(voxels, Symmetry::Cube);
    const VoxelAttributes attributes = random_attributes(dag.voxel_count, 9);
    const AttributeConfig config{.color_count = 64, .normal_bits = 12};
    const auto encoded = [&] { return encode_attributes(dag, attributes, config, progress); };
    const auto one = with_exactly(1, encoded);
    CHECK(with_exactly(2, encoded)->parts() == one->parts());
    CHECK(with_exactly(7, encoded)->parts() == one->parts());
}

TEST_CASE("what was not given is not there, and voxels that are not set are named") {
    const LeafMasks voxels = random_voxels(5, 0.01, 5);
    const PackedDag dag = packed(voxels, Symmetry::Cube);
    const std::vector<Voxel> list = listed(voxels);
    const auto kept = encode_attributes(dag, colors_only(random_attributes(dag.voxel_count, 1).colors),
                                        {.has_means = false}, progress);
    CHECK(colors_at(dag, *kept, list, 3, progress).size() == list.size());
    CHECK_THROWS_WITH_AS(static_cast<void>(normals_at(dag, *kept, list, 0, progress)), "the voxel DAG has no normals",
                         InvalidInput);
    CHECK_THROWS_WITH_AS(static_cast<void>(channel_at(dag, *kept, "a", list, 0, progress)),
                         "the voxel DAG has no channel 'a'", InvalidInput);
    CHECK_THROWS_WITH_AS(static_cast<void>(colors_at(dag, *kept, list, 4, progress)),
                         "attributes: there are no means of 16^3 voxels; level 3 is the largest", InvalidInput);
    const std::vector<Voxel> asked{list[0], {40, 0, 0}, {41, 0, 0}};
    CHECK_THROWS_WITH_AS(static_cast<void>(colors_at(dag, *kept, asked, 0, progress)),
                         "voxel 1 of those asked for, (40, 0, 0), is not set", InvalidInput);
}

TEST_CASE("arrays that do not fit the voxels, and settings out of range, are named") {
    const PackedDag dag = packed(random_voxels(5, 0.01, 5), Symmetry::Cube);
    const VoxelAttributes right = random_attributes(dag.voxel_count, 1);
    const auto complaint = [&](const VoxelAttributes& attributes, const AttributeConfig& config) -> std::string {
        try {
            static_cast<void>(encode_attributes(dag, attributes, config, progress));
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    VoxelAttributes wrong = right;
    wrong.normals.pop_back();
    CHECK(complaint(wrong, {}).find("normals for") != std::string::npos);
    wrong = right;
    wrong.channels[1].name = "rough";
    CHECK(complaint(wrong, {}) == "attributes: two channels are 'rough'");
    wrong.channels[1] = {"noise", {1}};
    CHECK(complaint(wrong, {}).find("channel 'noise'") != std::string::npos);
    wrong.channels.resize(5);
    CHECK(complaint(wrong, {}).find("5 channels") != std::string::npos);
    CHECK(complaint(right, {.color_count = 4, .most_color_difference = 1.0}).find("one of them") != std::string::npos);
    CHECK(complaint(right, {.normal_bits = 7}).find("normal_bits is 7") != std::string::npos);
}
} // namespace dag_attributes_test
