// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "light_shafts/local_scatter.hpp"

namespace tyndall::light_shafts {
/// Rays that the light can shine on, and what of them is lit.
struct LocalScatter::Reached {
    LocalSupport support;
    std::vector<std::uint32_t> rays; ///< And their row of `lit`.
    std::vector<ViewRay> asked;
    LitRows lit;
};
} // namespace tyndall::light_shafts
