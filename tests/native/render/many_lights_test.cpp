// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/sampling.hpp"
#include "render/direct_light.hpp"
#include "scene/media.hpp"
#include "scene/strands.hpp"
#include "support/box_shape.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include "support/one_point.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace many_lights_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
struct Mean {
    glm::dvec3 value{0.0}, sigma{0.0};
};
/// Of independent pixels' light at a place on the floor, of all lights together; with lobes, what these reflect of it.
Mean mean_light(const Scene& scene, const vec3& place, std::uint32_t pixels, std::uint32_t samples,
                const LobeSet* lobes = nullptr) {
    const Media media(scene, Progress());
    Statistics statistics;
    const render::DirectLight light(scene, media, statistics);
    const Ray ray{.origin = place + vec3(0, 0, 0.01f), .direction = vec3(0, 0, -1)};
    const Hit hit = scene.closest_hit(ray);
    REQUIRE(hit.is_hit());
    const std::vector<std::uint8_t> all(light.light_count(), 1);
    std::vector<render::DirectLight::Irradiance> found(light.light_count());
    render::DirectLight::PointLobes of_point{};
    if (lobes != nullptr)
        of_point[0] = *lobes;
    Mean mean;
    glm::dvec3 squares(0.0);
    for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
        const render::SurfacePoint point = render::surface_point(scene, ray, hit, hash(7u, pixel));
        glm::dvec3 sum(0.0);
        for (std::uint32_t sample = 0; sample < samples; ++sample) {
            light.at({&point, 1}, {sample, 0}, all, found, lobes != nullptr ? &of_point : nullptr);
            for (const render::DirectLight::Irradiance& of_light : found)
                sum += glm::dvec3(lobes != nullptr ? of_light.reflected : of_light.from_lights) / double(samples);
        }
        mean.value += sum / double(pixels);
        squares += sum * sum / double(pixels);
    }
    mean.sigma = glm::sqrt(glm::max(squares - mean.value * mean.value, glm::dvec3(0.0)) / double(pixels - 1));
    return mean;
}
Light lamp_at(const vec3& place, const Rgb& strength) {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = place;
    lamp.strength = strength;
    return lamp;
}
/// Lamps, beams and plates of all sorts over the floor.
std::vector<Light> mixed_lamps(std::uint32_t count) {
    std::vector<Light> lamps;
    for (std::uint32_t index = 0; index < count; ++index) {
        const vec2 u = sobol_point(index, 3u), v = sobol_point(index, 4u);
        Light lamp = lamp_at({8.0f * u.x - 4.0f, 8.0f * u.y - 4.0f, 0.5f + 2.0f * v.x}, Rgb(1.0f, v.y, 0.5f));
        lamp.spot_axis = glm::normalize(vec3(v.x - 0.5f, v.y - 0.5f, -0.8f));
        if (index % 4 == 1)
            lamp.radius_m = 0.1f;
        if (index % 4 == 2) {
            lamp.kind = LightKind::Spot;
            lamp.spot_blend = 0.3f;
            const auto [x, y] = orthonormal_basis(-lamp.spot_axis);
            lamp.light_from_world_directions = glm::transpose(mat3(x, y, -lamp.spot_axis));
        }
        if (index % 4 == 3) {
            lamp.kind = LightKind::Area;
            lamp.half_size_m = vec2(0.2f, 0.3f);
            lamp.spot_half_angle_rad = index % 8 == 3 ? 1.0f : 0.5f * std::numbers::pi_v<float>;
        }
        lamps.push_back(lamp);
    }
    return lamps;
}
void check_within_noise(const Mean& mean, const glm::dvec3& truth, double most_sigma) {
    for (int channel = 0; channel < 3; ++channel) {
        CHECK(mean.sigma[channel] < most_sigma * truth[channel]);
        CHECK(std::abs(mean.value[channel] - truth[channel]) < 4.0 * mean.sigma[channel] + 1e-5 * truth[channel]);
    }
}
Lobe facets(float alpha) { return {.kind = Lobe::Kind::Ggx, .alpha = alpha, .sampling = 1.0f, .weight = Rgb(1.0f)}; }
/// Plates side by side that shine into a cube around the origin, as bright all over.
std::vector<Light> lit_walls(int plates_along, float half_side_m) {
    std::vector<Light> lamps;
    const float half_m = half_side_m / static_cast<float>(plates_along);
    for (int wall = 0; wall < 6; ++wall)
        for (int plate = 0; plate < plates_along * plates_along; ++plate) {
            vec3 axis(0.0f), x(0.0f), y(0.0f);
            axis[wall / 2] = wall % 2 == 0 ? 1.0f : -1.0f;
            x[(wall / 2 + 1) % 3] = 1.0f;
            y = glm::cross(-axis, x);
            const auto along = [&](int number) { return half_m * static_cast<float>(2 * number + 1 - plates_along); };
            Light lamp =
                lamp_at(-half_side_m * axis + along(plate % plates_along) * x + along(plate / plates_along) * y,
                        Rgb(3.0f, 2.0f, 1.0f) * (4.0f * half_m * half_m));
            lamp.kind = LightKind::Area;
            lamp.spot_axis = axis;
            lamp.spot_half_angle_rad = 0.5f * std::numbers::pi_v<float>;
            lamp.half_size_m = vec2(half_m);
            lamp.light_from_world_directions = glm::transpose(mat3(x, y, -axis));
            lamps.push_back(lamp);
        }
    return lamps;
}
/// What a lobe sends back of light that is 1 from all around.
double albedo_by_quadrature(const LobeSet& lobes) {
    double sum = 0.0; // by the lobe's own directions, whose density test of shading holds against its integral
    constexpr std::uint32_t count = 1 << 16;
    for (std::uint32_t index = 0; index < count; ++index) {
        const vec3 direction = lobes.sample(sobol_point(index, 9u));
        const float pdf = lobes.pdf_per_sr(direction);
        if (direction.z > 0.0f && pdf > 0.0f)
            sum += double{lobes.per_irradiance(direction).x * direction.z / pdf} / count;
    }
    return sum;
}
/// Lambert: irradiance of a polygon of radiance 1 at the origin, facing +Z, all of it above the horizon.
double polygon_irradiance(const std::vector<dvec3>& corners) {
    double sum = 0.0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = glm::normalize(corners[i]), b = glm::normalize(corners[(i + 1) % corners.size()]);
        sum += std::acos(glm::clamp(glm::dot(a, b), -1.0, 1.0)) * glm::normalize(glm::cross(a, b)).z;
    }
    return 0.5 * std::abs(sum);
}
} // namespace

TEST_CASE("many lamps of all sorts, of which a few are drawn, light a point as the sum of all does") {
    const std::vector<Light> lamps = mixed_lamps(200);
    const Part floor = floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f)));
    for (const vec3& place : {vec3(0.3f, 0.2f, 0.0f), vec3(-3.9f, 3.5f, 0.0f)}) {
        glm::dvec3 truth(0.0); // a few at a time are asked each
        for (std::size_t first = 0; first < lamps.size(); first += 20)
            truth += mean_light(*in_world({floor}, Rgb(0.0f),
                                          {lamps.begin() + static_cast<std::ptrdiff_t>(first),
                                           lamps.begin() + static_cast<std::ptrdiff_t>(first + 20)}),
                                place, 16, 256)
                         .value;
        check_within_noise(mean_light(*in_world({floor}, Rgb(0.0f), lamps), place, 64, 256), truth, 5e-3);
    }
}

// Seen to fail with the choice left out of the density of lamps that lobes meet.
TEST_CASE("sharp gloss shows many lamps, of which a few are drawn, as it shows all of them asked one by one") {
    std::vector<Light> lamps = mixed_lamps(200);
    for (std::size_t index = 0; index < lamps.size(); ++index) {
        lamps[index].is_ellipse = index % 8 == 7;
        if (lamps[index].kind == LightKind::Area)
            lamps[index].half_size_m *= 2.0f;
        else if (index % 8 < 2 || index % 8 == 6)
            lamps[index].radius_m = 0.3f;
        if (index % 8 == 5)
            lamps[index].body = LightBody::FacingDisc;
    }
    const Part floor = floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f)));
    const vec3 place(0.3f, 0.2f, 0.0f);
    for (const auto& [alpha, mirrored] : {std::pair{0.002f, 7u}, {0.03f, 31u}, {0.6f, 7u}}) {
        CAPTURE(alpha);
        const std::array lobe{facets(alpha)};
        const vec3 incoming = glm::normalize(lamps[mirrored].position - place);
        const LobeSet lobes{.lobes = lobe, .normal = {0, 0, 1}, .outgoing = glm::reflect(-incoming, vec3(0, 0, 1))};
        glm::dvec3 truth(0.0), variance(0.0);
        for (std::size_t first = 0; first < lamps.size(); first += 25) {
            const std::vector<Light> few(lamps.begin() + static_cast<std::ptrdiff_t>(first),
                                         lamps.begin() + static_cast<std::ptrdiff_t>(first + 25));
            const Mean part = mean_light(*in_world({floor}, Rgb(0.0f), few), place, 16, 128, &lobes);
            truth += part.value;
            variance += part.sigma * part.sigma;
        }
        const Mean drawn = mean_light(*in_world({floor}, Rgb(0.0f), lamps), place, 64, 256, &lobes);
        for (int channel = 0; channel < 3; ++channel) {
            const double sigma = std::sqrt(drawn.sigma[channel] * drawn.sigma[channel] + variance[channel]);
            CHECK(sigma < 0.05 * truth[channel]);
            CHECK(std::abs(drawn.value[channel] - truth[channel]) < 4.0 * sigma);
        }
    }
}

TEST_CASE("gloss in a room whose walls are lamps sends back what it sends back of light from all around") {
    const auto scene = in_world({floor_at(vec3(0.0f), 0.9f, diffuse(Rgb(0.5f)))}, Rgb(0.0f), lit_walls(4, 1.0f));
    std::vector<Lobe> glosses{facets(0.001f), facets(0.01f), facets(0.1f), facets(0.5f)};
    for (const Lobe::Kind kind : {Lobe::Kind::GgxAlongTangent, Lobe::Kind::Beckmann, Lobe::Kind::AshikhminShirley}) {
        glosses.push_back(facets(0.03f));
        glosses.back().kind = kind;
        glosses.back().tangent = vec3(0.0f, 3.0f, 0.0f); // nine times as wide along y as along x
    }
    for (const Lobe& gloss : glosses) {
        CAPTURE(gloss.alpha);
        CAPTURE(static_cast<int>(gloss.kind));
        const std::array lobe{gloss};
        const LobeSet lobes{.lobes = lobe, .normal = {0, 0, 1}, .outgoing = glm::normalize(vec3(0.4f, 0.3f, 0.8f))};
        check_within_noise(mean_light(*scene, vec3(0.1f, 0.2f, 0.0f), 64, 256, &lobes),
                           albedo_by_quadrature(lobes) * glm::dvec3(3, 2, 1), 0.01);
    }
}

TEST_CASE("lamps are aimed at as often as the density says that rays which meet them by chance are told") {
    std::vector<Light> lamps;
    for (std::uint32_t index = 0; index < 60; ++index) {
        Light lamp = mixed_lamps(240)[4 * index + (index % 2 == 0 ? 1 : 3)];
        lamp.position.z += 1.0f;
        lamp.spot_axis = glm::normalize(-lamp.position);
        lamp.spot_half_angle_rad = 0.5f * std::numbers::pi_v<float>;
        const auto [x, y] = orthonormal_basis(-lamp.spot_axis);
        lamp.light_from_world_directions = glm::transpose(mat3(x, y, -lamp.spot_axis));
        lamps.push_back(lamp);
    }
    const auto scene = in_world({floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f)))}, Rgb(0.0f), lamps);
    std::vector<std::uint32_t> numbers(lamps.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    const render::ManyLights many(*scene, numbers, std::make_shared<const render::MeshEmitters>(*scene));
    const Ray down{.origin = {0.3f, 0.2f, 1.0f}, .direction = vec3(0, 0, -1)};
    const render::SurfacePoint point = render::surface_point(*scene, down, scene->closest_hit(down), 1);
    const vec3& position = point.shading.position;
    constexpr std::uint32_t draws = 200'000;
    std::vector<double> seen(lamps.size()), aimed_sr(lamps.size()), promised(lamps.size()), met_sr(lamps.size());
    std::vector<render::ManyLights::LampMet> met;
    for (std::uint32_t draw = 0; draw < draws; ++draw) {
        const auto number = [&](std::uint32_t which) { return unit_float(hash(draw, which)); };
        const auto aimed = many.aim(point, number(1), {number(2), number(3)}, true);
        REQUIRE(aimed);
        const auto lamp = static_cast<std::size_t>(aimed->lamp - scene->lights().data());
        const vec3 target = aimed->ray.origin + aimed->ray.far_m * aimed->ray.direction;
        many.meet_lamps({.origin = position, .direction = glm::normalize(target - position)}, met);
        for (const render::ManyLights::LampMet& one : met)
            if (one.number == lamp)
                CHECK(many.pdf_per_sr(point, one) == close_to(aimed->pdf_per_sr, 1e-3));
        seen[lamp] += 1.0;
        aimed_sr[lamp] += 1.0 / aimed->pdf_per_sr;
    }
    constexpr std::uint32_t rays = 400'000;
    for (std::uint32_t ray = 0; ray < rays; ++ray) {
        many.meet_lamps({.origin = position, .direction = sample_uniform_sphere(sobol_point(ray, 5u))}, met);
        for (const render::ManyLights::LampMet& one : met) {
            met_sr[one.number] += 4.0 * std::numbers::pi / rays;
            promised[one.number] = double{many.pdf_per_sr(point, one)} / one.hit.pdf_per_sr * draws; // for its choice
        }
    }
    CHECK(support::is_plausible(support::chi_square_p_value(seen, promised), 1));
    for (std::size_t lamp = 0; lamp < lamps.size(); ++lamp)
        CHECK(std::abs(aimed_sr[lamp] / draws / met_sr[lamp] - 1.0) <
              5.0 / std::sqrt(seen[lamp]) + 5.0 / std::sqrt(met_sr[lamp] * rays / (4.0 * std::numbers::pi)));
}

// Seen to fail with boxes that are narrower by a tenth.
TEST_CASE("rays that are said to miss all that glows meet none of it") {
    std::vector<Part> parts{floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f)))};
    for (std::uint32_t index = 0; index < 40; ++index) { // more than there are boxes
        const vec2 u = sobol_point(index, 1u), v = sobol_point(index, 2u);
        parts.push_back(floor_at({8.0f * u.x - 4.0f, 8.0f * u.y - 4.0f, 0.5f + v.x}, 0.1f + 0.3f * v.y,
                                 diffuse(Rgb(0.0f), Rgb(1.0f))));
        if (index != 5 && index != 39)
            continue;
        const auto scene = in_world(parts, Rgb(0.0f));
        const render::ManyLights many(*scene, {}, std::make_shared<const render::MeshEmitters>(*scene));
        int met = 0, missed = 0;
        for (std::uint32_t number = 0; number < 4096; ++number) {
            const vec2 place = sobol_point(number, 3u);
            const Ray ray{.origin = {8.0f * place.x - 4.0f, 8.0f * place.y - 4.0f, 0.01f},
                          .direction =
                              number % 16 == 0 ? vec3(0, 0, 1) : sample_cosine_hemisphere(sobol_point(number, 4u))};
            const Hit hit = scene->closest_hit(ray);
            const bool meets = hit.is_hit() && many.has(hit);
            met += meets ? 1 : 0;
            missed += many.may_meet_glow(ray) ? 0 : 1;
            CHECK((!meets || many.may_meet_glow(ray)));
        }
        CHECK(met > 20);
        CHECK((missed > 100 || index == 39));
    }
}

TEST_CASE("a grid of lamps above a plane lights it as the closed form says") {
    std::vector<Light> lamps;
    double truth = 0.0;
    for (int y = -50; y < 50; ++y)
        for (int x = -50; x < 50; ++x) {
            const dvec3 place(0.2 * x + 0.1, 0.2 * y + 0.1, 1.0);
            lamps.push_back(lamp_at(vec3(place), Rgb(1.0f)));
            truth += place.z / std::pow(glm::dot(place, place), 1.5);
        }
    const auto scene = in_world({floor_at(vec3(0.0f), 20.0f, diffuse(Rgb(0.5f)))}, Rgb(0.0f), lamps);
    check_within_noise(mean_light(*scene, vec3(0.0f), 64, 256), glm::dvec3(truth), 5e-3);
}

TEST_CASE("a plate that glows lights a point as Lambert's formula says, near and far, from either side") {
    for (const float height : {0.05f, 1.0f, 20.0f})
        for (const float flip : {1.0f, -1.0f}) {
            Part plate = floor_at(vec3(0.2f, 0.1f, height), 0.7f, diffuse(Rgb(0.0f), Rgb(3.0f, 2.0f, 1.0f)));
            plate.world_from_object = plate.world_from_object * glm::scale(mat4(1.0f), vec3(1, 1, flip));
            const auto scene = in_world({floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f))), plate}, Rgb(0.0f));
            const double unit = polygon_irradiance(
                {{-0.5, -0.6, height}, {0.9, -0.6, height}, {0.9, 0.8, height}, {-0.5, 0.8, height}});
            check_within_noise(mean_light(*scene, vec3(0.0f), 64, 256), unit * glm::dvec3(3, 2, 1), 5e-3);
        }
}

// Seen to fail where a half of a face was taken for the other.
TEST_CASE("cells that glow are aimed at with the density that rays which meet them are told") {
    std::vector<glm::ivec3> cells;
    for (int cell = 0; cell < 12; ++cell)
        cells.emplace_back(cell % 3, cell / 3 % 2, cell / 6);
    SceneDescription description =
        BoxScene{.places = various_places()}.description(std::make_shared<const BoxShape>(cells, 0.3f), false);
    description.materials[0] = diffuse(Rgb(0.2f), Rgb(3.0f, 2.0f, 1.0f));
    for (PlacedShape& placed : description.placed_shapes)
        placed.world_from_object[3] += vec4(0.0f, 0.0f, 1.5f, 0.0f);
    description.meshes = {square()};
    description.object_names.emplace_back("floor");
    description.materials.push_back(diffuse(Rgb(0.5f)));
    description.slot_materials = {1};
    description.instances = {{.world_from_object = glm::scale(mat4(1.0f), vec3(5, 5, 1)), .name_index = 1}};
    const Scene scene(std::move(description), Progress());
    const render::ManyLights many(scene, {}, std::make_shared<const render::MeshEmitters>(scene));
    const Ray down{.origin = {0.7f, 0.4f, 0.1f}, .direction = vec3(0, 0, -1)};
    const render::SurfacePoint point = render::surface_point(scene, down, scene.closest_hit(down), 1);
    int met_count = 0, blocked = 0;
    for (std::uint32_t draw = 0; draw < 20'000; ++draw) {
        const auto number = [&](std::uint32_t which) { return unit_float(hash(draw, which)); };
        const auto aimed = many.aim(point, number(1), {number(2), number(3)});
        if (!aimed || scene.shadow_transmittance(aimed->ray) == Rgb(0.0f)) {
            ++blocked;
            continue;
        }
        const Ray there{.origin = point.shading.position, .direction = aimed->ray.direction, .near_m = 1e-3f};
        const Hit hit = scene.closest_hit(there);
        const auto met = many.met(point, there, hit);
        REQUIRE(met);
        const vec2 on = hit.barycentrics; // rounding decides between neighbours
        if (std::min({on.x, on.y, 1.0f - on.x, 1.0f - on.y, std::abs(on.x + on.y - 1.0f)}) < 1e-3f)
            continue;
        ++met_count;
        CHECK(std::abs(met->pdf_per_sr / aimed->pdf_per_sr - 1.0f) < 1e-3f);
        CHECK(met->instance == aimed->instance);
    }
    CHECK(met_count > 5000);
    CHECK(blocked < 10'000);
}

// Seen to fail where rays that met it counted for half.
TEST_CASE("hair and spheres that glow light a point as rods and spheres do") {
    const vec3 middle(0.3f, -0.2f, 1.0f);
    const float radius_m = 0.05f, half_m = 0.4f;
    for (const StrandForm form : {StrandForm::Ribbon, StrandForm::Round, StrandForm::Spheres}) {
        StrandArrays arrays{.name = "glow", .form = form};
        if (form == StrandForm::Spheres)
            arrays.points = {vec4(middle, radius_m)};
        else
            for (const float along : {-half_m, -half_m / 3, half_m / 3, half_m})
                arrays.points.emplace_back(middle + vec3(0, along, 0), radius_m);
        if (form != StrandForm::Spheres)
            arrays.first_points = {0};
        SceneDescription description =
            description_of(*in_world({floor_at(vec3(0.0f), 5.0f, diffuse(Rgb(0.5f)))}, Rgb(0.0f)));
        description.shapes = {std::make_shared<const Strands>(std::move(arrays), Progress())};
        description.object_names.emplace_back("glow");
        description.materials.push_back(diffuse(Rgb(0.0f), Rgb(3.0f, 2.0f, 1.0f)));
        description.placed_shapes = {{.name_index = static_cast<std::uint32_t>(description.object_names.size() - 1),
                                      .material_index = static_cast<std::uint32_t>(description.materials.size() - 1)}};
        const Scene scene(std::move(description), Progress());
        // Of radiance 1: what a surface element sends to the floor, from the side of it that is seen.
        double unit = 0.0;
        const auto add = [&](const dvec3& place, const dvec3& normal, double area_m2) {
            const double square = glm::dot(place, place), facing = -glm::dot(normal, place);
            unit += std::max(0.0, facing) * place.z / (square * square) * area_m2;
        };
        constexpr int steps = 400;
        for (int ring = 0; ring < steps; ++ring)
            for (int side = 0; side < steps; ++side) {
                const double part = (ring + 0.5) / steps, turn = 2.0 * std::numbers::pi * (side + 0.5) / steps;
                const double area_m2 = 2.0 * std::numbers::pi * radius_m * 2.0 * half_m / (steps * steps);
                const dvec3 along(0.0, half_m * (2.0 * part - 1.0), 0.0), out(std::cos(turn), 0.0, std::sin(turn));
                if (form == StrandForm::Round) {
                    add(dvec3(middle) + along + double{radius_m} * out, out, area_m2);
                } else if (form == StrandForm::Ribbon && side == 0) { // as wide, wherever it is seen from
                    const dvec3 place = dvec3(middle) + along;
                    add(place, -glm::normalize(dvec3(place.x, 0.0, place.z)), area_m2 * steps / std::numbers::pi);
                } else if (form == StrandForm::Spheres) {
                    const double height = 2.0 * part - 1.0, across = std::sqrt(1.0 - height * height);
                    const dvec3 normal(across * out.x, height, across * out.z);
                    add(dvec3(middle) + double{radius_m} * normal, normal,
                        4.0 * std::numbers::pi * radius_m * radius_m / (steps * steps));
                }
            }
        CAPTURE(static_cast<int>(form));
        const Mean mean = mean_light(scene, vec3(0.0f), 64, 4096);
        CHECK(std::abs(mean.value.x / (3.0 * unit) - 1.0) < 0.01);
        CHECK(std::abs(mean.value.z / mean.value.x - 1.0 / 3.0) < 1e-3);
    }
}
} // namespace many_lights_test
