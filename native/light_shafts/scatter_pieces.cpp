// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/scatter_pieces.hpp"
#include "light_shafts/light_side_depth.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
float mean_transmittance(float optical_depth) {
    if (optical_depth < 1e-3f) // third order: 4e-11 at the seam
        return 1.0f - optical_depth * (0.5f - optical_depth * (1.0f / 6.0f));
    return -std::expm1(-optical_depth) / optical_depth;
}

Rgb scattered(const ScatterPiece& piece, float near_m, float far_m) {
    const float length_m = far_m - near_m;
    Rgb radiance;
    for (int channel = 0; channel < 3; ++channel) {
        const float gain = piece.depth_per_m[channel] * length_m;
        const float at_near = piece.depth_at_near[channel] + piece.depth_per_m[channel] * (near_m - piece.near_m);
        // From the end that loses less: nothing overflows, whichever way the depth grows.
        radiance[channel] = piece.source_per_m[channel] * length_m * std::exp(-(at_near + std::min(gain, 0.0f))) *
                            mean_transmittance(std::abs(gain));
    }
    return radiance;
}

DirectionalScatter::DirectionalScatter(const Media& media, const LightSample& light, bool attenuates_light)
    : media_(media), towards_light_(light.towards_light), irradiance_(light.strength),
      attenuates_light_(attenuates_light) {
    if (attenuates_light && media.fills_world()) {
        MediumSet world;
        world.insert(static_cast<std::uint16_t>(media.world_medium_index()));
        const Rgb sigma_t = media.sigma_t_per_m(world);
        for (int channel = 0; channel < 3; ++channel)
            if (sigma_t[channel] > 0.0f)
                irradiance_[channel] = 0.0f; // infinitely far away: nothing is left
    }
    Rgb sigma_s(0.0f);
    for (const Medium& medium : media.scene().description().media)
        sigma_s += medium.sigma_s_per_m();
    is_black_ = media.is_empty() || irradiance_ * sigma_s == Rgb(0.0f);
}

namespace {
/// Sums over the light-side terms that hold at a place, as the sweep goes from near to far.
struct LightSide {
    dvec3 depth_at_zero{0.0}, depth_per_m{0.0};
    void add(const LightSideTerm& term, const dvec3& sigma_t_per_m, double sign) {
        depth_at_zero += sign * term.way_at_zero_m * sigma_t_per_m;
        depth_per_m += sign * term.way_per_m * sigma_t_per_m;
    }
};
} // namespace

void DirectionalScatter::append_pieces(const ViewRay& ray, std::span<const MediumSegment> segments,
                                       std::vector<ScatterPiece>& pieces) const {
    thread_local std::vector<LightSideTerm> terms;
    thread_local std::vector<std::uint32_t> by_far;
    thread_local std::vector<dvec3> sigma_t_of_term;
    terms.clear(), by_far.clear(), sigma_t_of_term.clear();
    if (segments.empty())
        return;
    if (attenuates_light_) {
        const ViewRay inside{ray.origin, ray.direction, segments.front().near_m, segments.back().far_m};
        for (const MediumBoundary& boundary : media_.boundaries())
            append_light_side_terms(media_, boundary, inside, towards_light_, terms);
        std::ranges::sort(terms, {}, &LightSideTerm::near_m);
        for (std::uint32_t term = 0; term < terms.size(); ++term) {
            MediumSet alone;
            alone.insert(terms[term].medium);
            sigma_t_of_term.emplace_back(media_.sigma_t_per_m(alone));
            by_far.push_back(term);
        }
        std::ranges::sort(by_far, {}, [&](std::uint32_t term) { return terms[term].far_m; });
    }
    const float cosine = glm::dot(ray.direction, towards_light_);
    LightSide light_side;
    std::size_t begun = 0, ended = 0;
    dvec3 camera_depth(0.0);
    for (const MediumSegment& segment : segments) {
        const Rgb source = irradiance_ * media_.scatter_per_m_sr(segment.set, cosine);
        const dvec3 sigma_t(media_.sigma_t_per_m(segment.set));
        double from = segment.near_m;
        while (from < segment.far_m) {
            while (begun < terms.size() && terms[begun].near_m <= from)
                light_side.add(terms[begun], sigma_t_of_term[begun], 1.0), ++begun;
            while (ended < terms.size() && terms[by_far[ended]].far_m <= from)
                light_side.add(terms[by_far[ended]], sigma_t_of_term[by_far[ended]], -1.0), ++ended;
            double to = segment.far_m;
            if (begun < terms.size())
                to = std::min(to, terms[begun].near_m);
            if (ended < terms.size())
                to = std::min(to, terms[by_far[ended]].far_m);
            const dvec3 light_depth = light_side.depth_at_zero + from * light_side.depth_per_m;
            pieces.push_back({.near_m = static_cast<float>(from),
                              .far_m = static_cast<float>(to),
                              .source_per_m = source,
                              .depth_at_near = Rgb(camera_depth + glm::max(light_depth, dvec3(0.0))),
                              .depth_per_m = Rgb(sigma_t + light_side.depth_per_m)});
            camera_depth += sigma_t * (to - from);
            from = to;
        }
    }
}
} // namespace tyndall::light_shafts
