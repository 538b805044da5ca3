// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/lobes/lobe_models.hpp"
#include "shading/lobes/lobe_builder.hpp"

namespace tyndall {
void take_apart(Lobes& lobes, Lobes& bent, Lobes& below) {
    const auto is_none = [](const Lobe& lobe) {
        return lobe.kind == Lobe::Kind::Bent || lobe.kind == Lobe::Kind::Subsurface;
    };
    if (std::ranges::none_of(lobes, is_none))
        return;
    for (const Lobe& lobe : lobes)
        if (is_none(lobe))
            (lobe.kind == Lobe::Kind::Bent ? bent : below).push_back(lobe);
    std::erase_if(lobes, is_none);
}

void add_lobes(const LobeSource& source, const LobeInputs& inputs, const ShadingPoint& point, SurfaceClosures& closures,
               Lobes* lobes, const LobeNormals& normals) {
    LobeBuilder(source, inputs, point, closures, lobes, normals).build();
}
} // namespace tyndall
