// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "shading/material.hpp"
#include "shading/op_facts.hpp"
#include <optional>

namespace tyndall {
/// What SurfaceClosures::transparent depends on: found once per material, for shadow rays, which run nothing else.
struct TransparentOperations {
    explicit TransparentOperations(const Material& material);

    std::vector<std::uint16_t> places; ///< In Material::program, ascending.
    OpReads::Flags reads = OpReads::nothing;
    std::optional<Rgb> constant; ///< What they give everywhere; nothing: they read what differs between points.
};
} // namespace tyndall
