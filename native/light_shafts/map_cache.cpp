// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/map_cache.hpp"
#include <algorithm>
#include <optional>
#include <unordered_map>

namespace tyndall::light_shafts {
using slope_rows::Layout;
using slope_rows::Rows;

/// One to one. Based on: Stafford's variant 13 of the finaliser of MurmurHash3, as in SplitMix64.
static std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

void ContentDigest::feed_word(std::uint64_t word) {
    first_ = mixed((first_ + 0x9e3779b97f4a7c15u) ^ word);
    second_ = mixed((second_ + 0xd1342543de82ef95u) ^ std::rotl(word, 32));
}
void ContentDigest::feed(const ContentDigest& other) {
    feed_word(other.first_);
    feed_word(other.second_);
}
void ContentDigest::feed(const vec3& values) {
    for (int c = 0; c < 3; ++c)
        feed(values[c]);
}

bool NamedParts::operator==(const NamedParts& other) const {
    return std::ranges::equal(parts_, other.parts_,
                              [](const auto& a, const auto& b) { return !a.owner_before(b) && !b.owner_before(a); });
}

/// A picture in a viewport comes after rougher ones, which have maps of their own.
static constexpr std::uint64_t last_pictures = 8;

static bool is_map(CastKind kind) { return kind == CastKind::ParallelMap || kind == CastKind::PerspectiveMap; }

std::shared_ptr<const Rows> MapCache::find(const Key& key, const std::function<bool(const Rows&)>& are_enough) {
    return find_all(key, are_enough).rows;
}

MapCache::Kept MapCache::find_all(const Key& key, const std::function<bool(const Rows&)>& are_enough) {
    const std::lock_guard lock(mutex_);
    const auto found = entry_of_.find(key.digest);
    // The same address, but another object: the one before is gone.
    const bool is_kept = found != entry_of_.end() && *found->second->key.parts == *key.parts &&
                         (!are_enough || are_enough(*found->second->kept.rows));
    ++(is_map(key.kind) ? (is_kept ? counts_.found_maps : counts_.missed_maps)
                        : (is_kept ? counts_.found_rows : counts_.missed_rows));
    if (!is_kept)
        return {};
    entries_.splice(entries_.begin(), entries_, found->second);
    found->second->picture = picture_;
    return found->second->kept;
}

static std::size_t bytes_of(const Layout& layout) {
    return layout.rows.size() * sizeof(slope_rows::RowExtent) + layout.slice_directions.size() * sizeof(vec2) +
           (layout.x_at_centre.size() + layout.x_at_edge.size()) * sizeof(float);
}

void MapCache::keep_all(const Key& key, Kept kept, std::size_t instead_bytes) {
    const std::size_t bytes =
        sizeof(Entry) + key.parts->bytes() + kept.rows->bytes() + bytes_of(kept.rows->layout) + instead_bytes;
    const std::lock_guard lock(mutex_);
    if (const auto old = entry_of_.find(key.digest); old != entry_of_.end())
        remove(old->second);
    if (bytes > capacity_bytes_)
        return;
    while (bytes_ + bytes > capacity_bytes_) {
        if (entries_.back().picture + last_pictures > picture_)
            return;
        remove(std::prev(entries_.end()));
    }
    entries_.push_front({key, std::move(kept), bytes, picture_});
    entry_of_[key.digest] = entries_.begin();
    bytes_ += bytes;
}

void MapCache::begin_picture() {
    const std::lock_guard lock(mutex_);
    ++picture_;
}

std::shared_ptr<const Occluders> MapCache::occluders_of(const Scene& scene, const Progress& progress) {
    if (geometry_ != scene.geometry()) {
        auto gathered = std::make_shared<Occluders>(gather_occluders(scene.description(), progress, occluders_.get()));
        gathered->kept = std::make_shared<const KeptCasts>(*this, scene.description(), *gathered);
        occluders_ = std::move(gathered);
        geometry_ = scene.geometry();
    }
    return occluders_;
}

void MapCache::remove(std::list<Entry>::iterator entry) {
    bytes_ -= entry->bytes;
    entry_of_.erase(entry->key.digest);
    entries_.erase(entry);
}

std::size_t MapCache::bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
}

MapCache::Counts MapCache::counts() const {
    const std::lock_guard lock(mutex_);
    return counts_;
}

namespace {
/// What rows can tell of a scene's occluders.
class OccluderFeed {
public:
    explicit OccluderFeed(const SceneDescription& scene) : scene_(scene), occlusions_(scene.materials.size()) {}

    /// To whom the next ones belong.
    ContentDigest digest;
    std::vector<std::shared_ptr<const void>> parts; ///< Each once; all so far.
    std::vector<std::uint32_t> named;               ///< Of the parts; may repeat.

    void feed_shape(std::uint32_t placed_index) {
        const PlacedShape& placed = scene_.placed_shapes[placed_index];
        feed_part(scene_.shapes[shade_of(scene_, placed).value_or(placed.shape_index)]);
        for (int column = 0; column < 4; ++column)
            digest.feed(vec3(placed.world_from_object[column]));
    }
    /// A coloured or cut-out surface draws by the number of its instance, too.
    void feed(std::uint32_t index, bool is_partial) {
        if (index >= scene_.instances.size()) {
            feed_shape(index - static_cast<std::uint32_t>(scene_.instances.size()));
            return;
        }
        const Instance& instance = scene_.instances[index];
        feed_part(scene_.meshes[instance.mesh_index]);
        for (int column = 0; column < 4; ++column)
            digest.feed(vec3(instance.world_from_object[column]));
        digest.feed(is_partial ? std::uint64_t{index} + 1 : 0);
        if (is_partial)
            feed_what_programs_read(index);
        digest.feed(instance.slot_count);
        for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot)
            feed_material(scene_.slot_materials[instance.first_slot_material + slot]);
    }

private:
    void feed_what_programs_read(std::uint32_t index) {
        const Instance& instance = scene_.instances[index];
        digest.feed(vec3(scene_.origin_in_world));
        digest.feed(instance.random);
        if (const ParticleState* particle = scene_.particle_of(index)) {
            for (const float number :
                 {particle->index, particle->random, particle->age, particle->lifetime, particle->size})
                digest.feed(number);
            for (const vec3& vector : {particle->location, particle->velocity, particle->angular_velocity})
                digest.feed(vector);
        }
        if (scene_.object_infos.empty())
            return;
        const ObjectInfo& info = scene_.object_infos[instance.name_index];
        digest.feed(vec3(info.color));
        digest.feed(info.color.w);
        digest.feed(info.pass_index);
    }
    void feed_part(const std::shared_ptr<const void>& part) {
        digest.feed(std::bit_cast<std::uintptr_t>(part.get()));
        const auto [number, is_new] = number_of_.try_emplace(part.get(), static_cast<std::uint32_t>(parts.size()));
        if (is_new)
            parts.push_back(part);
        named.push_back(number->second);
    }
    void feed_material(std::uint32_t index) {
        std::optional<Occlusion>& occlusion = occlusions_[index];
        if (!occlusion)
            occlusion = occlusion_of(scene_.materials[index]);
        digest.feed(static_cast<std::uint64_t>(*occlusion));
        if (*occlusion == Occlusion::Partial)
            feed_transparency(scene_.materials[index]);
    }
    void feed_transparency(const Material& material) {
        digest.feed(material.constant.transparent);
        digest.feed(material.transparent_register);
        digest.feed(material.program.size());
        for (const SurfaceOp& op : material.program) {
            for (const auto number : {static_cast<std::uint16_t>(op.code), static_cast<std::uint16_t>(op.option),
                                      static_cast<std::uint16_t>(op.selector), static_cast<std::uint16_t>(op.shift),
                                      op.out, op.a, op.b, op.c, op.d, op.e, op.f, op.texture, op.texture_uv, op.table})
                digest.feed(number);
            digest.feed(op.value);
            for (int column = 0; column < 3; ++column)
                digest.feed(op.uv_matrix[column]);
        }
        digest.feed(material.textures.size());
        for (const std::shared_ptr<const Texture>& texture : material.textures)
            feed_part(texture);
        for (const ColorTable& table : material.tables)
            for (const vec4& value : table.values) {
                digest.feed(vec3(value));
                digest.feed(value.w);
            }
        for (const std::string& name : material.uv_map_names) {
            digest.feed(name.size());
            for (const char letter : name)
                digest.feed(letter);
        }
    }

    const SceneDescription& scene_;
    std::vector<std::optional<Occlusion>> occlusions_; ///< Per material, once it was asked for.
    std::unordered_map<const void*, std::uint32_t> number_of_;
};

void feed(ContentDigest& digest, const slope_rows::Linear& linear) {
    digest.feed({linear.at_origin, linear.per_axial, linear.per_radial});
}

void feed(ContentDigest& digest, const Layout& layout) {
    const slope_rows::Frame& frame = layout.frame;
    for (const vec3& axis : {frame.origin, frame.axis, frame.u, frame.v})
        digest.feed(axis);
    for (const bool flag : {frame.is_parallel, frame.is_angular, frame.is_orthographic})
        digest.feed(flag);
    digest.feed(frame.angle_scale);
    feed(digest, frame.x);
    feed(digest, frame.y);
    feed(digest, frame.w);
    for (const float number : {layout.first_slice, layout.slice_step, layout.first_line, layout.line_step,
                               layout.smallest_radius, layout.smallest_radius_cut})
        digest.feed(number);
    digest.feed(layout.slices_per_turn);
    digest.feed(layout.line_count);
    digest.feed(layout.rows.size());
    for (const slope_rows::RowExtent& row : layout.rows) {
        digest.feed(std::uint64_t{static_cast<std::uint32_t>(row.first)} << 32 | static_cast<std::uint32_t>(row.end));
        digest.feed(row.smallest_slope);
    }
}

/// Where it shines is a part of it: others may leave out other occluders.
void feed(ContentDigest& digest, const LightSample& light) {
    digest.feed(light.is_directional);
    digest.feed(light.is_directional ? light.towards_light : light.position);
    digest.feed(light.emission_normal);
    for (const vec3& inwards : light.cell != nullptr ? light.cell->inwards : decltype(light.cell->inwards){})
        digest.feed(inwards);
    if (light.cell != nullptr)
        digest.feed(light.cell->apex);
    if (light.spot == nullptr)
        return;
    digest.feed(light.spot->spot_axis); // of its one face
    digest.feed(light.spot->spot_half_angle_rad);
    digest.feed(light.softening_m2); // of an area light's lobe
    for (int column = 0; column < 3; ++column)
        digest.feed(light.spot->light_from_world_directions[column]);
}
} // namespace

/// A scene's boxes are rounded.
static Bounds3 grown(const Bounds3& box) {
    const vec3 farthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    const vec3 slack(1e-6f * (farthest.x + farthest.y + farthest.z));
    return {box.min - slack, box.max + slack};
}

KeptCasts::KeptCasts(MapCache& cache, const SceneDescription& scene, const Occluders& occluders) : cache_(cache) {
    constexpr std::size_t most_groups = 1024; // of each kind
    OccluderFeed feed(scene);
    const auto add_groups = [&](std::size_t count, Group like, const auto& feed_one, const auto& box_of) {
        const std::size_t size = count / most_groups + 1;
        for (std::size_t begin = 0; begin < count; begin += size) {
            Group& group = groups_.emplace_back(like);
            feed.digest = {};
            feed.named.clear();
            for (std::size_t i = begin; i < std::min(begin + size, count); ++i) {
                feed_one(i);
                group.box.grow(box_of(i));
            }
            group.box = grown(group.box);
            group.content = feed.digest;
            std::ranges::sort(feed.named);
            const auto repeated = std::ranges::unique(feed.named);
            group.parts.assign(feed.named.begin(), repeated.begin());
        }
    };
    const auto add_instances = [&](const auto& instances, bool is_partial, const auto& bounds_of_mesh) {
        add_groups(
            instances.size(), {.draws = is_partial}, [&](std::size_t i) { feed.feed(instances[i].index, is_partial); },
            [&](std::size_t i) {
                return transformed(bounds_of_mesh(*instances[i].mesh), *instances[i].scene_from_object);
            });
    };
    add_instances(occluders.instances, false, [](const OccluderMesh& mesh) { return mesh.bounds; });
    add_instances(occluders.partial_instances, true,
                  [](const PartialOccluderMesh& mesh) { return mesh.geometry->bounds; });
    if (occluders.traced) {
        const std::span<const std::uint32_t> placed = occluders.traced->placed();
        add_groups(
            placed.size(), {.is_traced = true}, [&](std::size_t i) { feed.feed_shape(placed[i]); },
            [&](std::size_t i) { return bounds_of(scene, scene.placed_shapes[placed[i]]); });
        around_traced_.feed(occluders.traced->bounds().min);
        around_traced_.feed(occluders.traced->bounds().max);
    }
    parts_ = std::move(feed.parts);
}

std::shared_ptr<const KeptCasts> KeptCasts::of(const SceneDescription& scene, const Occluders& some) const {
    return std::make_shared<const KeptCasts>(cache_, scene, some);
}

MapCache::Key KeptCasts::key(CastKind kind, const PartialShading& partial, const Layout& layout,
                             const MayShow& may_show, std::uint32_t resolution) const {
    MapCache::Key key{.digest = {}, .parts = {}, .kind = kind};
    const auto parts = std::make_shared<NamedParts>();
    std::vector<bool> has_part(parts_.size());
    bool draws = false, is_traced = false;
    for (const Group& group : groups_) {
        if (may_show && !may_show(group.box))
            continue;
        key.digest.feed(group.content);
        draws |= group.draws;
        is_traced |= group.is_traced;
        for (const std::uint32_t part : group.parts) {
            if (!has_part[part])
                parts->add(parts_[part]);
            has_part[part] = true;
        }
    }
    key.parts = parts;
    if (is_traced)
        key.digest.feed(around_traced_);
    key.digest.feed(static_cast<std::uint64_t>(kind));
    key.digest.feed(resolution);
    feed(key.digest, partial.light);
    feed(key.digest, layout);
    if (draws) {
        key.digest.feed(partial.seed);
        key.digest.feed(static_cast<std::uint64_t>(partial.channel));
    }
    return key;
}
} // namespace tyndall::light_shafts
