// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT visibility: what the strip kernel needs of a scene, a view ray and a light.
#pragma once
#include "light_shafts/strip_kernel.hpp"
#include "light_shafts/visibility.hpp"
#include <mutex>

namespace tyndall::light_shafts {
/// The scene's occluders that block an emitter. Meshes and hierarchies belong to the scene, which must outlive the result.
/// Throws Cancelled.
[[nodiscard]] StripScene make_strip_scene(const Scene& scene, const Progress& progress, const LightLinks& links = {});
/// The same, made when it is first asked for, and then shared: most frames never need it. Safe from any thread.
class StripOnDemand {
public:
    /// The scene must outlive this.
    explicit StripOnDemand(const Scene& scene, const LightLinks& links = {}) : scene_(scene), links_(links) {}
    [[nodiscard]] std::shared_ptr<const StripScene> get() const;

private:
    const Scene& scene_;
    LightLinks links_;
    mutable std::once_flag once_;
    mutable std::shared_ptr<const StripScene> strip_;
};
/// The same as make_exact_strip of visibility.hpp, for many lights of one scene.
[[nodiscard]] std::unique_ptr<Visibility> make_exact_strip(const Scene& scene, const LightSample& light,
                                                           std::shared_ptr<const StripScene> strip);
[[nodiscard]] StripRay strip_ray(const ViewRay& ray, const LightSample& light);
} // namespace tyndall::light_shafts
