// SPDX-License-Identifier: GPL-3.0-or-later
// What occluders cast, kept from frame to frame: depth maps as they are before any edit, and the slope rows of lights
// without edits. An animated edit then costs its filters and its noise, and no triangle is rastered again.
// Differs:  nothing is told by names or by what was changed. All that rows depend on is their key: the meshes that may show
//           in them, where they stand, what their materials let pass, the light, and the rows' own layout. So pictures have
//           the same bits with and without a cache, whatever was rendered before; and what moves changes the rows of those
//           lights alone that see where it stood or stands.
// Bound:    as many bytes as it is given, and beside them the last scene's occluders, 36 bytes per triangle, which the next
//           scene takes over by the mesh. Rows that nobody asked for longest leave first, but not those of the last
//           pictures: where there is no room for all of a picture, a part of it stays, instead of nothing. A scene takes
//           some 0.1 us per instance, a key 0.1 us for each of at most a thousand groups of them, and 10 ns per row.
#pragma once
#include "light_shafts/cast_reach.hpp"
#include "light_shafts/partial_surface.hpp"
#include "light_shafts/slope_rows.hpp"
#include <bit>
#include <concepts>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>

namespace tyndall::light_shafts {
/// 128 bits of whatever was fed: two different contents are taken for the same once in 2^64 pairs of 2^64.
class ContentDigest {
public:
    void feed(std::integral auto number) { feed_word(static_cast<std::uint64_t>(number)); }
    void feed(float value) { feed_word(std::bit_cast<std::uint32_t>(value)); }
    void feed(const vec3& values);
    void feed(const ContentDigest& other);
    auto operator<=>(const ContentDigest&) const = default;

private:
    void feed_word(std::uint64_t word);

    std::uint64_t first_ = 0x243f6a8885a308d3u, second_ = 0x13198a2e03707344u; // digits of pi
};

/// Shared objects that a content names, in the order in which it does. Their addresses are part of its digest; these tell
/// whether it is still the same objects that live there.
class NamedParts {
public:
    void add(const std::shared_ptr<const void>& part) { parts_.push_back(part); }
    [[nodiscard]] bool operator==(const NamedParts& other) const;
    [[nodiscard]] std::size_t bytes() const { return sizeof(std::weak_ptr<const void>) * parts_.size(); }

private:
    std::vector<std::weak_ptr<const void>> parts_;
};

/// What some rows are of.
enum class CastKind : std::uint8_t {
    ParallelMap = 0,    ///< A sun's depth map.
    PerspectiveMap = 1, ///< A face of a lamp's.
    EpipolarRows = 2,
    ShadowMapRows = 3, ///< Slope rows that a depth map was rectified to.
    /// The same with the map, which answers the rays that rows cannot. An occluder that shows to those rays alone is no part
    /// of the key: for coarse pictures.
    WalkedMapRows = 4,
};

class Visibility; // visibility.hpp

/// Safe from any thread.
class MapCache {
public:
    explicit MapCache(std::size_t capacity_bytes) : capacity_bytes_(capacity_bytes) {}

    struct Key {
        ContentDigest digest;
        std::shared_ptr<const NamedParts> parts;
        CastKind kind;
    };
    /// Nothing where no such rows are kept, or they are not enough.
    [[nodiscard]] std::shared_ptr<const slope_rows::Rows>
    find(const Key& key, const std::function<bool(const slope_rows::Rows&)>& are_enough = {});
    struct Kept {
        std::shared_ptr<const slope_rows::Rows> rows;
        std::shared_ptr<const Visibility>
            instead; ///< What answers the rays that rows cannot; nothing: the exact strip.
    };
    /// The same with what was kept beside them.
    [[nodiscard]] Kept find_all(const Key& key, const std::function<bool(const slope_rows::Rows&)>& are_enough = {});
    /// Call it before each picture.
    void begin_picture();
    /// What of a scene stops light: gathered once for all scenes that share their geometry, as long as no other is asked
    /// about. Not for two threads at once. Throws Cancelled.
    [[nodiscard]] std::shared_ptr<const Occluders> occluders_of(const Scene& scene, const Progress& progress);
    /// Rows for which there is no room are not kept.
    void keep(const Key& key, std::shared_ptr<const slope_rows::Rows> rows) { keep_all(key, {std::move(rows), {}}, 0); }
    /// The same with what takes `instead_bytes` beside them.
    void keep_all(const Key& key, Kept kept, std::size_t instead_bytes);

    [[nodiscard]] std::size_t bytes() const;
    /// Of depth maps and of slope rows since the cache was made: those that were found, and those that were not.
    struct Counts {
        std::size_t found_maps = 0, missed_maps = 0, found_rows = 0, missed_rows = 0;
    };
    [[nodiscard]] Counts counts() const;

private:
    struct Entry {
        Key key;
        Kept kept;
        std::size_t bytes;
        std::uint64_t picture; ///< That asked for it last.
    };
    void remove(std::list<Entry>::iterator entry);

    std::size_t capacity_bytes_;
    mutable std::mutex mutex_;
    std::list<Entry> entries_; ///< Those last asked for come first.
    std::map<ContentDigest, std::list<Entry>::iterator> entry_of_;
    std::size_t bytes_ = 0;
    std::uint64_t picture_ = 0;
    Counts counts_;
    std::shared_ptr<const void> geometry_; ///< Of the occluders.
    std::shared_ptr<const Occluders> occluders_;
};

/// The cache, which must outlive this, for those who ask about one set of occluders.
class KeptCasts {
public:
    KeptCasts(MapCache& cache, const SceneDescription& scene, const Occluders& occluders);
    /// For some of the occluders.
    [[nodiscard]] std::shared_ptr<const KeptCasts> of(const SceneDescription& scene, const Occluders& some) const;

    [[nodiscard]] MapCache& cache() const { return cache_; }
    /// `may_show`: what it denies is no part of the key. `resolution`: of what lies behind the rows, where their layout
    /// does not tell.
    [[nodiscard]] MapCache::Key key(CastKind kind, const PartialShading& partial, const slope_rows::Layout& layout,
                                    const MayShow& may_show, std::uint32_t resolution = 0) const;

private:
    /// Of occluders that follow each other in the scene.
    struct Group {
        ContentDigest content = {};
        Bounds3 box = {};                      ///< In the scene's space, and a little larger.
        std::vector<std::uint32_t> parts = {}; ///< Into parts_.
        bool draws = false;                    ///< They let a part of the light pass: seeds matter.
        bool is_traced = false;
    };

    MapCache& cache_;
    std::vector<Group> groups_;
    std::vector<std::shared_ptr<const void>> parts_;
    ContentDigest around_traced_; ///< Of the box where shapes are traced: lines of light begin at its border.
};
} // namespace tyndall::light_shafts
