// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT visibility: the parts of a view ray that a light reaches, without any discretisation. See strip_kernel.hpp.
#include "light_shafts/exact_strip.hpp"
#include "core/parallel.hpp"
#include "light_shafts/partial_shadow.hpp"
#include "scene/embree.hpp"
#include "scene/strands.hpp"
#include "scene/triangle_bvh.hpp"
#include <tbb/task_arena.h>

namespace tyndall::light_shafts {
StripScene make_strip_scene(const Scene& scene, const Progress& progress, const LightLinks& links) {
    const SceneDescription& description = scene.description();
    StripScene strip;
    strip.lookups.resize(description.materials.size());
    std::vector<Bounds3> boxes, boxes_of_shapes; // of meshes and strands, and of cells, which follow
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        const Instance& instance = description.instances[index];
        const TriangleMesh& mesh = *description.meshes[instance.mesh_index];
        if (!instance.casts_shadow || mesh.triangle_count() == 0 || !scene.blocks(index, links))
            continue;
        std::vector<Occlusion> slots(std::max<std::size_t>(instance.slot_count, 1));
        for (std::size_t slot = 0; slot < slots.size(); ++slot) {
            const std::uint32_t index_of_material = description.slot_materials[instance.first_slot_material + slot];
            const Material& material = description.materials[index_of_material];
            slots[slot] = occlusion_of(material);
            if (auto& lookup = strip.lookups[index_of_material]; slots[slot] == Occlusion::Partial && !lookup)
                lookup = std::make_unique<const TransparencyLookup>(material);
        }
        if (std::ranges::all_of(slots, [](Occlusion occlusion) { return occlusion == Occlusion::None; }))
            continue;
        if (std::ranges::all_of(slots, [](Occlusion occlusion) { return occlusion == Occlusion::Opaque; }))
            slots.clear();
        strip.meshes.push_back({.bvh = &mesh.cut_bvh(progress),
                                .world_from_object = instance.world_from_object,
                                .occlusion_of_slot = std::move(slots),
                                .slot_of_triangle = mesh.arrays().material_slots,
                                .instance = index});
        boxes.push_back(transformed(mesh.bounds(), instance.world_from_object));
    }
    for (std::uint32_t number = 0; number < description.placed_shapes.size(); ++number) {
        const PlacedShape& placed = description.placed_shapes[number];
        const std::optional<std::uint32_t> shade = shade_of(description, placed);
        if (!shade || !scene.blocks(static_cast<std::uint32_t>(description.instances.size()) + number, links))
            continue;
        const ShapeGeometry& shape = *description.shapes[*shade];
        const Strands* strands = shape.strands();
        if (strands == nullptr) {
            strip.shapes.push_back({.shape = shape.cells(), .world_from_object = placed.world_from_object});
            boxes_of_shapes.push_back(bounds_of(description, placed));
            continue;
        }
        const TriangleBvh& tubes = strands->tubes(progress); // planes cut strands as tubes of triangles
        strip.meshes.push_back({.bvh = &tubes,
                                .world_from_object = placed.world_from_object,
                                .occlusion_of_slot = {},
                                .slot_of_triangle = {}});
        boxes.push_back(transformed(tubes.bounds(), placed.world_from_object));
    }
    boxes.insert(boxes.end(), boxes_of_shapes.begin(), boxes_of_shapes.end());
    for (Bounds3& box : boxes) {
        const vec3 reach = glm::max(glm::abs(box.min), glm::abs(box.max));
        strip.top_reach = glm::max(strip.top_reach, reach);
        box.min -= 4e-7f * reach, box.max += 4e-7f * reach; // what the transform may have rounded away
    }
    if (boxes.size() > 2)
        strip.top = WideBvh(embree_device(), boxes, 1, progress);
    return strip;
}

std::shared_ptr<const StripScene> StripOnDemand::get() const {
    std::call_once(once_, [this] {
        // Without the isolation this thread might, while it waits for its own tasks, start another block of rays that
        // waits for this very flag.
        tbb::this_task_arena::isolate([this] {
            const Progress progress; // not cancelled half-way: others wait for it
            strip_ = std::make_shared<const StripScene>(make_strip_scene(scene_, progress, links_));
        });
    });
    return strip_;
}

StripRay strip_ray(const ViewRay& ray, const LightSample& light) {
    if (light.is_directional) {
        const DirectionalPlane plane = plane_towards(ray.origin, ray.direction, light.towards_light);
        return {.coordinates = plane.coordinates,
                .cotangent = static_cast<float>(plane.cosine / plane.sine),
                .near_m = ray.near_m,
                .far_m = ray.far_m};
    }
    const LocalPlane plane = plane_through(ray.origin, ray.direction, light.position);
    return {.coordinates = plane.coordinates,
            .is_local = true,
            .light_x = static_cast<float>(plane.light_x),
            .light_y = static_cast<float>(plane.light_y),
            .near_m = ray.near_m,
            .far_m = ray.far_m};
}

namespace {
class ExactStrip final : public Visibility {
public:
    ExactStrip(const Scene& scene, const LightSample& light, std::shared_ptr<const StripScene> strip)
        : scene_(scene), light_(light), strip_(std::move(strip)) {
        if (strip_->object_count() == 0)
            statistics_.skip("exact strip", "nothing casts a shadow");
    }

    void lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const override {
        thread_local StripShadows shadows;
        thread_local std::vector<PartialShadow> partial;
        for (const ViewRay& ray : rays) {
            if (!light_.casts_shadow || strip_->object_count() == 0) {
                if (ray.near_m < ray.far_m)
                    rows.intervals.push_back({.near_m = ray.near_m, .far_m = ray.far_m});
                rows.end_ray();
                continue;
            }
            const StripRay strip = strip_ray(ray, light_);
            find_shadows(*strip_, strip, shadows);
            partial.clear();
            for (const PartialCut& cut : shadows.partial)
                if (!shadows.opaque.covers(cut.near_m, cut.far_m))
                    append_partial(cut, strip, shadows.opaque, partial);
            append_lit_intervals(shadows.opaque, partial, rows.intervals);
            rows.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    /// What stops all light joins the opaque shadows, which hide others from being looked up at all.
    void append_partial(const PartialCut& cut, const StripRay& ray, ShadowUnion& opaque,
                        std::vector<PartialShadow>& partial) const {
        thread_local std::vector<PartialShadow> of_cut;
        of_cut.clear();
        append_partial_shadows(scene_, *strip_, cut, ray, of_cut);
        for (const PartialShadow& shadow : of_cut)
            if (shadow.transmittance == Rgb(0.0f))
                opaque.insert(shadow.near_m, shadow.far_m);
            else
                partial.push_back(shadow);
    }

    const Scene& scene_;
    LightSample light_;
    std::shared_ptr<const StripScene> strip_;
    Statistics statistics_;
};
} // namespace

std::unique_ptr<Visibility> make_exact_strip(const Scene& scene, const LightSample& light,
                                             std::shared_ptr<const StripScene> strip) {
    return std::make_unique<ExactStrip>(scene, light, std::move(strip));
}
std::unique_ptr<Visibility> make_exact_strip(const Scene& scene, const View&, const LightSample& light,
                                             std::span<const ViewRay>, const Config&, Progress& progress) {
    return make_exact_strip(scene, light, std::make_shared<const StripScene>(make_strip_scene(scene, progress)));
}
} // namespace tyndall::light_shafts
