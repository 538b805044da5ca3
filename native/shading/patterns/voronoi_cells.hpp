// SPDX-License-Identifier: GPL-3.0-or-later
// What one octave of the Voronoi node is made of: see voronoi.hpp for the sources.
#pragma once
#include "shading/patterns/points_around.hpp"
#include "shading/patterns/voronoi.hpp"
#include <algorithm>

namespace tyndall::patterns {
template <int N>
struct Found {
    float distance = 0.0f;
    Rgb colour{0.0f};
    Point<N> place{0.0f};
};

/// In one dimension all metrics are one.
template <int N>
float distance_between(const Point<N>& a, const Point<N>& b, const VoronoiConfig& config) {
    const Point<N> apart = glm::abs(a - b);
    if constexpr (N == 1)
        return apart.x;
    float result = 0.0f;
    switch (config.metric) {
    case VoronoiConfig::Metric::Euclidean:
        return std::sqrt(glm::dot(apart, apart));
    case VoronoiConfig::Metric::Manhattan:
        for (int axis = 0; axis < N; ++axis)
            result += apart[axis];
        return result;
    case VoronoiConfig::Metric::Chebychev:
        for (int axis = 0; axis < N; ++axis)
            result = std::max(result, apart[axis]);
        return result;
    case VoronoiConfig::Metric::Minkowski:
        for (int axis = 0; axis < N; ++axis)
            result += std::pow(apart[axis], config.exponent);
        return std::pow(result, 1.0f / config.exponent);
    }
    return result;
}

/// A place's own cell; all else is relative to it.
template <int N>
class Cells {
public:
    Cells(const Point<N>& place, const VoronoiConfig& config)
        : cell_(glm::floor(place)), within_(place - cell_), config_(config) {}
    [[nodiscard]] const Point<N>& within() const { return within_; }
    [[nodiscard]] Point<N> whole_place(const Point<N>& local) const { return cell_ + local; }
    [[nodiscard]] Rgb colour(const Point<N>& offset) const {
        if constexpr (N > 1)
            if (config_.has_permuted_points)
                return permuted_colour(whole(cell_) + whole(offset));
        return random_colour(cell_ + offset);
    }
    void find_points(int reach, PointsAround<N>& points, const Point<N>& around = Point<N>(0.0f)) const {
        find_points_around<N>(cell_, around, {reach, config_.has_permuted_points, config_.randomness}, points);
    }

private:
    /// Cells beyond what a whole number holds are all one.
    static Cell<N> whole(const Point<N>& cell) { return Cell<N>(glm::clamp(cell, -2147483000.0f, 2147483000.0f)); }
    Point<N> cell_, within_;
    const VoronoiConfig& config_;
};

/// Distances of points from a place, squared where they are Euclidean: loops that become vectors.
template <int N>
void measure(const PointsAround<N>& points, const Point<N>& place, const VoronoiConfig& config, float* distances) {
    if (N > 1 && config.metric != VoronoiConfig::Metric::Euclidean) {
        for (std::size_t index = 0; index < points.count; ++index)
            distances[index] = distance_between(points[index], place, config);
        return;
    }
    for (std::size_t index = 0; index < points.count; ++index) {
        float squared = 0.0f;
        for (int axis = 0; axis < N; ++axis) {
            const float apart = points.at[axis][index] - place[axis];
            squared += apart * apart;
        }
        distances[index] = squared;
    }
    for (std::size_t index = 0; index < points.count; ++index)
        distances[index] = std::sqrt(distances[index]);
}

/// Of all points nearby, those nearer counting more.
template <int N>
Found<N> blended(const Cells<N>& cells, const VoronoiConfig& config) {
    PointsAround<N> points;
    cells.find_points(2, points);
    float distances[most_points_around];
    measure(points, cells.within(), config, distances);
    const float width = config.smoothness;
    Found<N> found;
    found.distance = config.begins_far ? 8.0f : std::numeric_limits<float>::max();
    for (std::size_t index = 0; index < points.count; ++index) {
        const float t = std::clamp(0.5f + 0.5f * (found.distance - distances[index]) / width, 0.0f, 1.0f);
        if (t == 0.0f)
            continue; // too far to change anything
        const float share = t * t * (3.0f - 2.0f * t);
        if (found.distance == std::numeric_limits<float>::max())
            found.distance = distances[index];
        const float rounding = width * share * (1.0f - share), less = rounding / (1.0f + 3.0f * width);
        found.distance += share * (distances[index] - found.distance) - rounding;
        found.place += share * (points[index] - found.place) - less;
        if (config.has_colour)
            found.colour += share * (cells.colour(offset_of<N>(index, 2)) - found.colour) - less;
    }
    found.place = cells.whole_place(found.place);
    return found;
}

/// The nearest point, or the second.
template <int N>
Found<N> nearest(const Point<N>& place, const VoronoiConfig& config) {
    const Cells<N> cells(place, config);
    if (config.feature == VoronoiConfig::Feature::SmoothF1)
        return blended(cells, config);
    PointsAround<N> points;
    cells.find_points(1, points);
    float distances[most_points_around];
    measure(points, cells.within(), config, distances);
    constexpr std::size_t none = most_points_around;
    const float furthest = config.begins_far ? 8.0f : std::numeric_limits<float>::max();
    float first_distance = furthest, second_distance = furthest;
    std::size_t first = none, second = none;
    for (std::size_t index = 0; index < points.count; ++index) {
        if (distances[index] < first_distance) {
            second_distance = first_distance;
            second = first;
            first_distance = distances[index];
            first = index;
        } else if (distances[index] < second_distance) {
            second_distance = distances[index];
            second = index;
        }
    }
    const bool is_second = config.feature == VoronoiConfig::Feature::F2;
    const std::size_t chosen = is_second ? second : first;
    const Point<N> offset = chosen == none ? Point<N>(0.0f) : offset_of<N>(chosen, 1);
    return {is_second ? second_distance : first_distance, config.has_colour ? cells.colour(offset) : Rgb(0.0f),
            cells.whole_place(chosen == none ? Point<N>(0.0f) : points[chosen])};
}

/// To the plane half way to a neighbour of the nearest point.
template <int N>
float distance_to_edge(const Point<N>& place, const VoronoiConfig& config) {
    const Cells<N> cells(place, config);
    PointsAround<N> points;
    cells.find_points(1, points);
    if constexpr (N == 1) {
        const float middle = points.at[0][1], at = cells.within().x;
        const auto to_edge = [&](float neighbour) { return std::abs((middle + neighbour) * 0.5f - at); };
        return std::min(to_edge(points.at[0][0]), to_edge(points.at[0][2]));
    } else {
        std::size_t closest = 0;
        float closest_squared = std::numeric_limits<float>::max(), to_edge = std::numeric_limits<float>::max();
        for (std::size_t index = 0; index < points.count; ++index) {
            const Point<N> to_point = points[index] - cells.within();
            const float squared = glm::dot(to_point, to_point);
            if (squared < closest_squared) {
                closest_squared = squared;
                closest = index;
            }
        }
        const Point<N> to_closest = points[closest] - cells.within();
        for (std::size_t index = 0; index < points.count; ++index) {
            const Point<N> to_point = points[index] - cells.within(), across = to_point - to_closest;
            const float squared = glm::dot(across, across);
            if (squared > 0.0001f) // else it is the nearest one itself, or as good as that
                to_edge = std::min(to_edge, glm::dot((to_closest + to_point) * 0.5f, across) / std::sqrt(squared));
        }
        return to_edge;
    }
}

/// Half the way from the nearest point to the point nearest to that.
template <int N>
float sphere_radius(const Point<N>& place, const VoronoiConfig& config) {
    const Cells<N> cells(place, config);
    PointsAround<N> points;
    cells.find_points(1, points);
    float distances[most_points_around];
    const VoronoiConfig euclidean{};
    measure(points, cells.within(), euclidean, distances);
    const auto closest = static_cast<std::size_t>(std::min_element(distances, distances + points.count) - distances);
    const Point<N> point = points[closest];
    cells.find_points(1, points, offset_of<N>(closest, 1));
    measure(points, point, euclidean, distances);
    distances[points.count / 2] = std::numeric_limits<float>::max(); // the point itself
    return *std::min_element(distances, distances + points.count) * 0.5f;
}
} // namespace tyndall::patterns
