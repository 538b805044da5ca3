// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/file_of_version_1.hpp"
#include "support/forged_file.hpp"
#include "support/packed_voxels.hpp"
#include "support/random_attributes.hpp"
#include "support/voxel_rays.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/coarse_cubes.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/node_shares.hpp"
#include "voxel_dag/tracer.hpp"
#include "voxel_dag/tree_counts.hpp"
#include "voxel_dag/voxel_shape.hpp"
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

namespace dag_forged_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
const Progress progress;
const Cube place{.lower_m = dvec3(-1.5, 2.0, 0.25), .side_m = 2.0};

class Path {
public:
    Path()
        : path_(std::filesystem::temp_directory_path() /
                ("tyndall_forged_test_" + std::to_string(getpid()) + ".tdag")) {}
    Path(const Path&) = delete;
    Path& operator=(const Path&) = delete;
    ~Path() { std::filesystem::remove(path_); }
    operator const std::filesystem::path&() const { return path_; } // NOLINT: it stands for one
    void replace(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
    [[nodiscard]] std::string bytes() const {
        std::ifstream file(path_, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
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

std::string file_of(const LeafMasks& voxels, Symmetry symmetry, bool has_attributes) {
    PlacedDag placed{.dag = packed(voxels, symmetry), .bounds_m = place};
    if (has_attributes)
        placed.attributes = encode_attributes(placed.dag, random_attributes(placed.dag.voxel_count, 5), {}, progress);
    const Path path;
    write_dag(placed, path, progress);
    return path.bytes();
}

/// Every way to ask. Under the sanitizers this is where a lie that was believed shows.
void ask_everything(const PlacedDag& read) {
    const PackedDag& dag = read.dag;
    std::vector<Voxel> voxels;
    std::uint64_t voxel_count = 0;
    decode(
        dag, 1 << 12,
        [&](const LeafMasks& part) {
            voxel_count += part.voxel_count();
            if (voxels.size() < 4000)
                for (const Voxel& voxel : listed(part))
                    voxels.push_back(voxel);
        },
        progress);
    REQUIRE(voxel_count == dag.voxel_count);
    const std::vector<TreeCounts> counts = tree_counts(dag, progress);
    if (dag.is_empty())
        return;
    REQUIRE(counts.back().tree_count == 1);
    bool is_right = true;
    for (std::size_t i = 0; i < voxels.size(); i += 7)
        is_right &= dag.contains(voxels[i]);
    static_cast<void>(coarse_cubes(dag, dag.level - 1, 1 << 14, progress));
    const Tracer tracer(dag);
    std::vector<VoxelRay> rays = rays_of_detail(voxels, dag.level, 256);
    const NodeShares shares = tracer.node_shares(progress);
    for (std::size_t i = 0; i < rays.size(); i += 2)
        rays[i].shares = &shares;
    for (const VoxelRay& ray : rays) {
        const VoxelHit hit = tracer.trace(ray);
        is_right &= ray.shares != nullptr || hit == trace(dag, ray);
    }
    REQUIRE(is_right);
    if (!read.attributes)
        return;
    for (std::uint32_t level = 0; level <= (read.attributes->has_means() ? dag.level : least_mean_level - 1); ++level)
        for (std::size_t i = level; i < voxels.size(); i += 17)
            is_right &= read.attributes->sample_at(dag, voxels[i], level).has_value();
    REQUIRE(is_right);
    const auto shape = make_voxel_shape(std::make_shared<const PlacedDag>(read), "forged");
    for (const VoxelRay& ray : rays)
        if (const CellHit hit =
                shape->closest_hit(Ray{.origin = vec3(read.bounds_m.lower_m), .direction = vec3(ray.direction)});
            hit.is_hit())
            static_cast<void>(shape->look(hit.cell));
}

void forge_and_read(int times, std::uint32_t seed) {
    const std::array wholes{
        file_of(sphere_voxels(7, {64, 64, 64}, 14), Symmetry::Cube, true),
        file_of(kaleidoscope_voxels(6, 4), Symmetry::Reflections, true),
        file_of(random_voxels(5, 0.01, 3), Symmetry::None, true),
        file_of(sphere_voxels(10, {514, 500, 520}, 9), Symmetry::Cube, true), // levels that threads share
        file_of(sierpinski_voxels(7), Symmetry::Cube, false),
        file_of(random_voxels(3, 0.2, 1), Symmetry::Cube, true),
        file_of(full_voxels(2), Symmetry::Cube, true),
        std::string(reinterpret_cast<const char*>(file_of_version_1.data()), 8 * file_of_version_1.size()),
    };
    const Path path;
    for (const std::string& whole : wholes) {
        path.replace(ForgedFile(whole).sealed());
        REQUIRE(path.complaint().empty());
    }
    std::mt19937 random(seed);
    int refused_count = 0;
    for (int time = 0; time < times; ++time) {
        CAPTURE(time);
        ForgedFile forged(wholes[static_cast<std::size_t>(time) % wholes.size()]);
        forged.lie(random);
        path.replace(forged.sealed());
        try {
            ask_everything(read_dag(path, progress));
        } catch (const IoError& error) {
            REQUIRE(std::string(error.what()).starts_with(std::filesystem::path(path).string() + ": "));
            ++refused_count;
        }
        try {
            static_cast<void>(read_top(path, 3, progress));
        } catch (const IoError&) { // it names the path as well
        }
    }
    MESSAGE(refused_count << " of " << times << " refused");
    CHECK(refused_count > times / 2);
    CHECK(refused_count < times);
}
} // namespace

TEST_CASE("a forged .tdag file is refused, or whatever is asked of it stays inside") { forge_and_read(300, 1); }
TEST_CASE("10,000 forged .tdag files are refused, or whatever is asked of them stays inside" *
          doctest::test_suite("long")) {
    forge_and_read(10000, 2);
}

TEST_CASE("a lie behind right checksums is named, with the file") {
    const std::string whole = file_of(sphere_voxels(9, {250, 260, 240}, 60), Symmetry::Cube, true);
    const Path path;
    const auto refuses = [&](const std::string& what, const auto& change) {
        ForgedFile forged(whole);
        change(forged);
        path.replace(forged.sealed());
        const std::string complaint = path.complaint();
        CAPTURE(what);
        CAPTURE(complaint);
        CHECK(complaint.starts_with(std::filesystem::path(path).string() + ": "));
        CHECK(complaint.find(what) != std::string::npos);
    };
    const auto add = [](ForgedFile& file, std::uint64_t offset, std::uint32_t by) {
        file.put(offset, file.at<std::uint32_t>(offset) + by);
    };
    refuses("entries instead of", [&](ForgedFile& file) { add(file, 32, 1); });
    refuses("nodes and leaves instead of", [&](ForgedFile& file) { add(file, 40, 1); });
    refuses("nowhere in space", [&](ForgedFile& file) { file.put(80, -1.0); });
    refuses("nowhere in space", [&](ForgedFile& file) { file.put(64, std::numeric_limits<double>::quiet_NaN()); });
    refuses("2^4000000000 voxels a side", [&](ForgedFile& file) { file.put(12, 4000000000u); });
    refuses("the leaves twice", [&](ForgedFile& file) {
        for (std::uint32_t i = 0; i < file.section_count(); ++i)
            if (file.section(i).kind == 4)
                file.put(ForgedFile::entry_of(i), 5u);
    });
    refuses("more bytes than it has", [&](ForgedFile& file) {
        for (std::uint32_t i = 0; i < file.section_count(); ++i) {
            file.put(ForgedFile::entry_of(i) + 8, std::uint64_t{0});
            file.put(ForgedFile::entry_of(i) + 16, std::uint64_t{whole.size()});
        }
    });
    refuses("which is none", [&](ForgedFile& file) { // a pair's tag; 48 turns take 6 bits
        const std::uint64_t pairs = file.section_of(4).offset;
        file.put(pairs, file.at<std::uint64_t>(pairs) | std::uint64_t{63} << file.at<std::uint32_t>(20));
    });
    refuses("has leaf", [&](ForgedFile& file) {
        const std::uint64_t pairs = file.section_of(4).offset;
        file.put(pairs, file.at<std::uint64_t>(pairs) | ((std::uint64_t{1} << file.at<std::uint32_t>(20)) - 1));
    });
    refuses("is empty", [&](ForgedFile& file) { file.put(file.section_of(5).offset, std::uint64_t{0}); });
    refuses("the next one begins", [&](ForgedFile& file) { add(file, file.section_of(2, 4).offset + 4, 1); });
    refuses("leaves the records", [&](ForgedFile& file) { file.put(file.section_of(2, 4).offset, 0xfffffff0u); });
    refuses("a pair that is not there", [&](ForgedFile& file) { // the first pairs of all classes lie behind the last
        const std::uint64_t begins = file.section_of(1).offset + 16;
        for (std::uint64_t at_class = 0; at_class < 4; ++at_class)
            file.put(begins + 4 * at_class, 0xffffff00u);
    });
    refuses("a record that is not there", [&](ForgedFile& file) {
        const std::uint64_t begins = file.section_of(1).offset + 400 + 16;
        for (std::uint64_t at_class = 0; at_class < 4; ++at_class)
            file.put(begins + 4 * at_class, 0x00ffff00u);
    });
    refuses("has no children", [&](ForgedFile& file) { // no mask of 8^3 has any
        const std::uint64_t masks = file.section_of(1).offset + 80;
        for (std::uint64_t mask = 0; mask < 256; ++mask)
            file.put(masks + mask, std::uint8_t{0});
    });
    refuses("is none of the cube's",
            [&](ForgedFile& file) { file.put(file.section_of(1).offset + 400 + 336, std::uint8_t{48}); });
    refuses("bits in level 4", [&](ForgedFile& file) { file.put(file.section_of(1).offset + 400 + 32, 7u); });
    refuses("wrong counts", [&](ForgedFile& file) { // the root's, whose first width says where they are
        const std::uint64_t bit = file.at<std::uint64_t>(file.section_of(6).offset + 40) + 18;
        const std::uint64_t byte = file.section_of(8).offset + bit / 8;
        file.put(byte, static_cast<std::uint8_t>(file.at<std::uint8_t>(byte) ^ 1u << bit % 8));
    });
    refuses("has not the cubes", [&](ForgedFile& file) {
        const std::uint64_t masks = file.section_of(13, 1).offset;
        file.put(masks, static_cast<std::uint8_t>(file.at<std::uint8_t>(masks) ^ 1));
    });
    refuses("nodes instead of", [&](ForgedFile& file) { // and as many means
        add(file, file.section_of(6).offset + 48, 1);
        for (const std::uint32_t kind : {12u})
            add(file, file.section_of(kind).offset + 12, 1);
    });
    ForgedFile bare(file_of(random_voxels(5, 0.01, 3), Symmetry::Cube, false));
    add(bare, 32, 1);
    path.replace(bare.sealed());
    CHECK(path.complaint().find("voxels instead of") != std::string::npos);
}

TEST_CASE("entries that name a material which is not there are refused when they are opened") {
    const PackedDag dag = packed(sphere_voxels(6, {30, 30, 30}, 12), Symmetry::Cube);
    AttributeParts parts = encode_attributes(dag, random_attributes(dag.voxel_count, 5), {}, progress)->parts();
    parts.voxels.materials = encode_columns({{7}, {7}, {7}, {7}});
    CHECK_THROWS_AS(DagAttributes(parts, dag), InvalidInput);
}
} // namespace dag_forged_test
