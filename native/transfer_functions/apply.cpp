// SPDX-License-Identifier: GPL-3.0-or-later
#include "transfer_functions/apply.hpp"
#include "core/parallel.hpp"
#include "transfer_functions/apply_kernel.hpp"

namespace tyndall::transfer_functions {
void apply(const ComposedFunction& function, const Application& application, std::span<const vec2> parameters,
           std::span<const Rgb> radiance, std::span<const float> share, std::span<Rgb> change,
           const Progress& progress) {
    require(application.use <= Use::Tint, "use ", static_cast<int>(application.use), " is unknown");
    require(std::isfinite(application.strength) && std::isfinite(application.weight),
            "strength or weight is not finite");
    require(radiance.size() == parameters.size() && change.size() == parameters.size() &&
                (share.empty() || share.size() == parameters.size()),
            parameters.size(), " rays have ", radiance.size(), " radiances, ", share.size(), " shares and ",
            change.size(), " changes");
    if (function.is_neutral() || application.weight == 0.0f)
        return;
    require(function.texels.size() == std::size_t{function.size} * function.size, "a function of ", function.size,
            " texels per side has ", function.texels.size());
    if (function.size == 1)
        return apply({.size = 2, .texels = std::vector<vec4>(4, function.texels[0])}, application, parameters, radiance,
                     share, change, progress);
    parallel_blocks(parameters.size(), 8192, progress, [&](std::size_t first, std::size_t end) {
        apply_to(function, application,
                 {.parameters = parameters.data() + first,
                  .radiance = radiance.data() + first,
                  .share = share.empty() ? nullptr : share.data() + first,
                  .change = change.data() + first,
                  .count = end - first});
    });
}
} // namespace tyndall::transfer_functions
