// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/file_of_version_1.hpp"
#include "support/mutated_bytes.hpp"
#include "support/packed_voxels.hpp"
#include "support/random_attributes.hpp"
#include "support/voxel_rays.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/tracer.hpp"
#include <doctest/doctest.h>
#include <fstream>
#include <iterator>
#include <random>
#include <unistd.h>

namespace dag_file_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
const Progress progress;
constexpr double side_m = 0.1; // no number of bits holds it
const Cube place{.lower_m = dvec3(-1.5, 2e5, 1e-3), .side_m = side_m};

/// A file that goes with the test.
class TestFile {
public:
    TestFile()
        : path_(std::filesystem::temp_directory_path() / ("tyndall_dag_test_" + std::to_string(getpid()) + ".tdag")) {}
    TestFile(const TestFile&) = delete;
    TestFile& operator=(const TestFile&) = delete;
    ~TestFile() { std::filesystem::remove(path_); }

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    [[nodiscard]] std::string bytes() const {
        std::ifstream file(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    void replace(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
    /// What reading it complains of; "" where it does not.
    [[nodiscard]] std::string complaint() const {
        try {
            static_cast<void>(read_dag(path_, progress));
        } catch (const IoError& error) {
            return error.what();
        }
        return "";
    }

private:
    std::filesystem::path path_;
};
} // namespace

TEST_CASE("a file gives back the DAG that was written, bit by bit, and its place in metres") {
    const TestFile file;
    for (const Symmetry symmetry : all_symmetries)
        for (const LeafMasks& voxels :
             {sphere_voxels(7, {64, 64, 64}, 50), random_voxels(5, 0.01, 3), sierpinski_voxels(6), full_voxels(2),
              full_voxels(6), LeafMasks{.level = 9, .codes = {}, .masks = {}}}) {
            const PackedDag dag = packed(voxels, symmetry);
            write_dag(dag, place, file.path(), progress);
            const PlacedDag read = read_dag(file.path(), progress);
            REQUIRE(read.dag == dag);
            REQUIRE(read.bounds_m.lower_m == place.lower_m);
            REQUIRE(read.bounds_m.side_m == side_m);
        }
}

TEST_CASE("a file gives back the attributes that were written, byte by byte, and none where there were none") {
    const TestFile file;
    for (const Symmetry symmetry : all_symmetries)
        for (const LeafMasks& voxels : {sphere_voxels(7, {64, 64, 64}, 20), random_voxels(2, 0.3, 3), full_voxels(4)})
            for (const bool has_means : {false, true}) {
                PlacedDag placed{.dag = packed(voxels, symmetry), .bounds_m = place};
                VoxelAttributes attributes = random_attributes(placed.dag.voxel_count, 3);
                attributes.colors.resize(has_means ? attributes.colors.size() : 0);
                placed.attributes = encode_attributes(
                    placed.dag, attributes, {.normal_bits = has_means ? 32u : 11u, .has_means = has_means}, progress);
                write_dag(placed, file.path(), progress);
                const PlacedDag read = read_dag(file.path(), progress);
                REQUIRE(read.dag == placed.dag);
                REQUIRE(read.attributes);
                REQUIRE(read.attributes->parts() == placed.attributes->parts());
                write_dag(placed.dag, place, file.path(), progress);
                REQUIRE_FALSE(read_dag(file.path(), progress).attributes);
            }
}

TEST_CASE("a damaged byte of attributes is found, and the section is named") {
    const TestFile file;
    PlacedDag placed{.dag = packed(sphere_voxels(7, {64, 64, 64}, 12), Symmetry::Cube), .bounds_m = place};
    placed.attributes = encode_attributes(placed.dag, random_attributes(placed.dag.voxel_count, 3), {}, progress);
    write_dag(placed, file.path(), progress);
    const std::string whole = file.bytes();
    const auto [order, voxels, means] = [&] {
        const AttributeParts& parts = placed.attributes->parts();
        return std::tuple(parts.order, parts.voxels, parts.means);
    }();
    const auto check = [&](const auto& section, const std::string& name) {
        const std::size_t bytes = section.size() * sizeof(section[0]);
        const std::size_t at = whole.find(std::string(reinterpret_cast<const char*>(section.data()), bytes));
        REQUIRE(at != std::string::npos);
        for (const std::size_t inside : {std::size_t{0}, bytes / 2, bytes - 1}) {
            std::string changed = whole;
            changed[at + inside] ^= 4;
            file.replace(changed);
            CHECK(file.complaint() == file.path().string() + ": " + name + " are damaged: copy or save the file again");
        }
    };
    check(order.counts, "the counts of voxels");
    check(voxels.materials, "the materials");
    check(voxels.indices, "the voxels' materials");
    check(means.materials, "the materials of means");
    check(means.indices, "the nodes' means");
    check(std::string("noise"), "the names of the attributes");
}

TEST_CASE("a file that ends early is refused, wherever it ends, and says so") {
    const TestFile file;
    write_dag(packed(sphere_voxels(6, {30, 30, 30}, 25), Symmetry::Cube), place, file.path(), progress);
    const std::string whole = file.bytes();
    for (std::size_t length = 0; length < whole.size(); length += 7) {
        CAPTURE(length);
        file.replace(whole.substr(0, length));
        const std::string complaint = file.complaint();
        REQUIRE(complaint.starts_with(file.path().string() + ": "));
        REQUIRE(complaint.find(length < 104 ? "header" : "bytes instead of") != std::string::npos);
    }
    file.replace(whole + "x");
    CHECK(file.complaint().find("bytes instead of") != std::string::npos);
}

TEST_CASE("a byte that has changed is found, but for those between sections, and the section is named") {
    const TestFile file;
    const PackedDag dag = packed(sphere_voxels(6, {30, 30, 30}, 25), Symmetry::Reflections);
    write_dag(dag, place, file.path(), progress);
    const std::string whole = file.bytes();
    std::mt19937 random(4);
    std::size_t unnoticed = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
        CAPTURE(at);
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ static_cast<char>(1 + random() % 255));
        file.replace(changed);
        if (const std::string complaint = file.complaint(); complaint.empty()) {
            REQUIRE(read_dag(file.path(), progress).dag == dag);
            ++unnoticed;
        }
    }
    CHECK(unnoticed < 64 * 9); // sections begin at multiples of 64
    std::string changed = whole;
    changed[whole.size() - 20] ^= 1;
    file.replace(changed);
    CHECK(file.complaint() == file.path().string() + ": the records are damaged: copy or save the file again");
}

TEST_CASE("what is no such file, and one of a newer version, is told apart from what is damaged") {
    const TestFile file;
    CHECK(file.complaint().find("No such file") != std::string::npos);
    file.replace(std::string(200, 'x'));
    CHECK(file.complaint().find("no .tdag file") != std::string::npos);
    write_dag(packed(full_voxels(3), Symmetry::None), place, file.path(), progress);
    std::string newer = file.bytes();
    newer[8] = 4;
    file.replace(newer);
    CHECK(file.complaint().find("version 4") != std::string::npos);
}

TEST_CASE("a file of version 1 gives its voxels, along rays, too, and is written again as one of today") {
    const TestFile file;
    file.replace({reinterpret_cast<const char*>(file_of_version_1.data()), 8 * file_of_version_1.size()});
    const LeafMasks voxels = sphere_voxels(6, {33, 30, 29}, 25);
    for (int time = 0; time < 2; ++time) {
        const PlacedDag read = read_dag(file.path(), progress);
        CHECK(read.bounds_m.lower_m == dvec3(-1, 0, 2));
        LeafMasks all{.level = 6, .codes = {}, .masks = {}};
        decode(
            read.dag, 1 << 20, [&](const LeafMasks& part) { all = part; }, progress);
        CHECK(all == voxels);
        std::vector<VoxelRay> rays = assorted_rays(listed(voxels), 64.0, 2000);
        std::vector<VoxelHit> hits(rays.size());
        Tracer(read.dag).trace(rays, hits, progress);
        const PackedDag today = packed(voxels, Symmetry::Cube);
        for (std::size_t i = 0; i < rays.size(); ++i)
            REQUIRE(hits[i] == trace(today, rays[i]));
        write_dag(read, file.path(), progress);
    }
}

TEST_CASE("a file that cannot be written leaves the one that was there, and a cancelled call, too") {
    const TestFile file;
    const PackedDag dag = packed(full_voxels(3), Symmetry::None);
    CHECK_THROWS_AS(write_dag(dag, place, "/nowhere/a.tdag", progress), IoError);
    write_dag(dag, place, file.path(), progress);
    Progress cancelled;
    cancelled.cancel();
    const PackedDag other = packed(sphere_voxels(6, {30, 30, 30}, 25), Symmetry::Cube);
    CHECK_THROWS_AS(write_dag(other, place, file.path(), cancelled), Cancelled);
    CHECK(read_dag(file.path(), progress).dag == dag);
    CHECK_THROWS_AS(static_cast<void>(read_dag(file.path(), cancelled)), Cancelled);
}

/// Checksums guard every byte that counts: what is read after all is what was written.
static void mutate_and_read(int times, std::uint32_t seed) {
    const TestFile file;
    PlacedDag placed{.dag = packed(sphere_voxels(6, {30, 30, 30}, 25), Symmetry::Cube), .bounds_m = place};
    placed.attributes = encode_attributes(placed.dag, random_attributes(placed.dag.voxel_count, 5), {}, progress);
    write_dag(placed, file.path(), progress);
    const std::string whole = file.bytes();
    std::mt19937 random(seed);
    int refused_count = 0;
    for (int time = 0; time < times; ++time) {
        file.replace(mutated(whole, random));
        try {
            const PlacedDag read = read_dag(file.path(), progress);
            REQUIRE(read.dag == placed.dag);
            REQUIRE(read.attributes->parts() == placed.attributes->parts());
        } catch (const IoError& error) {
            REQUIRE(std::string(error.what()).starts_with(file.path().string() + ": "));
            ++refused_count;
        }
    }
    CHECK(refused_count > times * 9 / 10);
}
TEST_CASE("a .tdag file that was changed anywhere is refused, or read as it was written") { mutate_and_read(300, 6); }
TEST_CASE("10,000 .tdag files that were changed anywhere are refused, or read as they were" *
          doctest::test_suite("long")) {
    mutate_and_read(10000, 7);
}
} // namespace dag_file_test
