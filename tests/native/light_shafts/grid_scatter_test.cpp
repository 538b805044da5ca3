// SPDX-License-Identifier: GPL-3.0-or-later
// Light shafts in density grids, against closed forms and against brute force that asks each point alone.
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "light_shafts/light_columns.hpp"
#include "light_shafts/light_shafts.hpp"
#include "support/density_grids.hpp"
#include "support/marched_shafts.hpp"
#include "support/scenes.hpp"
#include "support/soup.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace grid_scatter_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr int cloud_voxels = 40;
const Medium smoke{.name = "smoke", .lobes = {{Rgb(1.5f, 1.0f, 0.5f), 0.3f}}, .sigma_a_per_m = Rgb(0.2f, 0.4f, 0.6f)};
const Medium haze{.name = "haze", .lobes = {{Rgb(0.04f, 0.05f, 0.06f), 0.0f}}, .sigma_a_per_m = Rgb(0.0f)};

struct Clouds {
    std::vector<Light> lights;
    bool has_haze = false, has_soup = false;
    std::shared_ptr<const DensityGrid> grid = support::unit_grid(
        cloud_voxels, [](int x, int y, int z) { return 2.0f * support::blob(cloud_voxels, x, y, z); });
    Medium medium = smoke;
    vec3 scale = vec3(1.3f, 1, 1);
};
std::unique_ptr<Scene> make(const Clouds& clouds) {
    SceneDescription description;
    const auto add = [&](std::shared_ptr<const TriangleMesh> mesh, const mat4& place, Material material) {
        const auto index = static_cast<std::uint32_t>(description.meshes.size());
        description.meshes.push_back(std::move(mesh));
        description.materials.push_back(std::move(material));
        description.slot_materials.push_back(index);
        description.object_names.push_back("part");
        description.instances.push_back(
            {.mesh_index = index, .world_from_object = place, .name_index = index, .first_slot_material = index});
    };
    if (clouds.has_soup)
        add(support::soup_mesh(60, {.min = vec3(-2.5f), .max = vec3(2.5f)}, 0.8f, 11), mat4(1.0f), {.name = "soup"});
    if (clouds.has_haze)
        add(support::cube(), glm::scale(mat4(1.0f), vec3(4, 3, 2.5f)),
            {.name = "haze", .medium_index = 1, .has_surface = false});
    description.media = {clouds.medium, haze};
    description.volumes = {{.name = "cloud",
                            .grid = clouds.grid,
                            .world_from_local = glm::scale(support::translation({0.1f, 0.2f, 0.0f}), clouds.scale),
                            .density_scale = 1.5f}};
    description.lights = clouds.lights;
    return std::make_unique<Scene>(std::move(description), Progress());
}
Light sun(const vec3& towards_light) {
    return {.name = "Sun", .strength = Rgb(3.0f, 2.0f, 1.0f), .towards_light = glm::normalize(towards_light)};
}
Light lamp(const vec3& position) {
    return {.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(3.0f, 2.0f, 1.0f), .position = position};
}
Light spot(const vec3& position, const vec3& axis) {
    Light light = lamp(position);
    light.kind = LightKind::Spot;
    light.spot_axis = glm::normalize(axis);
    light.spot_half_angle_rad = 0.35f;
    light.spot_blend = 0.4f;
    light.spot_falloff = SpotFalloff::Blender3;
    return light;
}
std::vector<ViewRay> view(const vec3& eye, int side = 5, float far_m = 12.0f) {
    std::vector<ViewRay> rays;
    const vec3 forward = eye == vec3(0.0f) ? vec3(0, 1, 0) : glm::normalize(-eye);
    const auto [right, up] = orthonormal_basis(forward);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const vec2 place = (vec2(x, y) + 0.5f) / static_cast<float>(side) - 0.5f;
            rays.push_back({eye, glm::normalize(forward + 0.5f * (place.x * right + place.y * up)), 0.0f, far_m});
        }
    return rays;
}
Result shafts(const Scene& scene, std::span<const ViewRay> rays, Config config = {.method = Method::Exact}) {
    Progress progress;
    return run(scene, {.position = rays[0].origin}, rays, config, progress);
}
/// Of all rays, relative.
double rms_error(std::span<const Rgb> found, std::span<const Rgb> expected) {
    double difference2 = 0.0, expected2 = 0.0;
    for (std::size_t ray = 0; ray < found.size(); ++ray) {
        difference2 += glm::dot(dvec3(found[ray] - expected[ray]), dvec3(found[ray] - expected[ray]));
        expected2 += glm::dot(dvec3(expected[ray]), dvec3(expected[ray]));
    }
    return std::sqrt(difference2 / expected2);
}
std::vector<Rgb> marched(const Scene& scene, std::span<const ViewRay> rays, int steps = 1500) {
    std::vector<Rgb> radiance(rays.size());
    parallel_for(
        rays.size(), Progress(), [&](std::size_t ray) { radiance[ray] = support::march(scene, rays[ray], steps); }, 1);
    return radiance;
}
} // namespace

TEST_CASE("an even grid scatters as fog in a box that is half a voxel larger") {
    constexpr int voxels = 64;
    const float half = 1.0f + 1.0f / (voxels - 1);
    Clouds clouds{.lights = {sun({0.2f, -0.3f, 1.0f})},
                  .grid = support::unit_grid(voxels, [](int, int, int) { return 1.0f; })};
    const auto grid = make(clouds);
    clouds.medium.lobes[0].sigma_s_per_m *= 1.5f;
    clouds.medium.sigma_a_per_m *= 1.5f;
    const auto box = support::make_scene(
        {{.mesh = support::cube(),
          .world_from_object = glm::scale(support::translation({0.1f, 0.2f, 0.0f}), half * vec3(1.3f, 1, 1)),
          .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
        {clouds.medium}, clouds.lights);
    const std::vector<ViewRay> rays = view({5, -4, 2}, 7);
    const Config fine{.method = Method::Exact, .grid_error_target = 1e-3f};
    const Result by_grid = shafts(*grid, rays, fine), by_box = shafts(*box, rays);
    CHECK(rms_error(by_grid.radiance, by_box.radiance) < 0.012); // at edges, which fade over a voxel
    const ViewRay through_middle[]{{{0.1f, -5, 0.0f}, {0, 1, 0}, 0.0f, 12.0f}};
    CHECK(rms_error(shafts(*grid, through_middle, fine).radiance, shafts(*box, through_middle).radiance) < 4e-3);
}

TEST_CASE("a sun down through a half-space ramp has the closed form of its quadratic depth") {
    // Density z over z in (0, 1) of a unit grid from 0 to 2: towards a sun straight up from height z the light has passed
    // (4 - z^2) / 2. A level ray at z has z per metre. Absorption alone but for a trace of scattering.
    constexpr int voxels = 32;
    const auto ramp =
        support::unit_grid(voxels, [](int, int, int z) { return 2.0f * static_cast<float>(z) / (voxels - 1); });
    const Medium medium{.name = "ramp", .lobes = {{Rgb(0.3f), 0.0f}}, .sigma_a_per_m = Rgb(0.2f)};
    SceneDescription description;
    description.media = {medium};
    description.volumes = {{.name = "ramp", .grid = ramp}};
    description.lights = {sun({0, 0, 1})};
    const Scene scene(std::move(description), Progress());
    // Over the top lies the half of the last voxel: a triangle of height 2 and width 2 / 31.
    constexpr double over_top = 2.0 / (voxels - 1), sigma_t = 0.5, sigma_s = 0.3;
    for (const float height : {-0.5f, 0.0f, 0.5f, 0.9f}) {
        const ViewRay ray[]{{{-0.9f, 0.0f, height}, {1, 0, 0}, 0.0f, 1.8f}};
        const double density = height + 1.0, above = 0.5 * (4.0 - density * density) + over_top;
        const double expected = 3.0 * sigma_s / sigma_t * 0.25 * std::numbers::inv_pi *
                                -std::expm1(-sigma_t * density * 1.8) * std::exp(-sigma_t * above);
        CAPTURE(height);
        CHECK(std::abs(shafts(scene, ray).radiance[0].x / expected - 1.0) < 3e-3);
    }
}

TEST_CASE(
    "clouds scatter what brute force finds, among occluders, in haze, under every light, from outside and inside") {
    for (const vec3& eye : {vec3(4, -5, 1), vec3(0.0f)}) {
        const std::vector<ViewRay> rays = view(eye);
        for (const Light& light : {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f}), lamp({0.3f, 0.2f, 0.1f}),
                                   lamp({30.0f, -10.0f, 20.0f}), spot({2.5f, 1.0f, 2.0f}, {-2.3f, -0.9f, -1.9f})}) {
            for (const bool has_haze : {false, true}) {
                const auto scene = make({.lights = {light}, .has_haze = has_haze, .has_soup = true});
                CAPTURE(eye.x);
                CAPTURE(light.position.x);
                CAPTURE(has_haze);
                const Result found = shafts(*scene, rays, {.method = Method::Exact, .grid_error_target = 0.002f});
                CHECK(rms_error(found.radiance, marched(*scene, rays)) <
                      0.012); // brute force misses edges by 0.5 %, and more near a lamp
            }
        }
    }
}

TEST_CASE("the error stays below what was asked for") {
    const auto scene = make({.lights = {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f})}, .has_haze = true});
    const std::vector<ViewRay> rays = view({4, -5, 1}, 9);
    const std::vector<Rgb> truth = marched(*scene, rays);
    for (const float target : {0.05f, 0.01f, 0.003f}) {
        CAPTURE(target);
        CHECK(rms_error(shafts(*scene, rays, {.method = Method::Exact, .grid_error_target = target}).radiance, truth) <
              1.5 * target);
    }
}

namespace {
/// Smoke, and `second` by a ramp.
std::unique_ptr<Scene> two_clouds(const Medium& second, const Light& light, bool is_joint) {
    const std::array<GridLeaves, 2> leaves{
        support::leaves_of(
            cloud_voxels, [](int x, int y, int z) { return 2.0f * support::blob(cloud_voxels, x, y, z); },
            support::unit_from_index(cloud_voxels)),
        support::leaves_of(
            cloud_voxels, [](int x, int, int z) { return x > 16 ? 0.03f * static_cast<float>(z) : 0.0f; },
            support::unit_from_index(cloud_voxels))};
    const auto both = std::make_shared<const DensityGrid>(leaves, Progress());
    SceneDescription description;
    description.media = {smoke, second};
    for (std::uint32_t channel = 0; channel < 2; ++channel)
        description.volumes.push_back(
            {.name = "cloud",
             .grid = is_joint ? both : std::make_shared<const DensityGrid>(leaves[channel], Progress()),
             .channel = is_joint ? channel : 0,
             .medium_index = channel});
    description.lights = {light};
    return std::make_unique<Scene>(std::move(description), Progress());
}
const Medium red{.name = "red", .lobes = {{Rgb(0.8f, 0.1f, 0.05f), -0.2f}}, .sigma_a_per_m = Rgb(0.0f, 0.7f, 0.9f)},
    pale{
        .name = "pale", .lobes = {{0.4f * Rgb(1.5f, 1.0f, 0.5f), 0.0f}}, .sigma_a_per_m = 0.4f * Rgb(0.2f, 0.4f, 0.6f)};
} // namespace

TEST_CASE("channels of one grid, of one colour or several, scatter what grids of their own scatter") {
    const std::vector<ViewRay> rays = view({4, -5, 1}, 9);
    for (const Medium& second : {red, pale})
        for (const Light& light : {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f})}) {
            const Config fine{.method = Method::Exact, .grid_error_target = 0.002f};
            CAPTURE(second.name);
            CHECK(rms_error(shafts(*two_clouds(second, light, true), rays, fine).radiance,
                            shafts(*two_clouds(second, light, false), rays, fine).radiance) < 0.003);
        }
}

// Seen to fail with one colour for channels of several, and with looks at the beginnings of steps.
TEST_CASE("columns of light hold the optical depth up to what lies between them, the less the nearer they are") {
    for (const Medium& second : {red, pale})
        for (const Light& light : {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f}), lamp({0.3f, 0.2f, 0.1f})}) {
            const auto scene = two_clouds(second, light, true);
            const Media media(*scene, Progress());
            GridLightDepth depth(media, sample_light(scene->lights()[0], 0, vec3(0.5f)));
            for (const auto& [spacing_voxels, most] :
                 {std::pair{4.0f, 0.07}, std::pair{2.0f, 0.022}, std::pair{1.0f, 0.006}, std::pair{0.5f, 0.0015}}) {
                depth.tabulate(spacing_voxels);
                double error2 = 0.0, sum2 = 0.0, error_sum = 0.0, sum = 0.0;
                for (std::uint32_t index = 0; index < 4000; ++index) {
                    const auto u = pcg4d({index, 1, 2, 3});
                    const vec3 point =
                        1.1f * (2.0f * vec3(unit_float(u[0]), unit_float(u[1]), unit_float(u[2])) - 1.0f);
                    const glm::dvec3 exact(depth.exact_depth(point)), found(depth.depth(point));
                    error2 += glm::dot(found - exact, found - exact);
                    sum2 += glm::dot(exact, exact);
                    error_sum += found.x + found.y + found.z - exact.x - exact.y - exact.z;
                    sum += exact.x + exact.y + exact.z;
                }
                CAPTURE(second.name);
                CAPTURE(light.position.x);
                CAPTURE(spacing_voxels);
                CHECK(std::sqrt(error2 / sum2) < most);
                CHECK(std::abs(error_sum / sum) < 0.2 * most);
            }
        }
}

TEST_CASE("light that ends within a voxel scatters where brute force finds it") {
    // Lumps of up to 30 free paths per voxel: columns of light would blur the edges of shadows over many free paths.
    Clouds clouds{.lights = {sun({0.9f, 0.3f, 0.2f}), lamp({2.0f, -1.5f, 1.5f})}};
    clouds.grid = support::unit_grid(cloud_voxels, [](int x, int y, int z) {
        return 400.0f * std::max(0.0f, support::blob(cloud_voxels, x, y, z) - 0.4f);
    });
    const auto scene = make(clouds);
    std::vector<ViewRay> rays = view({4, -5, 1}, 4);
    for (ViewRay& ray : rays)
        ray.near_m = 4.5f, ray.far_m = 8.0f;
    const Result found = shafts(*scene, rays);
    CHECK(rms_error(found.radiance, marched(*scene, rays, 12000)) < 0.01);
}

TEST_CASE("many lamps in one place light a flat dense cloud as one does") {
    // Columns for all of them are more than memory has room for. Seen to fail, the many all dark: columns eight voxels apart
    // taken, whatever their error.
    Clouds clouds{.lights = {lamp({0.6f, -0.5f, 1.2f})}, .scale = vec3(1.0f, 1.0f, 0.002f)};
    clouds.grid = support::unit_grid(cloud_voxels,
                                     [](int x, int y, int z) { return 1e5f * support::blob(cloud_voxels, x, y, z); });
    const std::vector<ViewRay> rays = view({4, -5, 3}, 8);
    const Result one = shafts(*make(clouds), rays);
    constexpr std::size_t count = 512;
    clouds.lights.assign(count, clouds.lights.front());
    for (Light& light : clouds.lights)
        light.strength /= static_cast<float>(count);
    CHECK(rms_error(shafts(*make(clouds), rays).radiance, one.radiance) < 0.01);
}

TEST_CASE("under a sky as bright everywhere, a cloud that only scatters sends back what it hides") {
    Clouds clouds{.lights = {}};
    clouds.medium = {.name = "white", .lobes = {{Rgb(2.0f), 0.0f}}};
    auto scene = make(clouds);
    SceneDescription description = support::description_of(*scene);
    description.world = World("sky", Rgb(0.7f), nullptr, mat3(1.0f));
    const Scene lit(std::move(description), Progress());
    const Media media(lit, Progress());
    const std::vector<ViewRay> rays = view({4, -5, 1});
    const Result found = shafts(lit, rays, {.method = Method::Exact, .world_samples = 16, .attenuates_light = false});
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const Rgb hidden =
            1.0f - media.transmittance({rays[ray].origin, rays[ray].direction, rays[ray].near_m, rays[ray].far_m});
        CHECK(std::abs(found.radiance[ray].x - 0.7f * hidden.x) < 2e-5f);
    }
}

TEST_CASE("the mean of ratio tracking is what brute force finds, within its confidence") {
    const std::vector<ViewRay> rays = view({4, -5, 1}, 3);
    for (const Light& light :
         {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f}), spot({2.5f, 1.0f, 2.0f}, {-2.3f, -0.9f, -1.9f})}) {
        const auto scene = make({.lights = {light}, .has_haze = true, .has_soup = true});
        const std::vector<Rgb> truth = marched(*scene, rays, 4000);
        constexpr std::uint32_t run_count = 200;
        double sum = 0.0, sum_of_squares = 0.0, expected = 0.0;
        for (const Rgb& radiance : truth)
            expected += radiance.x;
        for (std::uint32_t seed = 0; seed < run_count; ++seed) {
            double of_run = 0.0;
            for (const Rgb& radiance :
                 shafts(*scene, rays, {.method = Method::Exact, .grid_method = GridMethod::RatioTracking, .seed = seed})
                     .radiance)
                of_run += radiance.x;
            sum += of_run, sum_of_squares += of_run * of_run;
        }
        const double mean = sum / run_count;
        const double deviation = std::sqrt((sum_of_squares / run_count - mean * mean) / run_count);
        CAPTURE(light.position.x);
        CAPTURE(deviation / expected);
        CHECK(deviation < 0.02 * expected);
        CHECK(std::abs(mean - expected) < 4.0 * deviation + 0.002 * expected); // brute force misses edges
    }
}

TEST_CASE("light columns give the depth towards the light at any point, the nearer the finer they are") {
    const auto scene = make({.lights = {}});
    const Media media(*scene, Progress());
    support::SceneRandom random(3);
    std::vector<vec3> points;
    for (int index = 0; index < 2000; ++index)
        points.push_back(2.5f * random.uniform() * random.direction());
    for (const Light& light :
         {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f}), lamp({0.3f, 0.2f, 0.1f}), lamp({40.0f, -10.0f, 20.0f})}) {
        CAPTURE(light.position.x);
        GridLightDepth depth(media, sample_light(light, 0, vec3(0.5f)));
        double error_before = 1.0;
        for (const float spacing : {4.0f, 2.0f, 1.0f}) {
            depth.tabulate(spacing);
            CHECK(depth.bytes().of_values == 0.0); // nobody has asked yet
            double error = 0.0, worst = 0.0;
            for (const vec3& point : points) {
                const double difference = depth.depth(point).x - depth.exact_depth(point).x;
                error += difference * difference;
                worst = std::max(worst, std::abs(difference));
            }
            error = std::sqrt(error / static_cast<double>(points.size()));
            CAPTURE(spacing);
            CHECK(error < 0.5 * error_before);
            CHECK(worst < 20.0 * error);
            error_before = error;
        }
        CHECK(error_before < 0.015); // of depths up to 6
    }
}

TEST_CASE("a cloud's light shafts do not depend on the threads, nor on which rays are asked together") {
    const auto scene = make({.lights = {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f})}, .has_haze = true});
    const std::vector<ViewRay> rays = view({4, -5, 1}, 20);
    const auto render = [&](int threads) {
        return with_threads(threads, [&] { return shafts(*scene, rays).radiance; });
    };
    const std::vector<Rgb> alone = render(1), together = render(2);
    CHECK(std::ranges::equal(alone, together));
    Progress progress;
    const Media media(*scene, progress);
    const Shafts prepared(*scene, media, {.position = rays[0].origin}, rays, {.method = Method::Exact}, progress);
    std::vector<Rgb> some(7);
    prepared.scatter(std::span(rays).subspan(180, 7), some, {}, progress);
    CHECK(std::ranges::equal(some, std::span(alone).subspan(180, 7)));
}

TEST_CASE("slope rows see a cloud's shafts as cuts of triangles do") {
    const auto scene =
        make({.lights = {sun({0.5f, 0.2f, 0.8f}), lamp({2.0f, -1.5f, 1.5f})}, .has_haze = true, .has_soup = true});
    const std::vector<ViewRay> rays = view({4, -5, 1}, 24);
    const Result exact = shafts(*scene, rays);
    for (const Method method : {Method::Epipolar, Method::ShadowMap}) {
        const Result rows = shafts(*scene, rays, {.method = method, .resolution = 4096});
        CHECK(rms_error(rows.radiance, exact.radiance) < 0.02);
    }
}

TEST_CASE("lit lengths count the whole way through a cloud, however opaque it is") {
    Clouds clouds{.lights = {sun({0.5f, 0.2f, 0.8f})}};
    clouds.medium.sigma_a_per_m = Rgb(1e4f);
    const auto scene = make(clouds);
    for (const float visibility : shafts(*scene, view({4, -5, 1}, 5, 100.0f)).average_visibility)
        CHECK((visibility == 0.0f || std::abs(visibility - 1.0f) < 1e-3f));
}
} // namespace grid_scatter_test
