// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_view.hpp"
#include "core/parallel.hpp"
#include "light_shafts/light_map_fit_lamp_rows.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
static ScatteringLight white_light(const Scene& scene, const Media& media, const LightMapFitConfig& config) {
    const std::string& name = scene.lights()[config.light].name;
    StrataCounts counts{.of_light = std::vector<std::uint32_t>(scene.lights().size(), 1u)};
    Statistics why;
    for (ScatteringLight& light : find_scattering_lights(scene, media, config.shafts, counts, why)) {
        if (light.index != config.light)
            continue;
        light.samples.front().strength = Rgb(1.0f);
        light.samples.front().textured = nullptr;
        return std::move(light);
    }
    for (const Statistics::Skipped& skipped : why.skipped)
        if (skipped.what == "light shafts of " + name)
            refuse("Light \"", name, "\" makes no shafts: ", skipped.reason);
    refuse("Light \"", name, "\" makes no shafts");
}

StrokeView::StrokeView(const Scene& scene, const Media& media, const Strokes& strokes, const LightMapFitConfig& config,
                       Statistics& statistics, Progress& progress)
    : rays_(strokes.pixels.size()), prepared_{.media = media, .lights = {}, .statistics = {}} {
    std::vector<std::vector<MediumSegment>> segments(rays_.size());
    parallel_for(rays_.size(), progress, [&](std::size_t pixel) {
        rays_[pixel] = clip_to_media(media, strokes.pixels[pixel].ray, segments[pixel]).clipped;
        if (!(rays_[pixel].near_m < rays_[pixel].far_m))
            segments[pixel].clear();
    });
    std::vector<ViewRay> in_media;
    for (std::size_t pixel = 0; pixel < rays_.size(); ++pixel) {
        if (!segments[pixel].empty())
            in_media.push_back(rays_[pixel]);
        segments_.insert(segments_.end(), segments[pixel].begin(), segments[pixel].end());
        first_segment_.push_back(static_cast<std::uint32_t>(segments_.size()));
    }
    if (in_media.empty())
        return;
    const StageTimer timer(statistics, "light map fit: visibility");
    prepared_.prepare(scene, strokes.view, in_media, {white_light(scene, media, config)}, config.shafts, progress);
}

std::span<const ViewRay> StrokeView::rays(std::size_t block) const {
    const std::size_t begin = block * rays_per_block;
    return std::span(rays_).subspan(begin, std::min(rays_per_block, rays_.size() - begin));
}

std::span<const std::uint32_t> StrokeView::first_segments(std::size_t block) const {
    return std::span(first_segment_).subspan(block * rays_per_block, rays(block).size() + 1);
}

const Beam* StrokeView::beam() const {
    return prepared_.lights.empty() ? nullptr : &prepared_.lights.front().beams.front();
}

std::vector<SeenBlock> see_sun(const StrokeView& view, const LightMapAxes& axes, const Progress& progress) {
    std::vector<SeenBlock> blocks(view.block_count());
    const Beam* const beam = view.beam();
    parallel_for(
        blocks.size(), progress,
        [&](std::size_t index) {
            SeenBlock& block = blocks[index];
            const auto rays = view.rays(index);
            const auto first = view.first_segments(index);
            block.rays.assign(rays.begin(), rays.end());
            std::vector<ViewRay> asked;
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                const auto of_ray = view.segments().subspan(first[ray], first[ray + 1] - first[ray]);
                if (beam != nullptr && !of_ray.empty()) {
                    beam->directional->append_pieces(rays[ray], of_ray, block.pieces.pieces);
                    asked.push_back(rays[ray]);
                }
                block.pieces.end_ray();
            }
            LitRows lit;
            if (!asked.empty())
                beam->visibility->lit_intervals(asked, lit);
            for (std::size_t ray = 0, answer = 0; ray < rays.size(); ++ray) {
                if (beam != nullptr && first[ray] != first[ray + 1]) {
                    const auto own = lit.of_ray(answer++);
                    block.lit.intervals.insert(block.lit.intervals.end(), own.begin(), own.end());
                }
                block.lit.end_ray();
                grow_focus(block.at(ray), axes, block.focus);
                block.is_grey = block.is_grey && is_grey(block.at(ray));
            }
        },
        1);
    return blocks;
}

std::vector<LightMapMatrix::Part> lamp_rows(const StrokeView& view, const Media& media, const Light& lamp,
                                            std::uint32_t resolution, const Progress& progress) {
    std::vector<LightMapMatrix::Part> parts(view.block_count());
    const ThrownMap map(lamp, resolution);
    const Beam* const beam = view.beam();
    parallel_for(
        parts.size(), progress,
        [&](std::size_t block) {
            if (beam == nullptr) {
                parts[block].ray_count = static_cast<std::uint32_t>(view.rays(block).size());
                return;
            }
            std::vector<std::uint32_t> first; // of the block's own segments
            for (const std::uint32_t segment : view.first_segments(block))
                first.push_back(segment - view.first_segments(block).front());
            LocalRays rays;
            rays.assign(media, view.rays(block), first,
                        view.segments().subspan(view.first_segments(block).front(), first.back()));
            LampRowMaker(*beam->local, beam->visibility.get(), map).add_rows(rays, parts[block]);
            parts[block].merge_channels();
        },
        1);
    return parts;
}
} // namespace tyndall::light_shafts
