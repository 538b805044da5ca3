// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/cell_emitters.hpp"
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr std::uint32_t least_asked_thoroughly = 256; ///< Looks.
static constexpr std::array ray_kinds{RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission, RayKind::Scatter};
static constexpr std::uint32_t place_count = 2 * ray_kinds.size();

namespace {
/// Asks looks what they emit.
class AskedLooks {
public:
    AskedLooks(const Scene& scene, std::span<const std::uint32_t> instances) : scene_(scene), instances_(instances) {}

    [[nodiscard]] bool glows(const CellLook& look) {
        const Rgb first = emission(look, 0);
        bool does = first != Rgb(0.0f);
        const bool asks_all = does || asked_count_ < least_asked_thoroughly;
        for (std::uint32_t place = 1; asks_all && place < place_count; ++place) {
            const Rgb other = emission(look, place);
            does |= other != Rgb(0.0f);
            varies_ |= other != first;
        }
        ++asked_count_;
        return does;
    }
    /// By more than the look.
    [[nodiscard]] bool varies() const { return varies_; }

private:
    [[nodiscard]] Rgb emission(const CellLook& look, std::uint32_t place) const {
        const std::uint32_t instance = instances_[place % instances_.size()];
        const Bounds3 box = bounds_of(scene_.description(), *scene_.placed_shape(instance));
        const vec2 u = sobol_point(place, 1u);
        Hit hit{.distance_m = 1.0f, .instance = instance};
        hit.geometric_normal = sample_uniform_sphere(sobol_point(place, 2u));
        const vec3 at = box.min + vec3(u.x, u.y, sobol_point(place, 3u).x) * (box.max - box.min);
        const Ray ray{.origin = at + hit.geometric_normal, .direction = -hit.geometric_normal};
        return scene_.emission_of(look, ray, ray_kinds[place % ray_kinds.size()], hit);
    }

    const Scene& scene_;
    std::span<const std::uint32_t> instances_;
    std::uint32_t asked_count_ = 0;
    bool varies_ = false;
};
} // namespace

std::optional<GlowingFaces> glowing_faces(const Scene& scene, std::span<const std::uint32_t> instances,
                                          std::size_t most, const Progress& progress) {
    const PlacedShape& placed = *scene.placed_shape(instances.front());
    const CellShape& cells = *scene.description().shapes[placed.shape_index]->cells();
    AskedLooks looks(scene, instances);
    auto faces = cells.open_faces([&](const CellLook& look) { return looks.glows(look); }, most, progress);
    if (faces && looks.varies())
        faces = cells.open_faces([](const CellLook&) { return true; }, most, progress);
    if (!faces)
        return std::nullopt;
    std::ranges::sort(*faces);
    return GlowingFaces{std::move(*faces), !looks.varies()};
}
} // namespace tyndall::render
