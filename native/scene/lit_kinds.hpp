// SPDX-License-Identifier: GPL-3.0-or-later
// Which kinds of surfaces' shaders an emitter lights: the ray visibility of its object.
#pragma once

namespace tyndall {
struct LitKinds {
    bool diffuse = true; ///< Translucent ones, sheen and toon, too.
    bool glossy = true;
    bool transmission = true; ///< Hair's.
    [[nodiscard]] bool are_all() const { return diffuse && glossy && transmission; }
    [[nodiscard]] bool are_none() const { return !diffuse && !glossy && !transmission; }
    bool operator==(const LitKinds&) const = default;
};
} // namespace tyndall
