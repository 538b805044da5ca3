// SPDX-License-Identifier: GPL-3.0-or-later
// What everything that writes OpenVDB files does alike. Only for the files in this folder.
#pragma once
#include "volume/io/archive.hpp"
#include "volume/io/vdb_file.hpp"

namespace tyndall::volume_io {
namespace vdb = openvdb;

constexpr Advice writing{.stream_failure = "the disk is full or failed",
                         .remedy = "see that the folder can be written to and has room"};

/// Throws InvalidInput unless leaves begin at multiples of 8, each at others. named: 'path: grid "x": '.
void require_leaves(std::span<const VoxelIndex> origins, const std::string& named);
/// Throws InvalidInput where the matrix has no inverse.
[[nodiscard]] vdb::math::Transform::Ptr to_transform(const Matrix& local_from_index, const std::string& named);
/// Whole or not at all; metadata's "creator" becomes that of the grids as well.
void write_grids(const std::filesystem::path& path, const std::vector<vdb::GridBase::Ptr>& grids,
                 const Metadata& metadata, const Progress& progress);
} // namespace tyndall::volume_io
