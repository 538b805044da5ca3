// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame_shafts.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "light_shafts/forward_fog.hpp"
#include "light_shafts/shared_strata.hpp"
#include "render/drawn_shafts.hpp"
#include "render/pixel_footprint.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>

namespace tyndall::render {
/// Its spacing is that in the picture's middle.
static light_shafts::View view_of_picture(const Camera& camera) {
    light_shafts::View view = light_shafts::view_of(camera);
    view.spacing = camera.is_panoramic()
                       ? pixel_footprint(camera, glm::normalize(camera.forward())).spread
                       : (camera.window_right - camera.window_left) / static_cast<float>(camera.width_px);
    return view;
}

/// Those of the region, and those beside it that the air's texture is carried over from; `all` lives as long as the call.
static std::span<const light_shafts::ViewRay> rays_to_prepare(const WaitingParts& waiting, const WaitingParts* of_frame,
                                                              const FrameAir* air,
                                                              std::vector<light_shafts::ViewRay>&& all = {}) {
    if (of_frame != nullptr)
        return of_frame->rays;
    if (!air || !air->sees_beside())
        return waiting.rays;
    all = waiting.rays;
    all.insert(all.end(), air->square_rays().begin(), air->square_rays().end());
    return all;
}

static light_shafts::Config with_limit(const Scene& scene, const Media& media, const Camera& camera,
                                       const FrameShafts::Config& config) {
    light_shafts::Config shafts = config.shafts;
    if (config.may_draw && !config.wants_visibility && !config.wants_lit_moments && config.air == nullptr)
        shafts.rows_limit = rows_limit(scene, media, shafts,
                                       static_cast<double>(config.taken_samples) * camera.width_px * camera.height_px,
                                       config.pixel_samples);
    return shafts;
}

FrameShafts::FrameShafts(const Scene& scene, const Media& media, const Camera& camera, const Region& region,
                         const WaitingParts& waiting, const Config& config, Statistics& statistics, Progress& progress)
    : media_(media), camera_(camera), waiting_(waiting), region_(region), config_(config),
      shafts_(scene, media, view_of_picture(camera), rays_to_prepare(waiting, config.of_frame, config.air),
              with_limit(scene, media, camera, config), progress) {
    statistics.append(shafts_.statistics());
    slots_.assign(shafts_.slots().begin(), shafts_.slots().end());
    if (config.emitters != nullptr)
        glow_.emplace(scene, media, *config.emitters, config.shafts.attenuates_light, statistics,
                      config.kept_light_trees);
    if (glow_ && glow_->is_empty())
        glow_.reset();
    const light_shafts::LeftLights& left = shafts_.left();
    if (left.lamps)
        statistics.skip("light shafts: rows of lamps", "draws for each sample take a small part of their time");
    if (left.world) {
        const auto lack = light_shafts::lack_of_directions(scene, config.shafts);
        statistics.skip("light shafts: rows of the world",
                        lack && lack->is_worth_draws()
                            ? "fog scatters farther forward than its directions are dense: each sample draws some"
                            : "draws for each sample take a small part of their time");
    }
    if (left.is_any()) {
        drawn_.emplace(scene, media, *config.emitters,
                       SentAir::Config{.attenuates_light = config.shafts.attenuates_light,
                                       .world_scatters = left.world,
                                       .has_lamps = left.lamps,
                                       .has_suns = false,
                                       .has_glow = false},
                       config.kept_light_trees);
        if (drawn_->is_empty())
            drawn_.reset();
        else
            add_slots_of(drawn_->light_groups());
    }
    if (!glow_)
        return;
    const StageTimer timer(statistics, "glow in fog: pilot");
    if (config.pilot != nullptr && !config.shafts.walks_maps)
        glow_->prepare(*config.pilot, progress);
    statistics.count("glow in fog: draws per ray", static_cast<double>(glow_->draw_count()) / glow_->turn());
    statistics.count("glow in fog: draws directions", glow_->draws_directions() ? 1.0 : 0.0);
    add_slots_of(glow_->light_groups());
}

void FrameShafts::add_slots_of(std::span<const std::uint8_t> groups) {
    for (const std::uint8_t group : groups)
        if (config_.shafts.keeps_groups_apart && std::ranges::find(slots_, group) == slots_.end())
            slots_.push_back(group);
}

void FrameShafts::deal_cells(std::uint32_t round, const Progress& progress) {
    // Each round deals the cells out anew: 5 is a step along the squares of 4 x 4 and of 2 x 2.
    const std::uint32_t turned = round * 5;
    for (std::size_t pixel = 0; pixel < pixel_count(); ++pixel)
        cells_.insert(
            cells_.end(), waiting_.first[pixel + 1] - waiting_.first[pixel],
            static_cast<std::uint8_t>(
                (turned + light_shafts::cell_of_pixel(region_.x0 + static_cast<std::uint32_t>(pixel % width()),
                                                      region_.y0 + static_cast<std::uint32_t>(pixel / width()))) %
                16));
    shafts_.set_alone(waiting_.rays, view_of_picture(camera_), config_.round_samples, cells_, progress);
    air_ = shafts_.find_air(waiting_.rays, progress);
}

void FrameShafts::begin_pass(std::uint32_t sample_index, const Progress& progress) {
    sample_index_ = sample_index;
    turn_ = {sample_index % config_.round_samples, config_.round_samples};
    std::array used{true, false, false};
    if (shares_strata(config_.shafts))
        used = shafts_.sides_used(config_.round_samples);
    cells_.clear();
    if (used[1] || used[2])
        deal_cells(sample_index / config_.round_samples, progress);
    if (config_.air) {
        heterogeneity_.resize(waiting_.rays.size());
        config_.air->ask_squares(shafts_, turn_, progress);
    }
    if (config_.wants_lit_moments)
        lit_moments_.resize(waiting_.rays.size());
    of_slot_.resize(slots_.size());
    if (of_slot_.size() > 1) {
        of_all_.radiance.resize(waiting_.rays.size());
        of_all_.visibility.resize(config_.wants_visibility ? waiting_.rays.size() : 0);
    }
    for (std::size_t index = 0; index < of_slot_.size() * used.size(); ++index) {
        const std::size_t side = index % used.size();
        OfSide& light = of_slot_[index / used.size()][side];
        light.radiance.resize(used[side] ? waiting_.rays.size() : 0);
        if (side > 0) {
            light.patterned.resize(light.radiance.size());
            light.patterned_unshadowed.resize(light.radiance.size());
        }
        if (config_.wants_visibility)
            light.visibility.resize(light.radiance.size());
    }
}

std::size_t FrameShafts::scatter(const Band& band, const Progress& progress) {
    const std::size_t first = waiting_.first[std::size_t{band.first_row} * width()];
    const std::size_t count = waiting_.first[std::size_t{band.end_row} * width()] - first;
    std::vector<light_shafts::ScatteredBySide> out(shafts_.slots().size());
    for (std::size_t slot = 0; slot < out.size(); ++slot)
        for (std::size_t side = 0; side < out[slot].size(); ++side) {
            auto& [radiance, visibility, patterned, unshadowed] = of_slot_[slot][side];
            const auto part_of = [&](auto& values) {
                return values.empty() ? std::span(values) : std::span(values).subspan(first, count);
            };
            out[slot][side] = {part_of(radiance), part_of(visibility), part_of(patterned), part_of(unshadowed)};
        }
    const std::span<const light_shafts::ViewRay> rays = std::span(waiting_.rays).subspan(first, count);
    const std::span<const std::uint8_t> cells(cells_);
    shafts_.scatter(rays, cells.empty() ? cells : cells.subspan(first, count), out, progress, turn_);
    if (glow_ || drawn_)
        add_draws(band, progress);
    if (!lit_moments_.empty())
        std::ranges::copy(shafts_.find_lit_moments(rays, progress, turn_),
                          lit_moments_.begin() + static_cast<std::ptrdiff_t>(first));
    return count;
}

void FrameShafts::add_draws(const Band& band, const Progress& progress) {
    const std::size_t first_pixel = std::size_t{band.first_row} * width(), first = waiting_.first[first_pixel],
                      end = waiting_.first[std::size_t{band.end_row} * width()];
    for (std::size_t slot = shafts_.slots().size(); slot < slots_.size(); ++slot) {
        const auto clear = [&]<class Value>(std::vector<Value>& values) {
            if (!values.empty())
                std::ranges::fill(std::span(values).subspan(first, end - first), Value(0.0f));
        };
        for (OfSide& side : of_slot_[slot]) {
            clear(side.radiance);
            clear(side.visibility);
            clear(side.patterned);
            clear(side.patterned_unshadowed);
        }
    }
    parallel_for(
        std::size_t{band.end_row} * width() - first_pixel, progress,
        [&](std::size_t index) {
            const std::size_t pixel = first_pixel + index;
            const std::uint32_t seed =
                pixel_seed(camera_, config_.seed, region_.x0 + static_cast<std::uint32_t>(pixel % width()),
                           region_.y0 + static_cast<std::uint32_t>(pixel / width()));
            for (std::size_t part = waiting_.first[pixel]; part < waiting_.first[pixel + 1]; ++part)
                add_draws_of(part, static_cast<std::uint32_t>(part - waiting_.first[pixel]), seed);
        },
        64);
}

void FrameShafts::add_draws_of(std::size_t part, std::uint32_t number, std::uint32_t seed) {
    constexpr std::uint32_t of_camera_rays = 0x6169'7221; // a seed apart from that of rays that are sent on
    constexpr std::uint32_t of_turns = 0x7475'726e;
    thread_local MediaLine line;
    thread_local std::vector<FogGlow::Found> found;
    // Pixels have their turns at different samples, so that no sample is darker than others.
    const auto draw = [&](std::uint32_t draws, std::uint32_t turn, const auto& draw_once) {
        if ((sample_index_ + hash(seed, of_turns)) % turn != 0)
            return;
        for (std::uint32_t index = 0; index < draws; ++index) {
            found.clear();
            draw_once(sample_index_ / turn * draws + index);
            for (const auto& [radiance, group] : found)
                of_slot_[slot_of(group)][0].radiance[part] +=
                    radiance * (static_cast<float>(turn) / static_cast<float>(draws));
        }
    };
    line.assign(media_, waiting_.rays[part], StepLimits{});
    if (line.is_empty())
        return;
    if (drawn_)
        draw(shaft_draws(config_.shafts, config_.pixel_samples), 1, [&](std::uint32_t index) {
            drawn_->draw(line, {hash(seed, number, of_camera_rays), index, number}, found);
        });
    if (glow_)
        draw(glow_->draw_count(), glow_->turn(), [&](std::uint32_t index) {
            glow_->draw(line, {seed, index, number}, found);
        });
}

void FrameShafts::find_heterogeneity(const Band& band, const Progress& progress) {
    if (!config_.air)
        return;
    const std::size_t first_pixel = std::size_t{band.first_row} * width(),
                      end_pixel = std::size_t{band.end_row} * width();
    const std::size_t first = waiting_.first[first_pixel], count = waiting_.first[end_pixel] - first;
    config_.air->find(shafts_, turn_, waiting_, first_pixel, end_pixel,
                      std::span(of_slot_.size() > 1 ? of_all_.radiance : of_slot_[0][0].radiance).subspan(first, count),
                      std::span(heterogeneity_).subspan(first, count), progress);
}

void FrameShafts::add_slots(const Band& band) {
    const std::size_t first = waiting_.first[std::size_t{band.first_row} * width()],
                      end = waiting_.first[std::size_t{band.end_row} * width()];
    for (std::size_t ray = first; ray < end; ++ray) {
        of_all_.radiance[ray] = Rgb(0.0f);
        if (config_.wants_visibility)
            of_all_.visibility[ray] = 0.0f;
        for (const OfSides& slot : of_slot_) {
            of_all_.radiance[ray] += slot[0].radiance[ray];
            if (config_.wants_visibility)
                of_all_.visibility[ray] += slot[0].visibility[ray];
        }
    }
}

Rgb FrameShafts::sum_of_slot(std::size_t slot, std::size_t first, std::size_t count) const {
    Rgb sum(0.0f);
    for (std::size_t part = first; part < first + count; ++part)
        sum += (heterogeneity_.empty() ? 1.0f : heterogeneity_[part]) * waiting_.weights[part] *
               of_slot_[slot][0].radiance[part];
    return sum;
}

void FrameShafts::sum(const Band& band, const Deliver& deliver, const Progress& progress) {
    for (OfSides& of_side : of_slot_) {
        auto& [radiance, visibility, patterned, unshadowed] = of_side[0];
        for (std::size_t side = 1; side < of_side.size(); ++side)
            if (const OfSide& shared = of_side[side]; !shared.radiance.empty())
                light_shafts::add_shared(
                    {width(), region_.y1 - region_.y0, waiting_.first, air_, cells_}, light_shafts::shared_sides[side],
                    band.first_row, band.end_row,
                    {shared.radiance, shared.visibility, shared.patterned, shared.patterned_unshadowed},
                    {radiance, visibility, patterned, unshadowed}, progress);
    }
    if (of_slot_.size() > 1)
        add_slots(band);
    const auto& [radiance, visibility, patterned, unshadowed] = of_slot_.size() > 1 ? of_all_ : of_slot_[0][0];
    find_heterogeneity(band, progress);
    const std::size_t first_pixel = std::size_t{band.first_row} * width();
    parallel_for(std::size_t{band.end_row} * width() - first_pixel, progress, [&](std::size_t index) {
        const std::size_t pixel = first_pixel + index;
        const std::size_t first = waiting_.first[pixel], count = waiting_.first[pixel + 1] - first;
        const auto part_of = [&](const auto& values) {
            return values.empty() ? std::span(values) : std::span(values).subspan(first, count);
        };
        const SeenShafts seen = sum_of_parts(part_of(waiting_.weights), part_of(radiance), part_of(visibility),
                                             part_of(lit_moments_), part_of(heterogeneity_));
        thread_local std::vector<Rgb> by_slot;
        by_slot.clear();
        for (std::size_t slot = 0; config_.shafts.keeps_groups_apart && slot < of_slot_.size(); ++slot)
            by_slot.push_back(sum_of_slot(slot, first, count));
        deliver(pixel, seen, by_slot);
    });
}
} // namespace tyndall::render
