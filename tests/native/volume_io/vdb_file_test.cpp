// SPDX-License-Identifier: GPL-3.0-or-later
// Grids of every kind that OpenVDB itself writes; tests/python/test_volumes.py holds what we write.
#include "volume/io/vdb_file.hpp"
#include <doctest/doctest.h>
#include <fstream>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <unistd.h>

namespace tyndall::volume_io {
namespace vdb = openvdb;

/// A file with a name of its own that goes with the test.
class TemporaryFile {
public:
    TemporaryFile()
        : path_(std::filesystem::temp_directory_path() / ("tyndall_vdb_test_" + std::to_string(getpid()) + ".vdb")) {
        vdb::initialize();
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() { std::filesystem::remove(path_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    void write(const vdb::GridCPtrVec& grids, const vdb::MetaMap& metadata = {}) const {
        vdb::io::File(path_.string()).write(grids, metadata);
    }

private:
    std::filesystem::path path_;
};

constexpr std::size_t ample_bytes = std::size_t{1} << 28;

static std::vector<Grid> read_all(const TemporaryFile& file, std::optional<std::vector<std::string>> names = {}) {
    Progress progress;
    return read(file.path(), names, ample_bytes, progress);
}
static FileInfo list_all(const TemporaryFile& file) { return list(file.path(), Progress()); }

/// What a reader of our leaves finds at an index.
static float value_at(const Grid& grid, VoxelIndex index) {
    for (std::size_t leaf = 0; leaf < grid.leaf_origins.size(); ++leaf) {
        const auto& [x, y, z] = grid.leaf_origins[leaf];
        if (x == (index[0] & ~7) && y == (index[1] & ~7) && z == (index[2] & ~7))
            return grid
                .leaf_values[leaf * voxels_per_leaf +
                             static_cast<std::size_t>((index[0] & 7) << 6 | (index[1] & 7) << 3 | (index[2] & 7))];
    }
    return grid.background;
}

/// By OpenVDB's own constructor: what compiles it here would compile all of a tree's virtual functions.
template <typename GridType>
static typename GridType::Ptr named(const char* name, const typename GridType::ValueType& background = {}) {
    const auto grid = vdb::gridPtrCast<GridType>(vdb::GridBase::createGrid(GridType::gridType()));
    grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
    grid->setName(name);
    return grid;
}

TEST_CASE("numbers of every type become the nearest floats") {
    const TemporaryFile file;
    const vdb::Coord voxel(-9, 3, 70);
    const auto doubles = named<vdb::DoubleGrid>("double", 0.1);
    doubles->tree().setValue(voxel, 1.0 / 3.0);
    const auto integers = named<vdb::Int32Grid>("int32", -2);
    integers->tree().setValue(voxel, (1 << 24) + 3);
    const auto large = named<vdb::Int64Grid>("int64");
    large->tree().setValue(voxel, std::int64_t{1} << 40);
    const auto flags = named<vdb::BoolGrid>("bool");
    flags->tree().setValue(voxel, true);
    const auto mask = named<vdb::MaskGrid>("mask");
    mask->tree().setValueOn(voxel);
    file.write({doubles, integers, large, flags, mask});

    const std::vector<Grid> grids = read_all(file);
    REQUIRE(grids.size() == 5);
    const VoxelIndex index{-9, 3, 70}, beside{-9, 3, 71}, far_away{1000, 0, 0};
    CHECK(value_at(grids[0], index) == 1.0f / 3.0f);
    CHECK(value_at(grids[0], beside) == 0.1f);
    CHECK(grids[0].background == 0.1f);
    CHECK(value_at(grids[1], index) == static_cast<float>((1 << 24) + 4));
    CHECK(value_at(grids[1], far_away) == -2.0f);
    CHECK(value_at(grids[2], index) == 0x1p40f);
    for (const std::size_t flag : {3, 4}) {
        CHECK(value_at(grids[flag], index) == 1.0f);
        CHECK(value_at(grids[flag], beside) == 0.0f);
    }
    const FileInfo info = list_all(file);
    CHECK(info.grids[0].value_type == "double");
    CHECK(info.grids[4].value_type == "bool");
}

TEST_CASE("a grid of vectors becomes three of its components") {
    const TemporaryFile file;
    const auto velocity = named<vdb::Vec3SGrid>("velocity", vdb::Vec3s(0.5f, 0.0f, -0.5f));
    velocity->tree().setValue({1, 2, 3}, vdb::Vec3s(1.0f, 2.0f, 3.0f));
    const auto place = named<vdb::Vec3DGrid>("place");
    place->tree().setValue({1, 2, 3}, vdb::Vec3d(1e-3, 0.0, 7.0));
    file.write({velocity, place});

    const std::vector<Grid> grids = read_all(file, {{"velocity"}});
    REQUIRE(grids.size() == 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(grids[axis].name == std::string("velocity.") + "xyz"[axis]);
        CHECK(value_at(grids[axis], {1, 2, 3}) == static_cast<float>(axis) + 1.0f);
        CHECK(grids[axis].background == 0.5f - 0.5f * static_cast<float>(axis));
    }
    CHECK(value_at(read_all(file)[5], {1, 2, 3}) == 7.0f);
}

TEST_CASE("what lies in constant tiles is there as well, on and off, at every level of the tree") {
    const TemporaryFile file;
    const auto grid = named<vdb::FloatGrid>("density");
    grid->tree().addTile(/*level=*/1, {16, 0, 0}, 2.0f, /*active=*/true);
    grid->tree().addTile(/*level=*/1, {-8, -8, -8}, -3.0f, /*active=*/false);
    grid->tree().addTile(/*level=*/2, {128, 256, 0}, 4.0f, /*active=*/true);
    grid->tree().addTile(/*level=*/1, {32, 0, 0}, 0.0f, /*active=*/true); // the background: nothing to see
    file.write({grid});

    const std::vector<Grid> grids = read_all(file);
    REQUIRE(grids.size() == 1);
    CHECK(grids[0].leaf_origins.size() == 1 + 1 + 16 * 16 * 16);
    for (const VoxelIndex index : {VoxelIndex{16, 0, 0},
                                   {23, 7, 7},
                                   {-8, -8, -8},
                                   {-1, -1, -1},
                                   {128, 256, 0},
                                   {255, 383, 127},
                                   {24, 0, 0},
                                   {0, 0, 0},
                                   {256, 383, 127},
                                   {33, 1, 1}})
        CHECK(value_at(grids[0], index) == grid->tree().getValue({index[0], index[1], index[2]}));
}

TEST_CASE("tiles that would fill the memory are refused before they do") {
    const TemporaryFile file;
    const auto grid = named<vdb::FloatGrid>("fog");
    grid->tree().addTile(/*level=*/3, {0, 0, 0}, 1.0f, /*active=*/true); // 4096^3 voxels in a few bytes
    file.write({grid});
    Progress progress;
    CHECK_THROWS_WITH_AS((void)read(file.path(), {}, ample_bytes, progress),
                         (file.path().string() +
                          ": grid \"fog\": it would take 274.878 GB in memory, beyond the limit of "
                          "0.268435 GB: resample it to larger voxels, or raise the limit")
                             .c_str(),
                         InvalidInput);
    CHECK(list_all(file).grids[0].active_voxel_count == std::uint64_t{1} << 36);
}

TEST_CASE("a grid in a frustum, and one of points, are listed, left out, and refused when they are named") {
    const TemporaryFile file;
    const auto frustum = named<vdb::FloatGrid>("view");
    frustum->tree().setValue({1, 1, 1}, 1.0f);
    frustum->setTransform(vdb::math::Transform::createFrustumTransform(vdb::BBoxd({0.0, 0.0, 0.0}, {10.0, 10.0, 10.0}),
                                                                       /*taper=*/0.5, /*depth=*/10.0));
    const vdb::GridBase::Ptr points = vdb::GridBase::createGrid("Tree_ptdataidx32_5_4_3");
    points->setName("points");
    const auto density = named<vdb::FloatGrid>("density");
    file.write({frustum, points, density});

    const FileInfo info = list_all(file);
    REQUIRE(info.grids.size() == 3);
    CHECK(!info.grids[0].local_from_index);
    CHECK(info.grids[0].refusal == "it lies in a frustum, not in a box: resample it in the program that made it");
    CHECK(info.grids[1].refusal == "it holds ptdataidx32, neither numbers nor vectors of three");
    CHECK(info.grids[2].refusal.empty());
    CHECK(read_all(file).size() == 1);
    const std::string begin = file.path().string() + ": grid \"";
    CHECK_THROWS_WITH_AS(read_all(file, {{"view"}}), (begin + "view\": " + info.grids[0].refusal).c_str(),
                         InvalidInput);
    CHECK_THROWS_WITH_AS(read_all(file, {{"points"}}), (begin + "points\": " + info.grids[1].refusal).c_str(),
                         InvalidInput);
}

TEST_CASE("a grid of a type that OpenVDB does not know hides no other") {
    const TemporaryFile file;
    const auto odd = named<vdb::Vec3IGrid>("odd");
    const auto density = named<vdb::FloatGrid>("density");
    density->tree().setValue({1, 1, 1}, 5.0f);
    file.write({odd, density});
    vdb::Vec3IGrid::unregisterGrid(); // as if it were another program's

    CHECK(list_all(file).grids[0].refusal == "its type Tree_vec3i_5_4_3 is unknown to OpenVDB " + library_version());
    CHECK_THROWS_AS(read_all(file, {{"odd"}}), InvalidInput);
    const std::vector<Grid> grids = read_all(file);
    vdb::Vec3IGrid::registerGrid();
    REQUIRE(grids.size() == 1);
    CHECK(value_at(grids[0], {1, 1, 1}) == 5.0f);
}

TEST_CASE("grids that share a tree, and grids of one name, are told apart") {
    const TemporaryFile file;
    const auto first = named<vdb::FloatGrid>("density");
    first->tree().setValue({1, 1, 1}, 1.0f);
    const vdb::FloatGrid::Ptr moved = first->copy(); // the same tree, elsewhere
    moved->setTransform(vdb::math::Transform::createLinearTransform(2.0));
    const auto other = named<vdb::FloatGrid>("flame");
    file.write({first, moved, other});

    CHECK(list_all(file).grids[1].name == "density[1]");
    for (const auto& names : {std::vector<std::string>{"density", "density[1]"}, {"density[1]"}}) {
        const std::vector<Grid> grids = read_all(file, names);
        REQUIRE(grids.size() == names.size());
        CHECK(value_at(grids.back(), {1, 1, 1}) == 1.0f);
        CHECK(grids.back().local_from_index[0] == 2.0);
    }
}

TEST_CASE("a file that was written to a pipe has no places of its grids, and is read all the same") {
    const TemporaryFile file;
    const auto density = named<vdb::FloatGrid>("density");
    density->tree().setValue({1, 1, 1}, 1.0f);
    const auto flame = named<vdb::FloatGrid>("flame");
    flame->tree().setValue({2, 2, 2}, 2.0f);
    {
        std::ofstream stream(file.path(), std::ios::binary);
        vdb::io::Stream(stream).write(vdb::GridCPtrVec{density, flame});
    }
    const std::vector<Grid> grids = read_all(file, {{"flame"}});
    REQUIRE(grids.size() == 1);
    CHECK(value_at(grids[0], {2, 2, 2}) == 2.0f);
    CHECK(list_all(file).grids[0].active_voxel_count == 1);
}

TEST_CASE("a file without statistics is counted") {
    const TemporaryFile file;
    const auto density = named<vdb::FloatGrid>("density");
    density->tree().setValue({-5, 1, 2}, 1.0f);
    density->tree().setValue({7, 1, 3}, 1.0f);
    vdb::io::File target(file.path().string());
    target.setGridStatsMetadataEnabled(false);
    target.write(vdb::GridCPtrVec{density});

    const GridInfo info = list_all(file).grids.at(0);
    CHECK(info.active_voxel_count == 2);
    CHECK(info.first_index == VoxelIndex{-5, 1, 2});
    CHECK(info.last_index == VoxelIndex{7, 1, 3});
}

TEST_CASE("other programs find what we write: class, creator, bounds and the place of a voxel") {
    const TemporaryFile file;
    std::vector<float> values(voxels_per_leaf, 0.0f);
    values[1 << 6 | 2 << 3 | 3] = 4.0f;
    const std::vector<VoxelIndex> origins{{-8, 0, 8}};
    const Matrix local_from_index{0, -2, 0, 10, 2, 0, 0, 20, 0, 0, 2, 30, 0, 0, 0, 1}; // a quarter turn about z
    const GridView view{"density", origins, values, local_from_index, 0.0f};
    Progress progress;
    write(file.path(), {&view, 1}, Precision::Float, {{"creator", "Tyndall"}}, progress);

    vdb::io::File source(file.path().string());
    source.open();
    const vdb::GridBase::Ptr grid = source.readGrid("density");
    CHECK(grid->getGridClass() == vdb::GRID_FOG_VOLUME);
    CHECK(grid->getCreator() == "Tyndall");
    CHECK(grid->activeVoxelCount() == 1);
    const vdb::Coord voxel(-7, 2, 11);
    CHECK(vdb::gridConstPtrCast<vdb::FloatGrid>(grid)->tree().getValue(voxel) == 4.0f);
    CHECK(grid->evalActiveVoxelBoundingBox().min() == voxel);
    CHECK(grid->transform().indexToWorld(voxel) == vdb::Vec3d(6.0, 6.0, 52.0));
}
} // namespace tyndall::volume_io
