// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_columns.hpp"
#include "scene/media.hpp"
#include <algorithm>
#include <tuple>

namespace tyndall::light_shafts {
/// Voxels between columns from which on a look per voxel tells as much as the integral over each cell.
static constexpr float sampled_from = 2.0f;

void LightColumns::add_face(const vec3& forward, const vec2& low, const vec2& high) {
    Face& face = faces_.emplace_back();
    face.forward = forward;
    std::tie(face.across, face.up) = orthonormal_basis(forward);
    // One column beyond the edges: what lies outside has none of the density.
    face.first = low - spacing_uv_;
    const vec2 size = (high - low) / spacing_uv_;
    face.width = static_cast<std::uint32_t>(std::ceil(size.x)) + 3;
    face.height = static_cast<std::uint32_t>(std::ceil(size.y)) + 3;
    if (faces_.size() > 1) {
        const Face& before = faces_[faces_.size() - 2];
        face.first_column = before.first_column + std::size_t{before.width} * before.height;
    }
}

void LightColumns::find_colour() {
    Rgb of_all(0.0f);
    for (const GridField& field : placed_->used_fields())
        of_all += field.sigma_t_per_m;
    const float sum = of_all.x + of_all.y + of_all.z;
    if (!(sum > 0.0f)) {
        colour_ = Rgb(0.0f);
        return;
    }
    constexpr float rounding = 1e-6f;
    colour_ = of_all;
    for (int channel = 0; const GridField& field : placed_->used_fields()) {
        const Rgb& own = field.sigma_t_per_m;
        const float share = (own.x + own.y + own.z) / sum;
        shares_[channel++] = share;
        if (glm::any(glm::greaterThan(glm::abs(own - share * of_all), Rgb(rounding * sum)))) {
            colour_.reset();
            return;
        }
    }
}

LightColumns::LightColumns(const PlacedGrid& placed, const LightSample& light, float spacing_voxels)
    : placed_(&placed), is_directional_(light.is_directional), origin_(light.position),
      spacing_m_(spacing_voxels * placed.voxel_m), is_sampled_(spacing_voxels >= sampled_from) {
    find_colour();
    const vec3 centre = placed.bounds.centre();
    const float radius_m = 0.5f * placed.bounds.diagonal_m();
    if (is_directional_) {
        const vec3 forward = -light.towards_light;
        origin_ = centre - radius_m * forward;
        spacing_uv_ = spacing_m_;
        const auto [across, up] = orthonormal_basis(forward);
        vec2 low(std::numeric_limits<float>::infinity()), high(-low);
        for (std::size_t corner = 0; corner < 8; ++corner) {
            const vec3 way = placed.bounds.corner(corner) - origin_;
            const vec2 uv(glm::dot(way, across), glm::dot(way, up));
            low = glm::min(low, uv), high = glm::max(high, uv);
        }
        add_face(forward, low, high);
    } else {
        const float distance_m = glm::length(centre - origin_);
        spacing_uv_ = spacing_m_ / (distance_m + 0.5f * radius_m);
        first_m_ = std::max(0.0f, distance_m - radius_m);
        constexpr float far_enough = 1.25f; // the cone around the grid then is less than 107 degrees wide
        if (distance_m > far_enough * radius_m) {
            const float sine = radius_m / distance_m;
            const float tangent = sine / std::sqrt(1.0f - sine * sine);
            add_face((centre - origin_) / distance_m, vec2(-tangent), vec2(tangent));
        } else {
            for (int axis = 0; axis < 3; ++axis)
                for (const float sign : {1.0f, -1.0f}) {
                    vec3 forward(0.0f);
                    forward[axis] = sign;
                    add_face(forward, vec2(-1.0f), vec2(1.0f));
                }
        }
    }
    const Face& last = faces_.back();
    const std::size_t count = last.first_column + std::size_t{last.width} * last.height;
    columns_ = Columns(new std::atomic<const Column*>[count](), { .count = count });
}

void LightColumns::DeleteColumns::operator()(std::atomic<const Column*>* columns) const {
    for (std::size_t index = 0; index < count; ++index)
        delete columns[index].load(std::memory_order_relaxed);
    delete[] columns;
}

/// Its parameter is the way from the origin in metres.
GridLine LightColumns::line_of(const Face& face, std::uint32_t x, std::uint32_t y) const {
    const vec2 uv = face.first + spacing_uv_ * vec2(static_cast<float>(x), static_cast<float>(y));
    const vec3 offset = uv.x * face.across + uv.y * face.up;
    return is_directional_ ? placed_->line(origin_ + offset, face.forward)
                           : placed_->line(origin_, glm::normalize(face.forward + offset));
}

LightColumns::Column LightColumns::walk(const GridLine& line) const {
    Column column;
    glm::dvec4 sum(0.0);
    double place_m = 0.0; // of the next place
    const auto add_place = [&] {
        append(sum, column.values);
        place_m += spacing_m_;
    };
    with_density_type(*placed_->grid, [&]<class Density>(const Density&) {
        constexpr double endless = std::numeric_limits<double>::infinity();
        for_each_cell<Density>(*placed_->grid, line, first_m_, endless, [&](const CellSpan<Density>& span) {
            if (column.values.empty()) {
                column.begin =
                    static_cast<std::uint32_t>(std::max(0.0, std::floor((span.near_m - first_m_) / spacing_m_)));
                place_m = first_m_ + column.begin * double{spacing_m_};
                add_place();
            }
            double at = span.near_m;
            for (; place_m < span.far_m; at = std::max(at, place_m), add_place())
                if (place_m > at)
                    add_integral(sum, span.integral(at, place_m)), at = place_m;
            add_integral(sum, span.integral(at, span.far_m));
            return true;
        });
    });
    if (!column.values.empty())
        add_place(); // all that there is
    column.values.shrink_to_fit();
    return column;
}

/// By the midpoint rule, in steps over which the line stays within a voxel's side along each axis.
LightColumns::Column LightColumns::sampled(const GridLine& line) const {
    Column column;
    const DensityGrid& grid = *placed_->grid;
    const glm::dvec3 sides = glm::abs(line.direction);
    const double per_place = std::max(1.0, std::ceil(double{spacing_m_} * std::max({sides.x, sides.y, sides.z})));
    const double step_m = spacing_m_ / per_place;
    glm::dvec4 sum(0.0);
    double next_place = 0.0; // in steps
    const auto add_place = [&] {
        append(step_m * sum, column.values);
        next_place += per_place;
    };
    with_density_type(grid, [&]<class Density>(const Density&) {
        constexpr double endless = std::numeric_limits<double>::infinity();
        for_each_brick(grid, line, first_m_, endless,
                       [&](const DensityGrid::Brick& brick, double near_m, double far_m, const glm::ivec3& place) {
                           double step = std::ceil((near_m - first_m_) / step_m - 0.5);
                           const double end = std::ceil((far_m - first_m_) / step_m - 0.5);
                           if (step < end && column.values.empty()) {
                               column.begin = static_cast<std::uint32_t>(std::max(0.0, std::floor(step / per_place)));
                               next_place = column.begin * per_place;
                               add_place();
                           }
                           const glm::dvec3 corner = double{DensityGrid::brick_cells} * glm::dvec3(place);
                           for (; step < end; step += 1.0) {
                               while (next_place <= step)
                                   add_place();
                               const vec3 at = glm::clamp(vec3(line.at(first_m_ + (step + 0.5) * step_m) - corner),
                                                          0.0f, static_cast<float>(DensityGrid::brick_cells));
                               const glm::ivec3 cell = glm::min(glm::ivec3(at), DensityGrid::brick_cells - 1);
                               add_integral(sum, trilinear<Density>(cell_corner(brick, cell, density_stride<Density>),
                                                                    at - vec3(cell)));
                           }
                           return true;
                       });
    });
    if (!column.values.empty())
        add_place(); // all that there is
    column.values.shrink_to_fit();
    return column;
}

void LightColumns::append(const glm::dvec4& integral, std::vector<float>& values) const {
    if (colour_) {
        values.push_back(glm::dot(vec4(integral), shares_));
        return;
    }
    const Rgb depth = placed_->sigma_t_per_m(vec4(integral));
    values.insert(values.end(), {depth.x, depth.y, depth.z});
}

const LightColumns::Column& LightColumns::column(const Face& face, std::uint32_t x, std::uint32_t y) const {
    std::atomic<const Column*>& place = columns_[face.first_column + std::size_t{y} * face.width + x];
    const Column* known = place.load(std::memory_order_acquire);
    if (known != nullptr)
        return *known;
    // Whoever makes the same one at the same time makes the same values: the first one to be done counts.
    const GridLine line = line_of(face, x, y);
    auto made = std::make_unique<const Column>(is_sampled_ ? sampled(line) : walk(line));
    if (place.compare_exchange_strong(known, made.get(), std::memory_order_acq_rel, std::memory_order_acquire))
        known = made.release();
    return *known;
}

Rgb LightColumns::depth_at(const Column& column, float place) const {
    if (column.values.empty())
        return Rgb(0.0f);
    const std::size_t count = column.values.size() / (colour_ ? 1 : 3);
    const float inside = std::clamp(place - static_cast<float>(column.begin), 0.0f, static_cast<float>(count - 1));
    const std::size_t index = std::min(static_cast<std::size_t>(inside), count - 2);
    const float share = inside - static_cast<float>(index);
    const auto between = [&](std::size_t at, std::size_t stride) {
        const float value = column.values[at];
        return value + share * (column.values[at + stride] - value);
    };
    if (colour_) // times the colour, in the end
        return Rgb(between(index, 1), 0.0f, 0.0f);
    return {between(3 * index, 3), between(3 * index + 1, 3), between(3 * index + 2, 3)};
}

Rgb LightColumns::depth(const Face& face, const vec2& uv, float way_m) const {
    const vec2 place = (uv - face.first) / spacing_uv_;
    if (!(place.x >= 0.0f && place.y >= 0.0f && place.x <= static_cast<float>(face.width - 1) &&
          place.y <= static_cast<float>(face.height - 1)))
        return Rgb(0.0f);
    const auto x = std::min(static_cast<std::uint32_t>(place.x), face.width - 2);
    const auto y = std::min(static_cast<std::uint32_t>(place.y), face.height - 2);
    const float along = (way_m - first_m_) / spacing_m_;
    const float share = place.x - static_cast<float>(x);
    const auto across = [&](std::uint32_t row) {
        return glm::mix(depth_at(column(face, x, row), along), depth_at(column(face, x + 1, row), along), share);
    };
    const Rgb found = glm::mix(across(y), across(y + 1), place.y - static_cast<float>(y));
    return colour_ ? found.x * *colour_ : found;
}

Rgb LightColumns::depth(const vec3& point) const {
    const vec3 way = point - origin_;
    if (is_directional_) {
        const Face& face = faces_.front();
        return depth(face, vec2(glm::dot(way, face.across), glm::dot(way, face.up)), glm::dot(way, face.forward));
    }
    const Face* nearest = faces_.data();
    for (const Face& face : faces_)
        if (glm::dot(way, face.forward) > glm::dot(way, nearest->forward))
            nearest = &face;
    const float ahead_m = glm::dot(way, nearest->forward);
    if (!(ahead_m > 0.0f))
        return Rgb(0.0f);
    return depth(*nearest, vec2(glm::dot(way, nearest->across), glm::dot(way, nearest->up)) / ahead_m,
                 glm::length(way));
}

ColumnBytes LightColumns::bytes() const {
    const std::size_t count = columns_.get_deleter().count;
    std::size_t made = 0, bytes = 0;
    for (std::size_t index = 0; index < count; ++index)
        if (const Column* column = columns_[index].load(std::memory_order_acquire); column != nullptr)
            ++made, bytes += sizeof(Column) + column->values.size() * sizeof(float);
    const double each = made > 0 ? static_cast<double>(bytes) / static_cast<double>(made) : 0.0;
    return {.of_places = static_cast<double>(sizeof(Column*) * count), .of_values = each * static_cast<double>(count)};
}

GridLightDepth::GridLightDepth(const Media& media, const LightSample& light) : grids_(media.grids()), light_(light) {}

void GridLightDepth::tabulate(float spacing_voxels) {
    columns_.clear();
    for (const PlacedGrid& placed : grids_.all())
        columns_.emplace_back(placed, light_, spacing_voxels);
}

Rgb GridLightDepth::depth(const vec3& point) const {
    if (columns_.empty())
        return exact_depth(point);
    Rgb depth(0.0f);
    for (const LightColumns& columns : columns_)
        depth += columns.depth(point);
    return depth;
}

Rgb GridLightDepth::exact_depth(const vec3& point) const {
    if (light_.is_directional)
        return grids_.optical_depth({.origin = point, .direction = light_.towards_light});
    const vec3 way = light_.position - point;
    const float distance_m = glm::length(way);
    return distance_m > 0.0f
               ? grids_.optical_depth({.origin = point, .direction = way / distance_m, .far_m = distance_m})
               : Rgb(0.0f);
}

ColumnBytes GridLightDepth::bytes() const {
    ColumnBytes sum;
    for (const LightColumns& columns : columns_) {
        const ColumnBytes bytes = columns.bytes();
        sum.of_places += bytes.of_places;
        sum.of_values += bytes.of_values;
    }
    return sum;
}

namespace {
/// A convex polygon; where a half-plane cuts it, at most one corner more.
using Polygon = std::vector<dvec2>;

/// Keeps where offset + normal . p >= 0.
void clip(Polygon& polygon, double offset, const dvec2& normal) {
    thread_local Polygon kept;
    kept.clear();
    for (std::size_t index = 0; index < polygon.size(); ++index) {
        const dvec2& a = polygon[index];
        const dvec2& b = polygon[(index + 1) % polygon.size()];
        const double at_a = offset + glm::dot(normal, a), at_b = offset + glm::dot(normal, b);
        if (at_a >= 0.0)
            kept.push_back(a);
        if ((at_a >= 0.0) != (at_b >= 0.0))
            kept.push_back(a + at_a / (at_a - at_b) * (b - a));
    }
    std::swap(polygon, kept);
}
} // namespace

void GridLightDepth::append_reached(const vec3& origin, const vec3& direction, float near_m, float far_m,
                                    std::vector<LinePart>& parts) const {
    thread_local Polygon polygon;
    for (const PlacedGrid& placed : grids_.all()) {
        const GridLine line = placed.line(origin, direction);
        const GridLine towards = light_.is_directional ? placed.line(origin, light_.towards_light)
                                                       : placed.line(light_.position, vec3(0.0f));
        const Bounds3& box = placed.grid->bounds();
        // Points of the plane of ray and light, in grid space: base + x along + y aside. Towards a sun: x is the distance
        // on the ray, y that to the sun. Towards a lamp: lamp + y (ray's origin - lamp) + x direction, with y in [0, 1]:
        // the share of the way from the lamp, on which x is y times the distance.
        const dvec3 base = light_.is_directional ? line.origin : towards.origin;
        const dvec3 aside = light_.is_directional ? towards.direction : line.origin - towards.origin;
        if (light_.is_directional) {
            const vec3 to_box = placed.bounds.centre() - (origin + 0.5f * (near_m + far_m) * direction);
            const double reach_m = double{glm::length(to_box)} + far_m - near_m + placed.bounds.diagonal_m();
            polygon = {{near_m, 0.0}, {far_m, 0.0}, {far_m, reach_m}, {near_m, reach_m}};
        } else {
            polygon = {{0.0, 0.0}, {near_m, 1.0}, {far_m, 1.0}};
        }
        for (int axis = 0; axis < 3 && !polygon.empty(); ++axis) {
            const dvec2 normal(line.direction[axis], aside[axis]);
            clip(polygon, base[axis] - double{box.min[axis]}, normal);
            clip(polygon, double{box.max[axis]} - base[axis], -normal);
        }
        if (polygon.empty())
            continue;
        LinePart part{far_m, near_m};
        for (const dvec2& corner : polygon) {
            if (!light_.is_directional && !(corner.y > 1e-9)) { // at the lamp: any ray point is behind it
                part = {near_m, far_m};
                break;
            }
            const double at = light_.is_directional ? corner.x : corner.x / corner.y;
            part.near_m = std::min(part.near_m, at);
            part.far_m = std::max(part.far_m, at);
        }
        part.near_m = std::max<double>(part.near_m, near_m);
        part.far_m = std::min<double>(part.far_m, far_m);
        if (part.near_m < part.far_m)
            parts.push_back(part);
    }
}

bool GridLightDepth::reaches(const vec3& origin, const vec3& direction, float near_m, float far_m) const {
    thread_local std::vector<LinePart> parts;
    parts.clear();
    append_reached(origin, direction, near_m, far_m, parts);
    return !parts.empty();
}
} // namespace tyndall::light_shafts
