// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/surface_holes.hpp"
#include "core/errors.hpp"

namespace tyndall::light_shafts {
std::unique_ptr<const SurfaceHoles> SurfaceHoles::make(const Scene& scene, const Light& light) {
    std::unique_ptr<SurfaceHoles> holes(new SurfaceHoles(scene));
    for (const OccluderEdit& edit : light.occluder_edits)
        if (edit.kind == EditKind::Holes && edit.affects_surfaces && edit_does_something(edit))
            holes->edits_.emplace_back(edit, light, bounds_of_occluders(scene.description(), &edit));
    if (holes->edits_.empty())
        return nullptr;
    require(holes->edits_.size() < 64, "light \"", light.name, "\" has ", holes->edits_.size(),
            " edits with holes for surfaces: 63 are the most");
    holes->never_blocks_ = light.links.is_blocked_by_all() ? 0 : std::uint64_t{1} << 63;
    for (std::uint32_t instance = 0; instance < scene.instance_count(); ++instance) {
        const std::uint32_t name_index = scene.description().name_index_of(instance);
        std::uint64_t bits = scene.blocks(instance, light.links) ? 0 : holes->never_blocks_;
        for (std::size_t edit = 0; edit < holes->edits_.size(); ++edit)
            bits |= edit_means(*holes->edits_[edit].what, name_index) ? std::uint64_t{1} << edit : 0;
        holes->bits_of_instance_.push_back(bits);
    }
    return holes;
}

void SurfaceHoles::shadow_transmittances(std::span<const Ray> rays, std::span<Rgb> passing) const {
    thread_local std::vector<float> x, y, z;
    thread_local std::vector<std::uint8_t> is_hole;
    thread_local std::vector<std::uint64_t> open;
    open.assign(rays.size(), never_blocks_);
    is_hole.resize(rays.size());
    for (std::size_t index = 0; index < edits_.size(); ++index) {
        const PlacedEdit& edit = edits_[index];
        x.clear();
        y.clear();
        z.clear();
        for (const Ray& ray : rays) {
            const vec3 place = edit.space.place_of(ray);
            x.push_back(place.x);
            y.push_back(place.y);
            z.push_back(place.z);
        }
        edit.find_holes(x, y, z, is_hole);
        for (std::size_t ray = 0; ray < rays.size(); ++ray)
            if (is_hole[ray] != 0 && !edit.is_masked_out({x[ray], y[ray], z[ray]}))
                open[ray] |= std::uint64_t{1} << index;
    }
    for (std::size_t ray = 0; ray < rays.size(); ++ray)
        passing[ray] = scene_.shadow_transmittance(rays[ray], bits_of_instance_, open[ray]);
}
} // namespace tyndall::light_shafts
