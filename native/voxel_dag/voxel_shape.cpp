// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/voxel_shape.hpp"
#include "image/srgb.hpp"
#include "voxel_dag/coarse_voxels.hpp"
#include "voxel_dag/node_shares.hpp"
#include "voxel_dag/tracer.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include "voxel_dag/voxels_of_entries.hpp"
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <mutex>

namespace tyndall::voxel_dag {
namespace {
/// A voxel, or a cube of 2^level by its lowest one, and one of its faces: Morton code, axis, and whether the face looks
/// along it.
struct FaceCode {
    Voxel voxel;
    std::uint32_t axis;
    bool is_upper;
    std::uint32_t level = 0;

    explicit FaceCode(std::uint64_t cell)
        : voxel(voxel_at((cell & ((std::uint64_t{1} << level_bit) - 1)) >> 3)),
          axis(static_cast<std::uint32_t>(cell >> 1 & 3)), is_upper((cell & 1) != 0),
          level(static_cast<std::uint32_t>(cell >> level_bit)) {}
    FaceCode(const Voxel& lowest, std::uint32_t across, bool looks_up, std::uint32_t of_level = 0)
        : voxel(lowest), axis(across), is_upper(looks_up), level(of_level) {}
    [[nodiscard]] std::uint64_t number() const {
        return std::uint64_t{level} << level_bit | morton_code(voxel) << 3 | std::uint64_t{axis} << 1 |
               std::uint64_t{is_upper};
    }
    [[nodiscard]] std::uint32_t width() const { return 1u << level; }

private:
    static constexpr std::uint32_t level_bit = 3 * most_level + 3;
    static_assert(level_bit + std::bit_width(most_level) < 63);
};

/// Finds a box around all voxels: exact up to 256^3, else within 1/256 of the cube.
class BoundsFinder final : public CellVisitor {
public:
    explicit BoundsFinder(float smallest_m) : smallest_m_(smallest_m) {}
    bool enters(const Bounds3& box) override {
        Bounds3 both = bounds;
        both.grow(box);
        if (both.min == bounds.min && both.max == bounds.max)
            return false;
        if (box.max.x - box.min.x > smallest_m_)
            return true;
        bounds = both;
        return false;
    }
    void meet(const Bounds3& cell) override { bounds.grow(cell); }
    Bounds3 bounds;

private:
    float smallest_m_;
};

class VoxelShape final : public CellShape {
public:
    VoxelShape(std::shared_ptr<const PlacedDag> placed, std::string name)
        : placed_(std::move(placed)), name_(std::move(name)), tracer_(placed_->dag),
          per_m_(static_cast<double>(resolution()) / placed_->bounds_m.side_m) {
        BoundsFinder finder(static_cast<float>(placed_->bounds_m.side_m * (1.5 / 256)));
        visit(finder);
        bounds_ = finder.bounds;
    }
    [[nodiscard]] const std::string& name() const override { return name_; }
    [[nodiscard]] std::uint64_t cell_count() const override { return placed_->dag.voxel_count; }
    [[nodiscard]] const Bounds3& bounds() const override { return bounds_; }

    [[nodiscard]] CellHit closest_hit(const Ray& ray) const override {
        const VoxelRay in_voxels = voxel_ray(ray);
        return cell_hit(ray, in_voxels, ray.near_m, tracer_.trace(in_voxels));
    }
    void closest_hits(std::span<const Ray> rays, std::span<const RayDetail> details,
                      std::span<CellHit> hits) const override {
        std::array<VoxelRay, most_rays> in_voxels;
        std::array<VoxelHit, most_rays> found;
        const NodeShares* shares = ready_shares_.load(std::memory_order_acquire);
        const bool knows_levels = shares != nullptr && !details.empty();
        for (std::size_t i = 0; i < rays.size(); ++i)
            in_voxels[i] = knows_levels ? detailed_ray(rays[i], details[i], *shares) : voxel_ray(rays[i]);
        if (rays.size() == 1)
            found[0] = tracer_.trace(in_voxels[0]);
        else
            tracer_.trace(std::span(in_voxels).first(rays.size()), found);
        for (std::size_t i = 0; knows_levels && i < rays.size(); ++i)
            widen(in_voxels[i], found[i]);
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i] = cell_hit(rays[i], in_voxels[i], knows_levels ? 0.0f : rays[i].near_m, found[i]);
    }
    void prepare_detail(const Progress& progress) const override {
        const std::lock_guard lock(preparing_);
        if (shares_ != nullptr)
            return;
        shares_ = std::make_unique<const NodeShares>(tracer_.node_shares(progress));
        ready_shares_.store(shares_.get(), std::memory_order_release);
    }

    [[nodiscard]] CellFace face(std::uint64_t cell) const override {
        const FaceCode face(cell);
        const Bounds3 box = box_of(face.voxel, face.width());
        const auto a = static_cast<int>(face.axis);
        CellFace result{.corner = box.min, .first_edge = vec3(0.0f), .second_edge = vec3(0.0f)};
        if (face.is_upper)
            result.corner[a] = box.max[a];
        const int first = (a + 1) % 3, second = (a + 2) % 3;
        result.first_edge[first] = box.max[first] - box.min[first];
        result.second_edge[second] = box.max[second] - box.min[second];
        return result;
    }

    void visit(CellVisitor& visitor) const override {
        if (!placed_->dag.is_empty())
            visit(visitor, placed_->dag.level, root_of(placed_->dag), {0, 0, 0});
    }

    [[nodiscard]] Bounds3 box(std::uint64_t cell) const override {
        const FaceCode face(cell);
        return box_of(face.voxel, face.width());
    }
    [[nodiscard]] bool is_cube(std::uint64_t cell) const override { return FaceCode(cell).level > 0; }
    [[nodiscard]] CellLook look(std::uint64_t cell) const override {
        CellLook look;
        if (placed_->attributes == nullptr)
            return look;
        FaceCode cube(cell);
        if (cube.level >= least_mean_level && !placed_->attributes->has_means())
            go_to_part(cube);
        const auto sample = placed_->attributes->sample_at(placed_->dag, cube.voxel, cube.level);
        return sample ? look_of(*sample) : look;
    }
    [[nodiscard]] std::optional<std::vector<std::uint64_t>>
    open_faces(const std::function<bool(const CellLook&)>& is_wanted, std::size_t most,
               const Progress& progress) const override {
        const auto is_sample_wanted = [&](const VoxelSample& sample) { return is_wanted(look_of(sample)); };
        const std::vector<bool> wanted = placed_->attributes != nullptr
                                             ? placed_->attributes->materials_where(is_sample_wanted)
                                             : std::vector<bool>{is_wanted(CellLook{})};
        const std::lock_guard lock(finding_faces_);
        if (faces_.most != most || faces_.wanted != wanted)
            faces_ = {wanted, most, find_open_faces(wanted, most, progress)};
        return faces_.found;
    }
    [[nodiscard]] std::span<const std::string> channel_names() const override {
        return placed_->attributes == nullptr ? std::span<const std::string>()
                                              : std::span<const std::string>(placed_->attributes->layout().channels);
    }
    [[nodiscard]] bool has_normals() const override {
        return placed_->attributes != nullptr && placed_->attributes->layout().normal_bits > 0;
    }
    [[nodiscard]] bool is_occluded(const Ray& ray) const override { return tracer_.is_occluded(voxel_ray(ray)); }

private:
    static constexpr std::size_t most_rays = 16;
    static constexpr std::uint64_t most_searched = std::uint64_t{1} << 28; ///< Voxels: a second, about.

    /// `from_m`: where the ray in voxels begins, on the ray.
    [[nodiscard]] static CellHit cell_hit(const Ray& ray, const VoxelRay& in_voxels, float from_m,
                                          const VoxelHit& hit) {
        if (!hit.is_hit())
            return {};
        const std::uint32_t axis = hit.axis < 3 ? hit.axis : largest_axis(in_voxels.direction);
        const auto a = static_cast<int>(axis);
        const FaceCode face(hit.voxel, axis, in_voxels.direction[a] < 0.0, hit.level);
        CellHit result{.distance_m = std::min(static_cast<float>(double{from_m} + hit.distance), ray.far_m),
                       .cell = face.number(),
                       .normal = vec3(0.0f)};
        result.normal[a] = face.is_upper ? 1.0f : -1.0f;
        const dvec3 place = in_voxels.origin + hit.distance * in_voxels.direction;
        for (int edge = 0; edge < 2; ++edge) {
            const int along = (a + 1 + edge) % 3;
            const double within = place[along] - static_cast<double>(hit.voxel[static_cast<std::size_t>(along)]);
            result.on_face[edge] = static_cast<float>(std::clamp(within / face.width(), 0.0, 1.0));
        }
        return result;
    }
    [[nodiscard]] CellLook look_of(const VoxelSample& sample) const {
        CellLook look;
        if (placed_->attributes->layout().has_colors)
            for (int channel = 0; channel < 3; ++channel)
                look.color[channel] = linear_from_srgb(static_cast<float>(sample.color >> 8 * channel & 0xff) / 255.0f);
        look.normal = sample.normal;
        for (std::size_t channel = 0; channel < look.channels.size(); ++channel)
            look.channels[channel] = static_cast<float>(sample.channels[channel]) / 255.0f;
        return look;
    }
    /// `wanted`: by materials of attributes; without these one for all. In any order.
    [[nodiscard]] std::optional<std::vector<Voxel>> wanted_voxels(const std::vector<bool>& wanted, std::size_t most,
                                                                  const Progress& progress) const {
        const PackedDag& dag = placed_->dag;
        if (placed_->attributes != nullptr) {
            if (dag.voxel_count > most_searched)
                return std::nullopt;
            const auto entries = placed_->attributes->entries_of(wanted, most, progress);
            if (!entries)
                return std::nullopt;
            return voxels_of_entries(dag, placed_->attributes->parts().order, *entries);
        }
        if (dag.is_empty() || !wanted[0])
            return std::vector<Voxel>();
        if (dag.voxel_count > most)
            return std::nullopt;
        return voxels_of(coarse_voxels(dag, 0, ~std::uint64_t{0}, progress));
    }
    [[nodiscard]] std::optional<std::vector<std::uint64_t>>
    find_open_faces(const std::vector<bool>& wanted, std::size_t most, const Progress& progress) const {
        const std::optional<std::vector<Voxel>> voxels = wanted_voxels(wanted, most, progress);
        if (!voxels)
            return std::nullopt;
        std::vector<std::uint64_t> faces;
        for (const Voxel& voxel : *voxels)
            for (std::uint32_t axis = 0; axis < 3; ++axis)
                for (const bool is_upper : {false, true}) {
                    Voxel beside = voxel; // below 0 there is none, as beyond the last
                    beside[axis] += is_upper ? 1u : ~0u;
                    if (placed_->dag.contains(beside))
                        continue;
                    if (faces.size() == most)
                        return std::nullopt;
                    faces.push_back(FaceCode(voxel, axis, is_upper).number());
                }
        return faces;
    }
    /// From a voxel that was found to stop the ray to the cube around it whose means it is to show, if there are any.
    void widen(const VoxelRay& ray, VoxelHit& hit) const {
        if (!hit.is_hit() || placed_->attributes == nullptr)
            return;
        const double widest = std::max(ray.width, ray.spread * hit.distance);
        while (hit.level + 1 < placed_->dag.level && static_cast<double>(2u << hit.level) <= widest)
            ++hit.level;
        for (std::uint32_t& lowest : hit.voxel)
            lowest = lowest >> hit.level << hit.level;
    }
    /// From its own origin on: what it wants to know grows from there.
    [[nodiscard]] VoxelRay detailed_ray(const Ray& ray, const RayDetail& detail, const NodeShares& shares) const {
        return {.origin = (dvec3(ray.origin) - placed_->bounds_m.lower_m) * per_m_,
                .direction = dvec3(ray.direction) * per_m_,
                .end = double{ray.far_m},
                .width = double{detail.width_m} * per_m_,
                .spread = double{detail.spread} * per_m_,
                .start = double{ray.near_m},
                .shares = &shares,
                .number = double{detail.number},
                .asks_voxels_of_sheets = !has_normals()}; // the mean of the sides that are seen is not known
    }
    /// From a cube of which no means are kept to the first part of it whose voxels can be averaged.
    void go_to_part(FaceCode& cube) const {
        PackedNode node = root_of(placed_->dag);
        for (std::uint32_t level = placed_->dag.level; level >= least_mean_level; --level) {
            const PackedHeader header = opened(placed_->dag, level, node);
            const auto& stored = cube_group.octant[cube_group.inverse[node.turn]];
            const std::uint32_t below = level - 1;
            std::uint32_t there =
                (cube.voxel[0] >> below & 1) | (cube.voxel[1] >> below & 1) << 1 | (cube.voxel[2] >> below & 1) << 2;
            if (level <= cube.level) {
                while ((header.child_mask >> stored[there] & 1) == 0)
                    ++there;
                cube.voxel = octant_of(cube.voxel, there, 1u << below);
            }
            node = child_of(placed_->dag, level, node, header, stored[there]);
        }
        cube.level = least_mean_level - 1;
    }
    [[nodiscard]] VoxelRay voxel_ray(const Ray& ray) const {
        const dvec3 direction(ray.direction);
        const dvec3 start = dvec3(ray.origin) + double{ray.near_m} * direction; // tracing begins at 0
        return {.origin = (start - placed_->bounds_m.lower_m) * per_m_,
                .direction = direction * per_m_,
                .end = double{ray.far_m} - double{ray.near_m}};
    }
    [[nodiscard]] std::uint64_t resolution() const { return std::uint64_t{1} << placed_->dag.level; }
    static std::uint32_t largest_axis(const dvec3& direction) {
        const dvec3 size = glm::abs(direction);
        if (size.x >= size.y && size.x >= size.z)
            return 0;
        return size.y >= size.z ? 1 : 2;
    }
    /// The same expression for the same plane, whoever has it for a face.
    [[nodiscard]] float plane(int axis, std::uint32_t index) const {
        return static_cast<float>(placed_->bounds_m.lower_m[axis] +
                                  placed_->bounds_m.side_m *
                                      (static_cast<double>(index) / static_cast<double>(resolution())));
    }
    [[nodiscard]] Bounds3 box_of(const Voxel& lowest, std::uint32_t width) const {
        Bounds3 box;
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint32_t first = lowest[static_cast<std::size_t>(axis)];
            box.min[axis] = plane(axis, first);
            box.max[axis] = plane(axis, first + width);
        }
        return box;
    }
    static Voxel octant_of(const Voxel& lowest, std::uint32_t octant, std::uint32_t width) {
        return {lowest[0] + (octant & 1) * width, lowest[1] + (octant >> 1 & 1) * width,
                lowest[2] + (octant >> 2) * width};
    }

    void visit(CellVisitor& visitor, std::uint32_t level, const PackedNode& node, const Voxel& lowest) const {
        if (!visitor.enters(box_of(lowest, 1u << level)))
            return;
        if (level == leaf_level) {
            visit_leaf(visitor, node, lowest);
            return;
        }
        const PackedHeader header = opened(placed_->dag, level, node);
        const auto& stored = cube_group.octant[cube_group.inverse[node.turn]];
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            if ((header.child_mask >> stored[octant] & 1) != 0)
                visit(visitor, level - 1, child_of(placed_->dag, level, node, header, stored[octant]),
                      octant_of(lowest, octant, 1u << (level - 1)));
    }
    void visit_leaf(CellVisitor& visitor, const PackedNode& node, const Voxel& lowest) const {
        const TurnedLeaf leaf = leaf_of(placed_->dag, node);
        const auto& stored = cube_group.octant[cube_group.inverse[leaf.turn]];
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            const std::uint64_t eighth = leaf.mask >> 8 * stored[octant] & 0xff;
            const Voxel corner = octant_of(lowest, octant, 2);
            if (eighth == 0 || !visitor.enters(box_of(corner, 2)))
                continue;
            for (std::uint32_t voxel = 0; voxel < 8; ++voxel)
                if ((eighth >> stored[voxel] & 1) != 0)
                    visitor.meet(box_of(octant_of(corner, voxel, 1), 1));
        }
    }

    std::shared_ptr<const PlacedDag> placed_;
    std::string name_;
    Tracer tracer_;
    double per_m_;
    Bounds3 bounds_;
    /// What was last asked for: a scene in which something else moved asks the same.
    struct KeptFaces {
        std::vector<bool> wanted;
        std::size_t most = 0;
        std::optional<std::vector<std::uint64_t>> found;
    };
    mutable std::mutex finding_faces_;
    mutable KeptFaces faces_;
    mutable std::mutex preparing_;
    mutable std::unique_ptr<const NodeShares> shares_; ///< Made when rays first ask for cubes.
    mutable std::atomic<const NodeShares*> ready_shares_{nullptr};
};
} // namespace

std::unique_ptr<const CellShape> make_voxel_shape(std::shared_ptr<const PlacedDag> placed, std::string name) {
    return std::make_unique<const VoxelShape>(std::move(placed), std::move(name));
}
} // namespace tyndall::voxel_dag
