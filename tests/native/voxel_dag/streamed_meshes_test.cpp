// SPDX-License-Identifier: GPL-3.0-or-later
// Real meshes, every voxel: what a packed DAG with all 48 turns is decoded to, against the oracle, which looks at voxels on
// their own. Both are made a part at a time: some MB beside the mesh and the DAG.
// Meshes are those of TYNDALL_SHARED_DATA; without it nothing is compared, and a message says so.
#include "../benchmarks/support/voxel_meshes.hpp"
#include "core/parallel.hpp"
#include "native/voxel_dag/triangle_overlap.hpp"
#include "support/packed_voxels.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/snapped_mesh.hpp"
#include <doctest/doctest.h>

namespace streamed_meshes_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

namespace {
constexpr std::uint32_t part_level = 8; // parts of 256^3
constexpr std::uint32_t brick_bits = 3 * (part_level - leaf_level);

/// The voxels of triangles within one part, by the bricks' Morton codes in it.
class PartOracle {
public:
    explicit PartOracle(std::uint64_t part) : lowest_(voxel_at(part << 3 * part_level)), masks_(1u << brick_bits) {}
    void add(const oracle::Triangle& triangle) {
        // Up to 1,024 voxels wide, at 8,192 a side, numbers stay below 3 * 2^57.
        const auto is_small = [&](std::size_t axis) {
            const auto [least, most] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
            return most - least < std::int64_t{1} << 18;
        };
        if (is_small(0) && is_small(1) && is_small(2))
            visit(oracle::OverlapIn<std::int64_t>(triangle, VoxelizeRule::Thin), lowest_, 1u << part_level);
        else
            visit(oracle::Overlap(triangle, VoxelizeRule::Thin), lowest_, 1u << part_level);
    }
    /// Bricks that have any voxel, by ascending code.
    [[nodiscard]] const std::vector<std::uint64_t>& masks() const { return masks_; }

private:
    template <class Overlap>
    void visit(const Overlap& overlap, const Voxel& lowest, std::uint32_t side) {
        if (side == 1) {
            if (overlap(lowest)) {
                const std::uint64_t code = morton_code(lowest) & ((1u << 3 * part_level) - 1);
                masks_[code >> 6] |= std::uint64_t{1} << (code & 63);
            }
            return;
        }
        if (!overlap.may_meet(lowest, side))
            return;
        const std::uint32_t half = side / 2;
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            visit(overlap,
                  {lowest[0] + (octant & 1) * half, lowest[1] + (octant >> 1 & 1) * half,
                   lowest[2] + (octant >> 2) * half},
                  half);
    }
    Voxel lowest_;
    std::vector<std::uint64_t> masks_;
};

/// Bricks of a DAG one by one, decoded some at a time.
class BrickStream {
public:
    explicit BrickStream(const PackedDag& dag) : decoder_(dag) { advance(); }
    [[nodiscard]] bool is_at_end() const { return is_at_end_; }
    [[nodiscard]] std::uint64_t code() const { return chunk_.codes[at_]; }
    [[nodiscard]] std::uint64_t mask() const { return chunk_.masks[at_]; }
    void next() {
        if (++at_ == chunk_.codes.size())
            advance();
    }

private:
    void advance() {
        at_ = 0;
        is_at_end_ = !decoder_.next(5000, chunk_);
    }
    Decoder<PackedDag> decoder_;
    LeafMasks chunk_;
    std::size_t at_ = 0;
    bool is_at_end_ = false;
};

/// Triangles by the parts that their boxes meet.
std::vector<std::vector<std::uint32_t>> triangles_by_part(const SnappedMesh& mesh) {
    const std::int64_t part_steps = std::int64_t{256} << part_level, last = (1 << (mesh.level - part_level)) - 1;
    std::vector<std::vector<std::uint32_t>> by_part(std::size_t{1} << 3 * (mesh.level - part_level));
    for (std::uint32_t index = 0; index < mesh.triangles.size(); ++index) {
        const SnappedTriangle triangle = mesh.triangle(index);
        std::array<std::uint32_t, 3> from, to;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [least, most] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
            from[axis] = static_cast<std::uint32_t>(std::clamp<std::int64_t>(least / part_steps, 0, last));
            to[axis] = static_cast<std::uint32_t>(std::clamp<std::int64_t>(most / part_steps, 0, last));
        }
        for (std::uint32_t z = from[2]; z <= to[2]; ++z)
            for (std::uint32_t y = from[1]; y <= to[1]; ++y)
                for (std::uint32_t x = from[0]; x <= to[0]; ++x)
                    by_part[static_cast<std::size_t>(morton_code({x, y, z}))].push_back(index);
    }
    return by_part;
}

/// Voxels that both have; ends the test case at the first brick in which they differ.
std::uint64_t compared_voxels(const PackedDag& dag, const SnappedMesh& mesh) {
    constexpr std::size_t parts_at_once = 32; // 2 MB each
    const auto by_part = triangles_by_part(mesh);
    BrickStream decoded(dag);
    std::uint64_t voxel_count = 0;
    for (std::size_t first = 0; first < by_part.size(); first += parts_at_once) {
        std::vector<std::optional<PartOracle>> truth(std::min(parts_at_once, by_part.size() - first));
        parallel_for(
            truth.size(), Progress(),
            [&](std::size_t i) {
                if (by_part[first + i].empty())
                    return;
                truth[i].emplace(first + i);
                for (const std::uint32_t triangle : by_part[first + i])
                    truth[i]->add(mesh.triangle(triangle));
            },
            1);
        for (std::size_t i = 0; i < truth.size(); ++i)
            for (std::uint64_t brick = 0; truth[i] && brick < truth[i]->masks().size(); ++brick) {
                const std::uint64_t mask = truth[i]->masks()[brick];
                if (mask == 0)
                    continue;
                const std::uint64_t code = (first + i) << brick_bits | brick;
                CAPTURE(code);
                REQUIRE(!decoded.is_at_end());
                REQUIRE(decoded.code() == code);
                REQUIRE(decoded.mask() == mask);
                voxel_count += static_cast<std::uint64_t>(std::popcount(mask));
                decoded.next();
            }
    }
    REQUIRE(decoded.is_at_end());
    return voxel_count;
}

// Seen to fail with one voxel of one leaf of the DAG changed.
void compare_at(std::uint32_t resolution) {
    for (const std::int64_t which : {0, 1}) {
        CAPTURE(which);
        const bench::BareMesh* const bare = bench::bare_mesh(which);
        if (bare == nullptr) {
            MESSAGE("nothing is compared: set TYNDALL_SHARED_DATA to where the meshes are");
            continue;
        }
        const std::span<const vec3> positions(bare->positions);
        const PackedDag dag = support::packed(
            voxelize(positions, bare->triangles, {.resolution = resolution}, Progress()).leaves, Symmetry::Cube);
        const SnappedMesh mesh = snap(positions, bare->triangles, {.resolution = resolution}, Progress());
        CHECK(compared_voxels(dag, mesh) == dag.voxel_count);
    }
}
} // namespace

TEST_CASE("every voxel of the dragon and of Sponza at 1,024 is decoded as the oracle has it") { compare_at(1024); }
TEST_CASE("every voxel of the dragon and of Sponza at 8,192 is decoded as the oracle has it" *
          doctest::test_suite("long")) {
    compare_at(8192);
}
} // namespace streamed_meshes_test
