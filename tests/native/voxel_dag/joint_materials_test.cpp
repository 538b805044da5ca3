// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "native/voxel_dag/attribute_sequences.hpp"
#include "voxel_dag/joint_materials.hpp"
#include "voxel_dag/run_array.hpp"
#include <array>
#include <doctest/doctest.h>
#include <set>

namespace joint_materials_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using Columns = std::vector<std::span<const std::uint32_t>>;

TEST_CASE("a joint material holds the attributes of its entries, and each combination is one") {
    const test::Values colors = test::random_runs(20000, 50, 90, 1),
                       normals = test::random_runs(20000, 1u << 30, 95, 2),
                       reflectances = test::random_runs(20000, 1, 0, 3);
    const JointMaterials joint = join(Columns{colors, normals, reflectances}, {});
    std::set<std::array<std::uint32_t, 3>> different;
    for (std::size_t i = 0; i < colors.size(); ++i)
        different.insert({colors[i], normals[i], reflectances[i]});
    REQUIRE(joint.columns.size() == 3);
    REQUIRE(joint.columns[0].size() == different.size());
    std::size_t material = 0;
    for (const auto& [color, normal, reflectance] : different) { // in this order
        REQUIRE(joint.columns[0][material] == color);
        REQUIRE(joint.columns[1][material] == normal);
        REQUIRE(joint.columns[2][material] == reflectance);
        ++material;
    }
    const std::vector<std::uint8_t> columns = encode_columns(joint), indices = run_array::encode(joint.indices, {}, {});
    const MaterialTable table(columns);
    const RunArray array(indices);
    CHECK(table.material_count() == different.size());
    CHECK(table.attribute_count() == 3);
    for (std::size_t i = 0; i < colors.size(); ++i) {
        REQUIRE(table.at(array.at(i), 0) == colors[i]);
        REQUIRE(table.at(array.at(i), 1) == normals[i]);
        REQUIRE(table.at(array.at(i), 2) == reflectances[i]);
    }
}

TEST_CASE("attributes that change together cost little more than one of them") {
    const test::Values colors = test::random_runs(100000, 500, 80, 4);
    test::Values normals;
    for (const std::uint32_t color : colors)
        normals.push_back(color * 8191 + 5);
    const auto alone = run_array::encode(colors, {}, {});
    const JointMaterials joint = join(Columns{colors, normals}, {});
    CHECK(run_array::encode(joint.indices, {}, {}).size() == alone.size());
    CHECK(encode_columns(joint).size() < alone.size() / 10);
}

TEST_CASE("one attribute, and none of entries, are joint materials, too; arrays of two lengths are not") {
    const test::Values some{5, 5, 2}, none, two{1, 2};
    CHECK(join(Columns{some}, {}).columns == std::vector<test::Values>{{2, 5}});
    const JointMaterials empty = join(Columns{none, none}, {});
    CHECK(MaterialTable(encode_columns(empty)).material_count() == 0);
    CHECK_THROWS_WITH_AS(join(Columns{some, two}, {}), "joint materials: attribute 1 has 2 entries, attribute 0 has 3",
                         InvalidInput);
    CHECK_THROWS_AS(join(Columns{}, {}), InvalidInput);
}

TEST_CASE("a table that is cut off or damaged is refused, or every value can be read") {
    const test::Values colors = test::random_runs(500, 40, 50, 5), normals = test::random_runs(500, 4096, 50, 6);
    const std::vector<std::uint8_t> bytes = encode_columns(join(Columns{colors, normals}, {}));
    const auto complaint = [](const std::vector<std::uint8_t>& damaged) {
        try {
            const MaterialTable table(damaged);
            std::uint64_t sum = 0;
            for (std::uint32_t k = 0; k < table.attribute_count(); ++k)
                for (std::uint32_t i = 0; i < std::min(table.material_count(), 100000u); ++i)
                    sum += table.at(i, k);
            return std::string(sum == 0 ? "" : "read");
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
    };
    CHECK(complaint(bytes) == "read");
    CHECK(complaint({bytes.begin(), bytes.begin() + 13}).starts_with("material table: section 'widths' is cut off"));
    CHECK(complaint({bytes.begin(), bytes.begin() + 50}).starts_with("material table: section 'values' is cut off"));
    CHECK(complaint({bytes.begin(), bytes.end() - 1}).starts_with("material table: section 'end' is cut off"));
    test::Random random(7);
    for (int i = 0; i < 2000; ++i) {
        std::vector<std::uint8_t> damaged = bytes;
        damaged[random() % (i % 2 == 0 ? 20 : damaged.size())] = static_cast<std::uint8_t>(random());
        CHECK(complaint(damaged).size() < 200);
    }
}
} // namespace joint_materials_test
