// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include "shading/material.hpp"
#include "shading/op_facts.hpp"

namespace tyndall {
/// What SurfaceClosures::transparent depends on: found once per material, for shadow rays, which run nothing else.
struct TransparentOperations {
    explicit TransparentOperations(const Material& material);

    std::vector<std::uint16_t> places; ///< In Material::program, ascending.
    OpReads::Flags reads = OpReads::nothing;
};
} // namespace tyndall
