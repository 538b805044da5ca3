// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/kept_surfaces.hpp"
#include <algorithm>

namespace tyndall::render {
/// A picture in a viewport comes after rougher ones, which have passes of their own.
static constexpr std::uint64_t last_pictures = 8;
static constexpr std::size_t kept_counts = 8;
/// Per pixel; of a few more than one surface point.
static constexpr std::size_t sample_bytes = 100, point_bytes = 300, point_bytes_per_light = 16;
/// And of its lobes.
static constexpr std::size_t lobes_bytes = 175, lobes_bytes_per_light = 12;

bool SurfaceKey::operator==(const SurfaceKey& other) const {
    return geometry == other.geometry && world.shines_as(other.world) && camera == other.camera &&
           region == other.region && filter == other.filter && filter_width_px == other.filter_width_px &&
           is_filtered == other.is_filtered && seed == other.seed && sample_index == other.sample_index &&
           path == other.path && bounce_rays == other.bounce_rays && parts == other.parts;
}

bool CountsKey::operator==(const CountsKey& other) const {
    const auto are_alike = [](const Light& a, const Light& b) {
        return a.scatters_in_media == b.scatters_in_media && lights_surfaces_alike(a, b);
    };
    return surfaces == other.surfaces && may_share_world == other.may_share_world &&
           attenuates_light == other.attenuates_light && world_scatters == other.world_scatters &&
           longest_turn == other.longest_turn && pixel_samples == other.pixel_samples &&
           grid_method == other.grid_method && grid_error_target == other.grid_error_target &&
           shafts_seed == other.shafts_seed && edited_shadows == other.edited_shadows &&
           std::ranges::equal(lights, other.lights, are_alike);
}

std::size_t KeptPass::bytes() const {
    std::size_t sum = sizeof(*this);
    for (const std::vector<SurfaceBlock>& band : bands)
        for (const SurfaceBlock& block : band)
            sum += block.bytes();
    return sum;
}

void KeptPass::move_to(std::shared_ptr<const void> geometry, const StoodAt& moved) {
    key.geometry = std::move(geometry);
    for (const auto& [index, places] : moved) {
        std::vector<mat4>& known = stood_at[index];
        // Where it has stood since the pass was complete, no block was traced, unless the pass was at work there.
        for (const mat4& place : places)
            if ((known.empty() || is_at_work) && std::ranges::find(known, place) == known.end())
                known.push_back(place);
    }
    is_at_work = false;
}

void KeptPass::finish(std::vector<KeptLight> lights_of_key) {
    lights = std::move(lights_of_key);
    stood_at.clear();
    is_at_work = false;
}

void KeptSurfaces::begin_picture(const Scene& scene) {
    ++picture_;
    const std::shared_ptr<const void> geometry = scene.geometry();
    if (last_scene_ && last_scene_->geometry() == geometry)
        return;
    const auto moved = last_scene_ ? moved_instances(last_scene_->description(), scene.description()) : std::nullopt;
    if (moved) {
        for (const Entry& entry : entries_)
            entry.pass->move_to(geometry, *moved);
    } else {
        entries_.clear();
        bytes_ = 0;
    }
    counts_.clear();
    last_scene_ = std::make_unique<const Scene>(scene, std::vector<Light>{}, World{});
}

SurfaceForm KeptSurfaces::form_for(std::size_t pixel_count, std::size_t light_count, bool has_lobes) const {
    const std::size_t of_point = point_bytes + point_bytes_per_light * light_count,
                      of_lobes = has_lobes ? lobes_bytes + lobes_bytes_per_light * light_count : 0;
    if (pixel_count * (of_point + of_lobes) <= capacity_bytes_ / 4 * 3)
        return SurfaceForm::Points;
    return pixel_count * sample_bytes <= capacity_bytes_ / 2 ? SurfaceForm::Samples : SurfaceForm::Nothing;
}

std::shared_ptr<KeptPass> KeptSurfaces::find(const SurfaceKey& key) {
    const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) { return entry.pass->key == key; });
    if (found == entries_.end())
        return nullptr;
    entries_.splice(entries_.begin(), entries_, found);
    found->picture = picture_;
    return found->pass;
}

void KeptSurfaces::keep(std::shared_ptr<KeptPass> pass) {
    const std::size_t bytes = pass->bytes();
    const auto takes_its_place = [&](const SurfaceKey& other) {
        return other.camera.width_px == pass->key.camera.width_px &&
               other.camera.height_px == pass->key.camera.height_px && other.sample_index == pass->key.sample_index;
    };
    for (auto entry = entries_.begin(); entry != entries_.end();)
        if (const auto here = entry++; takes_its_place(here->pass->key))
            remove(here);
    while (!entries_.empty() && bytes_ + bytes > capacity_bytes_ && entries_.back().picture + last_pictures <= picture_)
        remove(std::prev(entries_.end()));
    if (bytes_ + bytes > capacity_bytes_)
        return;
    entries_.push_front({std::move(pass), bytes, picture_});
    bytes_ += bytes;
}

void KeptSurfaces::count_again(const KeptPass& pass) {
    const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) { return entry.pass.get() == &pass; });
    if (found == entries_.end())
        return;
    bytes_ -= found->bytes;
    found->bytes = pass.bytes();
    bytes_ += found->bytes;
    if (bytes_ > capacity_bytes_)
        remove(found);
}

const ShadowRayCounts* KeptSurfaces::find_counts(const CountsKey& key) const {
    const auto found = std::ranges::find_if(counts_, [&](const auto& kept) { return kept.first == key; });
    return found == counts_.end() ? nullptr : &found->second;
}

void KeptSurfaces::keep_counts(CountsKey key, ShadowRayCounts counts) {
    counts_.emplace_front(std::move(key), std::move(counts));
    if (counts_.size() > kept_counts)
        counts_.pop_back();
}

void KeptSurfaces::remove(std::list<Entry>::iterator entry) {
    bytes_ -= entry->bytes;
    entries_.erase(entry);
}
} // namespace tyndall::render
