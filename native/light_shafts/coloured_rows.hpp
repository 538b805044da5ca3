// SPDX-License-Identifier: GPL-3.0-or-later
// Rows that are filled for a light: once, or, where coloured surfaces may shade them, once per channel.
// Bound:    three times the memory and time of one set of rows, and queries by intervals instead of fused ones, for those
//           lights alone whose lit air a coloured surface may shade.
#pragma once
#include "light_shafts/map_cache.hpp"
#include "light_shafts/slope_rows_partial.hpp"
#include "light_shafts/slope_rows_visibility.hpp"
#include <functional>
#include <optional>

namespace tyndall::light_shafts {
/// A third of the memory for each set, where some surface is coloured.
[[nodiscard]] slope_rows::LayoutConfig sharing_memory(slope_rows::LayoutConfig layout, const Occluders& occluders);

/// Returns what answers the rays that rows cannot; nothing: the exact strip does.
using FillRows = std::function<std::shared_ptr<const Visibility>(slope_rows::Rows& rows, const PartialShading& partial,
                                                                 Statistics& statistics)>;
/// How rows are told from others of the same layout; see KeptCasts::key.
struct KeepAs {
    CastKind kind;
    MayShow may_show; ///< May refer to the layout of the prepared rows.
    std::uint32_t resolution = 0;
    std::size_t instead_bytes = 0; ///< Of what FillRows returns.
};
/// `prepared` has rows. `seed` is of what is drawn for surfaces that let a part of the light pass. Rows that are kept are
/// not filled again; without `keep_as`, none are. Throws what fill does.
[[nodiscard]] std::unique_ptr<Visibility> fill_rows(const Preparation& preparation, PreparedRows prepared,
                                                    std::uint32_t seed, const std::optional<KeepAs>& keep_as,
                                                    const FillRows& fill);
} // namespace tyndall::light_shafts
