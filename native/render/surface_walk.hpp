// SPDX-License-Identifier: GPL-3.0-or-later
// What camera rays meet before any light is asked for, and what each light then gives: apart, so that a light that moved
// is asked anew while rays, materials and the other lights stay.
#pragma once
#include "render/caught_light.hpp"
#include "render/light_paths.hpp"
#include "render/surface_point.hpp"
#include "shading/lobes/lobe_set.hpp"
#include <algorithm>
#include <span>
#include <vector>

namespace tyndall::render {
/// Surface points of camera rays that wait for light.
struct SurfaceWalk {
    /// What light on a point adds to its ray.
    struct Shade {
        Rgb throughput;           ///< Share of the point's light that reaches the camera.
        Rgb radiance;             ///< Of that, per irradiance, 1/sr.
        Rgb cover{0.0f};          ///< Share of what lies behind the point that it hides from the camera.
        std::uint16_t sample = 0; ///< The ray's, among those that were walked.
        LightOf of = LightOf::Picture;
        bool is_elsewhere = false; ///< Than its pixel shows: neighbours share nothing of it.
        LightWay way = {Scatterer::Diffuse};
    };
    /// Points of neighbouring rays in one layer, which are lit together.
    struct Batch {
        std::uint32_t end = 0; ///< It begins where the one before ends.
        std::uint32_t layer = 0;
        Among among = Among::All; ///< What may stand in the way of their light.
    };
    /// What a point's lobes add to its ray, beside Lambert's share.
    struct LobedPoint {
        std::uint32_t point = 0; ///< Among all; they rise.
        std::uint32_t first_lobe = 0, end_lobe = 0;
        vec3 towards_viewer{0.0f};
        Rgb throughput{1.0f}; ///< Share of the point's light that reaches the camera.
    };
    std::vector<SurfacePoint> points;
    std::vector<Shade> shades;     ///< Per point.
    std::vector<Batch> batches;    ///< Layers of a ray rise.
    std::vector<LobedPoint> lobed; ///< Few or none of the points.
    std::vector<Lobe> lobes;

    void clear() {
        points.clear();
        shades.clear();
        batches.clear();
        lobed.clear();
        lobes.clear();
    }
    /// For one that is kept.
    void shrink_to_fit() {
        points.shrink_to_fit();
        shades.shrink_to_fit();
        batches.shrink_to_fit();
        lobed.shrink_to_fit();
        lobes.shrink_to_fit();
    }
    /// After the points of a layer; none: no batch.
    void end_batch(std::uint32_t layer, Among among) {
        const auto end = static_cast<std::uint32_t>(points.size());
        if (end > (batches.empty() ? 0 : batches.back().end))
            batches.push_back({end, layer, among});
    }
    /// Points that another walk has not put into batches, as one, or as several of no more than `most`.
    void append_batch(const SurfaceWalk& other, std::uint32_t layer, Among among, std::size_t most = ~std::size_t{0}) {
        const auto first_point = static_cast<std::uint32_t>(points.size());
        const auto first_lobe = static_cast<std::uint32_t>(lobes.size());
        points.insert(points.end(), other.points.begin(), other.points.end());
        shades.insert(shades.end(), other.shades.begin(), other.shades.end());
        lobes.insert(lobes.end(), other.lobes.begin(), other.lobes.end());
        for (LobedPoint of : other.lobed) {
            of.point += first_point, of.first_lobe += first_lobe, of.end_lobe += first_lobe;
            lobed.push_back(of);
        }
        for (std::size_t left = other.points.size(), end = first_point; left > most; left -= most)
            batches.push_back({static_cast<std::uint32_t>(end += most), layer, among});
        end_batch(layer, among);
    }
    [[nodiscard]] std::size_t bytes() const {
        return points.capacity() * sizeof(SurfacePoint) + shades.capacity() * sizeof(Shade) +
               batches.capacity() * sizeof(Batch) + lobed.capacity() * sizeof(LobedPoint) +
               lobes.capacity() * sizeof(Lobe);
    }
    /// Of the last point.
    void push_lobes(std::span<const Lobe> of_point, const vec3& towards_viewer, const Rgb& throughput) {
        const auto first = static_cast<std::uint32_t>(lobes.size());
        lobes.insert(lobes.end(), of_point.begin(), of_point.end());
        lobed.push_back({.point = static_cast<std::uint32_t>(points.size() - 1),
                         .first_lobe = first,
                         .end_lobe = static_cast<std::uint32_t>(lobes.size()),
                         .towards_viewer = towards_viewer,
                         .throughput = throughput});
    }
    /// Of the points [first, end).
    [[nodiscard]] std::span<const LobedPoint> lobed_of(std::size_t first, std::size_t end) const {
        if (lobed.empty())
            return {};
        const auto begins = std::ranges::lower_bound(lobed, first, {}, &LobedPoint::point);
        const auto ends = std::ranges::lower_bound(begins, lobed.end(), end, {}, &LobedPoint::point);
        return {begins, ends};
    }
    [[nodiscard]] LobeSet lobes_of(const LobedPoint& of) const {
        return {.lobes = std::span(lobes).subspan(of.first_lobe, of.end_lobe - of.first_lobe),
                .normal = points[of.point].shading.shading_normal,
                .outgoing = of.towards_viewer};
    }
};

/// What each light gives to the points of a walk, with occluders and media between, and with nothing between, W/m^2.
struct SurfaceLight {
    struct OfLight {
        std::vector<Rgb> irradiance;
        std::vector<Rgb> unshadowed; ///< Empty where nobody wants it, and of the world.
        std::vector<Rgb> reflected;  ///< Radiance towards the viewer, of each point with lobes.
    };
    std::vector<OfLight> lights;        ///< In the order of DirectLight, the world last.
    std::vector<OfLight> many_by_group; ///< Of the many lights that are drawn; empty where nobody asks for groups.

    [[nodiscard]] std::size_t bytes() const {
        std::size_t sum = 0;
        for (const auto* of : {&lights, &many_by_group})
            for (const OfLight& light : *of)
                sum += (light.irradiance.capacity() + light.unshadowed.capacity() + light.reflected.capacity()) *
                       sizeof(Rgb);
        return sum;
    }
};
} // namespace tyndall::render
