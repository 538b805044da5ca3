// SPDX-License-Identifier: GPL-3.0-or-later
// What the voxels of a packed DAG carry, and the larger nodes of its tree on average, as bytes that are read in place.
// Based on: Kol, dissertation 2018, 2.4 and 2.5.2: an attribute array of numbers of joint materials.
// Differs:  entries are in the DAG's stored order (stored_order.hpp), so that symmetry and attributes go together. Nodes of
//           16^3 and more have arrays of their own: within the voxels' array their means, few of which are alike, would
//           break runs and fill its table. Cubes of 2^3 to 8^3 have none: their voxels follow each other, some 40 at 8^3,
//           and are averaged when they are asked for.
// Bound:    a look-up is the way down, one value of a run_array.hpp, and one row of the table.
#pragma once
#include "voxel_dag/attribute_means.hpp"
#include "voxel_dag/joint_materials.hpp"
#include "voxel_dag/run_array.hpp"
#include "voxel_dag/stored_order.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <functional>
#include <memory>
#include <string>

namespace tyndall::voxel_dag {
/// Columns of materials: the colour, the normal, the channels; those that are there.
struct AttributeLayout {
    bool has_colors = false;
    std::uint32_t normal_bits = 0; ///< Of a voxel's normal, [8, 32]; 0: there are none.
    std::vector<std::string> channels;

    bool operator==(const AttributeLayout&) const = default;
    [[nodiscard]] std::uint32_t column_count() const {
        return std::uint32_t{has_colors} + std::uint32_t{normal_bits > 0} + static_cast<std::uint32_t>(channels.size());
    }
    /// Means are no input that must come back: 16 bits are within 0.65 degrees.
    [[nodiscard]] std::uint32_t mean_normal_bits() const { return std::min(normal_bits, 16u); }
};
/// Of what was stored against what was given, over voxels; all 0 where nothing was lost.
struct AttributeErrors {
    double mean_cie94 = 0.0, most_cie94 = 0.0, mean_degrees = 0.0, most_degrees = 0.0;

    bool operator==(const AttributeErrors&) const = default;
};
/// Materials and, per entry, the number of one: encode_columns() and run_array::encode().
struct MaterialBytes {
    std::vector<std::uint8_t> materials, indices;

    bool operator==(const MaterialBytes&) const = default;
};
struct AttributeParts {
    AttributeLayout layout;
    AttributeErrors errors;
    StoredOrder order;
    MaterialBytes voxels; ///< Entries in stored order.
    MaterialBytes means;  ///< Of the tree's nodes by their number; without bytes: none were asked for.

    bool operator==(const AttributeParts&) const = default;
    [[nodiscard]] std::uint64_t byte_count() const;
};

/// What is left of the parts beside arrays: layout, errors, and the numbers of the order.
[[nodiscard]] std::vector<std::uint8_t> encode_names(const AttributeParts& parts);
/// Throws InvalidInput where it is cut off.
void decode_names(std::span<const std::uint8_t> bytes, AttributeParts& parts);

/// Immutable; for any number of threads.
class DagAttributes {
public:
    /// Throws InvalidInput, which names what is damaged or does not belong to the DAG.
    DagAttributes(AttributeParts parts, const PackedDag& dag);
    DagAttributes(const DagAttributes&) = delete;
    DagAttributes& operator=(const DagAttributes&) = delete;
    ~DagAttributes() = default;

    [[nodiscard]] const AttributeParts& parts() const { return parts_; }
    [[nodiscard]] const AttributeLayout& layout() const { return parts_.layout; }
    [[nodiscard]] bool has_means() const { return means_.has_value(); }
    /// Of the cube of 2^level voxels a side around a voxel: its mean, or the voxel's own at level 0. Nothing where the cube
    /// has no voxel. Level least_mean_level or above: only where has_means(). dag is the one that these belong to.
    [[nodiscard]] std::optional<VoxelSample> sample_at(const PackedDag& dag, const Voxel& voxel,
                                                       std::uint32_t level) const;

    /// Per material of voxels, whether it is wanted.
    [[nodiscard]] std::vector<bool> materials_where(const std::function<bool(const VoxelSample&)>& is_wanted) const;
    /// Entries of voxels of wanted materials, rising; nothing where there are more than `most`. Throws Cancelled.
    [[nodiscard]] std::optional<std::vector<std::uint64_t>>
    entries_of(const std::vector<bool>& is_wanted, std::size_t most, const Progress& progress) const;

private:
    struct Materials {
        MaterialTable table;
        RunArray indices;
        std::uint32_t normal_bits;
    };
    [[nodiscard]] Materials opened(const MaterialBytes& bytes, std::uint64_t entry_count,
                                   std::uint32_t normal_bits) const;
    [[nodiscard]] VoxelSample sample(const Materials& materials, std::uint32_t material) const;

    AttributeParts parts_;
    std::optional<Materials> voxels_, means_;
};

/// Of a packed one, red lowest.
[[nodiscard]] constexpr ByteColor byte_color(std::uint32_t color) {
    return {static_cast<std::uint8_t>(color), static_cast<std::uint8_t>(color >> 8),
            static_cast<std::uint8_t>(color >> 16)};
}
/// Of cubes as sample_at() has them. Throw InvalidInput, which names the first voxel whose cube is empty, or what there is
/// none of, and Cancelled.
[[nodiscard]] std::vector<ByteColor> colors_at(const PackedDag& dag, const DagAttributes& attributes,
                                               std::span<const Voxel> voxels, std::uint32_t level,
                                               const Progress& progress);
[[nodiscard]] std::vector<vec3> normals_at(const PackedDag& dag, const DagAttributes& attributes,
                                           std::span<const Voxel> voxels, std::uint32_t level,
                                           const Progress& progress);
[[nodiscard]] std::vector<std::uint8_t> channel_at(const PackedDag& dag, const DagAttributes& attributes,
                                                   const std::string& name, std::span<const Voxel> voxels,
                                                   std::uint32_t level, const Progress& progress);
} // namespace tyndall::voxel_dag
