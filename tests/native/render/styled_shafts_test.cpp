// SPDX-License-Identifier: GPL-3.0-or-later
// Transfer functions in whole pictures: the axes have closed forms, the neutral function changes no bit.
#include "render/asked_rays.hpp"
#include "render/frame.hpp"
#include "render/styled_shafts.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

namespace styled_shafts_test {
using namespace tyndall;
using namespace tyndall::support;
using namespace tyndall::transfer_functions;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
/// Looks straight down from z = 5 at [-2.25, 2.25]^2.
Camera camera_above(std::uint32_t size_px = 24) {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.45f;
    camera.window_right = camera.window_top = 0.45f;
    camera.width_px = camera.height_px = size_px;
    return camera;
}
/// Fog in [-3, 3]^2 x [0.5, 4.5] over a plate at z = 1, of which the left half is covered at z = 3; a sun from the side.
std::unique_ptr<Scene> fog_over_plates(float sun_half_angle_rad = 0.0f) {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    const Medium medium{.name = "fog",
                        .lobes = {{.sigma_s_per_m = Rgb(0.1f), .asymmetry_g = 0.0f}},
                        .sigma_a_per_m = Rgb(0.0f),
                        .emission_w_per_m3_sr = Rgb(0.0f)};
    const mat4 box = glm::scale(translation({0, 0, 2.5f}), vec3(3, 3, 2));
    const mat4 low = glm::scale(translation({0, 0, 1}), vec3(1.5f, 1.5f, 1.0f));
    const mat4 high = glm::scale(translation({-1, 0, 3}), vec3(1.0f, 2.0f, 1.0f));
    Light sun{.name = "Sun", .strength = Rgb(3.0f), .towards_light = glm::normalize(vec3(1, 0, 2))};
    sun.half_angle_rad = sun_half_angle_rad;
    return make_scene({{.mesh = cube(), .world_from_object = box, .material = fog},
                       {.mesh = square(), .world_from_object = low},
                       {.mesh = square(), .world_from_object = high}},
                      {medium}, {sun});
}
FrameConfig config_with(std::vector<WeightedFunction> functions, std::uint32_t samples = 1) {
    FrameConfig config;
    config.pixel_samples = samples;
    for (const Pass pass : {Pass::Depth, Pass::Shafts, Pass::ShaftsVisibility, Pass::Transmittance})
        config.passes.add(pass);
    config.shafts.method = light_shafts::Method::Exact;
    config.transfer_functions = std::move(functions);
    return config;
}
Film film_of(const Scene& scene, const FrameConfig& config, const Camera& camera = camera_above()) {
    Progress progress;
    return render::render(scene, camera, config, progress);
}
const std::vector<float>& values(const Film& film, Pass pass) { return film.find(pass)->values; }

Layer solid(const vec4& colour) { return {.name = "solid", .kind = LayerKind::Solid, .colour = colour}; }
/// From black to white along x (or y): what replaces the light is the parameter itself.
Layer ramp(bool along_y = false) {
    return {.name = "ramp",
            .kind = LayerKind::Gradient,
            .ramp = {vec4(0, 0, 0, 1), vec4(1)},
            .from = along_y ? vec2(0.5f, 0.0f) : vec2(0.0f, 0.5f),
            .to = along_y ? vec2(0.5f, 1.0f) : vec2(1.0f, 0.5f)};
}
TransferFunction function_of(std::vector<Layer> layers, ParameterAxis x = {.full_visibility = 1.0f}) {
    TransferFunction function;
    function.name = "function";
    function.x = std::move(x);
    function.y = {.axis = Axis::Depth, .low_m = 0.0f, .high_m = 10.0f};
    function.layers = std::move(layers);
    return function;
}
/// The parameter along `axis` of every pixel, read back from a picture that shows it.
std::vector<float> shown(const Scene& scene, const ParameterAxis& axis, const Camera& camera = camera_above(),
                         std::optional<std::uint32_t> reference_light = {}) {
    FrameConfig config = config_with({{.function = function_of({ramp()}, axis)}});
    config.reference_light = reference_light;
    const Film film = film_of(scene, config, camera);
    std::vector<float> along;
    for (std::size_t pixel = 0; pixel < values(film, Pass::Depth).size(); ++pixel)
        along.push_back(values(film, Pass::Shafts)[3 * pixel]);
    return along;
}
// A function is a picture of 256 texels: clamped in half a texel at its ends.
constexpr float texel = 1.0f / 256.0f;
} // namespace

TEST_CASE("a function that changes nothing leaves every bit of the picture") {
    const auto scene = fog_over_plates(0.05f);
    FrameConfig config = config_with({}, 8);
    config.noise_threshold = 0.05f;
    const Film physical = film_of(*scene, config);
    TransferFunction white = function_of({solid(vec4(1.0f))});
    white.use = Use::Multiply;
    const Layer unseen{.name = "unseen", .kind = LayerKind::Solid, .opacity = 0.0f, .colour = {1, 0, 0, 1}};
    for (const TransferFunction& neutral : {white, function_of({}), function_of({unseen})}) {
        config.transfer_functions = {{.function = neutral}};
        const Film film = film_of(*scene, config);
        for (const render::Plane& plane : physical.planes)
            CHECK(values(film, plane.pass) == plane.values);
    }
}

TEST_CASE("a solid colour replaces the light wherever there is a medium, and half of its weight half of it") {
    const auto scene = fog_over_plates();
    const Rgb colour(0.5f, 0.25f, 2.0f);
    TransferFunction flat = function_of({solid(vec4(colour, 1.0f))});
    flat.strength = 3.0f;
    const Film physical = film_of(*scene, config_with({}, 4));
    for (const float weight : {1.0f, 0.5f}) {
        const Film film = film_of(*scene, config_with({{.function = flat, .weight = weight}}, 4));
        for (std::size_t index = 0; index < values(film, Pass::Shafts).size(); ++index) {
            const float light = values(physical, Pass::Shafts)[index];
            const float wanted = light + weight * (3.0f * colour[static_cast<int>(index % 3)] - light);
            CHECK(std::abs(values(film, Pass::Shafts)[index] - wanted) < 1e-5f);
        }
        for (std::size_t pixel = 0; pixel < values(film, Pass::Depth).size(); ++pixel)
            for (std::size_t channel = 0; channel < 3; ++channel) {
                const auto rest = [&](const Film& of) {
                    return values(of, Pass::Combined)[4 * pixel + channel] -
                           values(of, Pass::Shafts)[3 * pixel + channel];
                };
                CHECK(std::abs(rest(film) - rest(physical)) < 1e-5f); // surfaces keep their light
            }
    }
}

TEST_CASE("each axis measures what it says") {
    const auto scene = fog_over_plates();
    const Camera camera = camera_above();
    const Film film = film_of(*scene, config_with({}));
    const auto visibility = shown(*scene, {.full_visibility = 1.0f});
    const auto depth = shown(*scene, {.axis = Axis::Depth, .low_m = 1.0f, .high_m = 6.0f});
    const auto height = shown(*scene, {.axis = Axis::Height, .low_m = 0.0f, .high_m = 4.0f});
    const auto opacity = shown(*scene, {.axis = Axis::OpticalDepth});
    const auto angle = shown(*scene, {.axis = Axis::LightAngle});
    const vec3 to_sun = glm::normalize(vec3(1, 0, 2));
    bool sees_sky = false;
    for (std::size_t pixel = 0; pixel < visibility.size(); ++pixel) {
        const float depth_m = values(film, Pass::Depth)[pixel];
        const bool is_sky = depth_m > 1e9f;
        sees_sky |= is_sky;
        CHECK(std::abs(visibility[pixel] - values(film, Pass::ShaftsVisibility)[pixel]) < texel);
        CHECK(std::abs(depth[pixel] - (is_sky ? 1.0f : (depth_m - 1.0f) / 5.0f)) < texel);
        CHECK(std::abs(height[pixel] - (is_sky ? 1.0f : (5.0f - depth_m) / 4.0f)) < texel);
        CHECK(std::abs(opacity[pixel] - (1.0f - values(film, Pass::Transmittance)[3 * pixel])) < texel);
        const Ray ray = camera.ray(static_cast<float>(pixel % 24) + 0.5f, static_cast<float>(pixel / 24) + 0.5f);
        CHECK(std::abs(angle[pixel] - std::acos(glm::dot(ray.direction, to_sun)) / std::numbers::pi_v<float>) < texel);
    }
    CHECK(sees_sky);
    // Fitted, what the best lit rays have is 1.
    const auto fitted = shown(*scene, {});
    const float most = *std::ranges::max_element(visibility);
    for (std::size_t pixel = 0; pixel < visibility.size(); ++pixel)
        CHECK(std::abs(fitted[pixel] - std::min(1.0f, visibility[pixel] / most)) < 0.02f);
}

TEST_CASE(
    "without a sun functions are about all lamps together, or about the one that is chosen, be it a spot or a point") {
    Light point{.name = "Point", .kind = LightKind::Point, .strength = Rgb(20.0f), .position = {2.5f, 0, 4}};
    Light spot{.name = "Spot", .kind = LightKind::Spot, .strength = Rgb(50.0f), .position = {0.5f, 1, 4.4f}};
    spot.spot_half_angle_rad = 0.9f;
    const auto under = [](std::vector<Light> lights) {
        SceneDescription description = description_of(*fog_over_plates());
        description.lights = std::move(lights);
        return Scene(std::move(description), Progress());
    };
    const Scene both = under({point, spot});
    const ParameterAxis visibility{.full_visibility = 1.0f}, lit{.axis = Axis::MeanLitPosition, .high_m = 10.0f};
    const std::array<std::vector<float>, 2> alone{shown(under({point}), visibility), shown(under({spot}), visibility)};
    CHECK(alone[0] != alone[1]);
    for (const std::uint32_t light : {0u, 1u}) {
        CAPTURE(light);
        const std::vector<float> chosen = shown(both, visibility, camera_above(), light),
                                 chosen_lit = shown(both, lit, camera_above(), light),
                                 lit_alone = shown(under({light == 0 ? point : spot}), lit);
        for (std::size_t pixel = 0; pixel < chosen.size(); ++pixel) {
            CHECK(std::abs(chosen[pixel] - alone[light][pixel]) < 1e-4f);
            CHECK(std::abs(chosen_lit[pixel] - lit_alone[pixel]) < 1e-4f);
        }
    }
    const std::vector<float> together = shown(both, visibility);
    for (std::size_t pixel = 0; pixel < together.size(); ++pixel)
        CHECK(std::abs(together[pixel] - 0.5f * (alone[0][pixel] + alone[1][pixel])) < texel);
}

TEST_CASE("the mean lit position of a ray that is lit from end to end is the middle of its fog") {
    // Over the high plate, on the sunny side of everything.
    const auto scene = fog_over_plates();
    const auto position = shown(*scene, {.axis = Axis::MeanLitPosition, .low_m = 0.0f, .high_m = 4.0f});
    const Film film = film_of(*scene, config_with({}));
    std::size_t lit_count = 0;
    for (std::size_t pixel = 0; pixel < position.size(); ++pixel) {
        if (values(film, Pass::ShaftsVisibility)[pixel] < 1.0f || values(film, Pass::Depth)[pixel] > 2.5f)
            continue;
        const Ray ray =
            camera_above().ray(static_cast<float>(pixel % 24) + 0.5f, static_cast<float>(pixel / 24) + 0.5f);
        const float middle_m = 0.5f * (0.5f + 2.0f) / -ray.direction.z; // the fog begins at z = 4.5, the plate is at 3
        CHECK(std::abs(position[pixel] - middle_m / 4.0f) < texel);
        ++lit_count;
    }
    CHECK(lit_count > 50);
}

TEST_CASE("a mask lies over the camera's frame") {
    const auto scene = fog_over_plates();
    auto mask = std::make_shared<Texture>();
    mask->width = 2, mask->height = 1, mask->is_srgb = false, mask->interpolation = TextureInterpolation::Closest;
    mask->floats = {0, 0, 0, 1, 0.75f, 0.75f, 0.75f, 1};
    const auto masked = shown(*scene, {.axis = Axis::Mask, .mask = mask});
    for (std::size_t pixel = 0; pixel < masked.size(); ++pixel)
        CHECK(std::abs(masked[pixel] - (pixel % 24 < 12 ? 0.0f : 0.75f)) < texel);
}

TEST_CASE("a pixel that sees a near edge before a far one mixes their colours, not their depths") {
    const auto scene = fog_over_plates();
    // Near is red, far is blue; between them lies green, which no surface has.
    Layer bands = ramp(true);
    bands.ramp = {vec4(1, 0, 0, 1), vec4(1, 0, 0, 1), vec4(0, 1, 0, 1), vec4(0, 0, 1, 1), vec4(0, 0, 1, 1)};
    TransferFunction function = function_of({bands});
    function.y = {.axis = Axis::Depth, .low_m = 2.0f, .high_m = 4.0f}; // the plates are at 0 and at 1
    const Film film = film_of(*scene, config_with({{.function = function}}, 16));
    std::size_t mixed = 0, fringed = 0;
    for (std::size_t pixel = 0; pixel < values(film, Pass::Depth).size(); ++pixel) {
        const float* colour = &values(film, Pass::Shafts)[3 * pixel];
        fringed += colour[1] > 1e-5f;
        mixed += colour[0] > 0.1f && colour[2] > 0.1f;
    }
    CHECK(mixed >= 10);
    CHECK(fringed <= 2); // the corners of the low plate, where a pixel sees both plates and the sky
}

TEST_CASE("a function with an edge draws it through a pixel at the share that lies on either side") {
    // Depth over a slope rises along x; the function is black before the middle, white behind.
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    const Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = Rgb(0.1f), .asymmetry_g = 0.0f}}};
    mat4 leaning = glm::rotate(mat4(1.0f), 0.9f, vec3(0, 1, 0.07f));
    const auto scene =
        make_scene({{.mesh = cube(), .world_from_object = glm::scale(mat4(1.0f), vec3(9, 9, 4)), .material = fog},
                    {.mesh = square(), .world_from_object = glm::scale(leaning, vec3(6))}},
                   {medium}, {{.name = "Sun", .strength = Rgb(3.0f), .towards_light = vec3(0, 0, 1)}});
    Layer edge = ramp(true);
    edge.ramp.assign(256, vec4(0, 0, 0, 1));
    std::fill(edge.ramp.begin() + 128, edge.ramp.end(), vec4(1));
    TransferFunction function = function_of({edge});
    function.y = {.axis = Axis::Depth, .low_m = 3.0f, .high_m = 7.0f};
    const auto whites = [&](std::uint32_t size_px) {
        return values(film_of(*scene, config_with({{.function = function}}), camera_above(size_px)), Pass::Shafts);
    };
    const std::vector<float> coarse = whites(24), fine = whites(24 * 16);
    double error = 0.0, jagged = 0.0, edge_count = 0.0;
    for (std::size_t y = 0; y < 24; ++y)
        for (std::size_t x = 1; x < 23; ++x) {
            double share = 0.0;
            for (std::size_t i = 0; i < 256; ++i)
                share += fine[3 * ((y * 16 + i / 16) * 384 + x * 16 + i % 16)] / 256.0;
            if (share < 0.05 || share > 0.95)
                continue;
            edge_count += 1.0;
            error += std::abs(coarse[3 * (y * 24 + x)] - share);
            jagged += std::min(share, 1.0 - share);
        }
    REQUIRE(edge_count > 15.0);
    CHECK(error / edge_count < 0.13); // a grid of four: an eighth
    CHECK(error < 0.6 * jagged);      // what one look-up per pixel is off
}

TEST_CASE("a kept picture under other layers is the picture that they would have rendered, bit for bit") {
    const auto scene = fog_over_plates(0.03f);
    FrameConfig config = config_with({{.function = function_of({ramp()})}}, 4);
    config.keeps_unstyled = true;
    const Film first = film_of(*scene, config);
    CHECK(values(first, Pass::Combined) != values(film_of(*scene, config_with({}, 4)), Pass::Combined));
    REQUIRE(first.unstyled);
    config.transfer_functions[0].function.layers.push_back(solid({0.2f, 0.4f, 0.1f, 0.5f}));
    config.transfer_functions[0].weight = 0.8f;
    const Film rendered = film_of(*scene, config);
    const Film restyled = render::styled(*first.unstyled, config.transfer_functions, Progress());
    for (const render::Plane& plane : rendered.planes)
        CHECK(values(restyled, plane.pass) == plane.values);
}

TEST_CASE("a region keeps the full frame's colours, also where a range is fitted") {
    const auto scene = fog_over_plates();
    TransferFunction fitted = function_of({ramp(true)});
    fitted.y = {.axis = Axis::Depth};
    FrameConfig config = config_with({{.function = fitted}});
    const Film full = film_of(*scene, config);
    config.region = render::Region{.x0 = 4, .y0 = 8, .x1 = 12, .y1 = 20};
    const Film part = film_of(*scene, config);
    for (std::uint32_t y = 9; y < 19; ++y) // pixels at its border lack neighbours, whose slopes they take
        for (std::uint32_t x = 5; x < 11; ++x)
            CHECK(values(part, Pass::Shafts)[3 * ((y - 8) * 8 + (x - 4))] ==
                  values(full, Pass::Shafts)[3 * (y * 24 + x)]);
}

TEST_CASE("a ray that is asked for has the parameters that the picture shows there") {
    const auto scene = fog_over_plates();
    const FrameConfig config = config_with({{.function = function_of({ramp()})}});
    const Film film = film_of(*scene, config_with({}));
    std::vector<vec2> places;
    for (std::uint32_t pixel = 0; pixel < 576; ++pixel)
        places.emplace_back(static_cast<float>(pixel % 24) + 0.5f, static_cast<float>(pixel / 24) + 0.5f);
    Progress progress;
    const Media media(*scene, progress);
    const std::vector<vec2> found = render::ray_parameters(*scene, media, camera_above(), config, places, progress);
    for (std::size_t pixel = 0; pixel < places.size(); ++pixel) {
        CHECK(std::abs(found[pixel].x - values(film, Pass::ShaftsVisibility)[pixel]) < 1e-4f);
        CHECK(std::abs(found[pixel].y - std::min(1.0f, values(film, Pass::Depth)[pixel] / 10.0f)) < 1e-5f);
    }
    CHECK_THROWS_WITH_AS((void)render::ray_parameters(*scene, media, camera_above(), config_with({}), places, progress),
                         doctest::Contains("transfer function"), InvalidInput);
}

TEST_CASE("a constraint that stands for a point of the scene lies where the point's view ray is") {
    const auto scene = fog_over_plates();
    const vec3 point(0.8f, 0.3f, 1.0f); // in the plate's shadow
    const Camera camera = camera_above();
    const vec2 seen = vec2(point) / (5.0f - point.z);
    const std::vector<vec2> place{(seen + vec2(0.45f)) / 0.9f * 24.0f};
    Layer layer{.name = "picked", .kind = LayerKind::Diffusion};
    layer.constraints = {{.position = {0.1f, 0.9f}, .colour = {0, 0, 1, 1}}, {.colour = {1, 0, 0, 1}, .point = point}};
    FrameConfig config = config_with({{.function = function_of({layer})}});
    const Film followed = film_of(*scene, config);
    Progress progress;
    const Media media(*scene, progress);
    layer.constraints[1].position = render::ray_parameters(*scene, media, camera, config, place, progress).front();
    layer.constraints[1].point.reset();
    const Film placed = film_of(*scene, config_with({{.function = function_of({layer})}}));
    double difference = 0.0, largest = 0.0;
    for (std::size_t index = 0; index < values(placed, Pass::Shafts).size(); ++index) {
        difference = std::max<double>(
            difference, std::abs(values(followed, Pass::Shafts)[index] - values(placed, Pass::Shafts)[index]));
        largest = std::max<double>(largest, values(placed, Pass::Shafts)[index]);
    }
    CHECK(difference < 1e-4 * largest);
    layer.constraints[1] = {.colour = {1, 0, 0, 1}, .point = vec3(0, 0, 9)}; // behind the camera: it stays where it was
    CHECK_NOTHROW((void)film_of(*scene, config_with({{.function = function_of({layer})}})));
}

TEST_CASE("one function colours scenes of any size alike where its ranges are fitted") {
    // The same scene, a hundred times larger, in fog a hundred times thinner.
    const auto of_size = [](float size) {
        Material fog{.name = "fog"};
        fog.has_surface = false;
        fog.medium_index = 0;
        const Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = Rgb(0.1f / size), .asymmetry_g = 0.0f}}};
        const mat4 scaled = glm::scale(mat4(1.0f), vec3(size));
        const auto scene = make_scene(
            {{.mesh = cube(),
              .world_from_object = scaled * glm::scale(translation({0, 0, 2}), vec3(3)),
              .material = fog},
             {.mesh = square(), .world_from_object = scaled * translation({-0.5f, 0, 1})},
             {.mesh = square(), .world_from_object = scaled * translation({0.5f, 0, 3})}},
            {medium}, {{.name = "Sun", .strength = Rgb(3.0f), .towards_light = glm::normalize(vec3(1, 0, 2))}});
        TransferFunction fitted = function_of({ramp(true)});
        fitted.y = {.axis = Axis::Depth};
        Camera camera = camera_above();
        camera.world_from_camera = translation({0, 0, 5 * size});
        camera.clip_near_m *= size, camera.clip_far_m *= size;
        return values(film_of(*scene, config_with({{.function = fitted}}), camera), Pass::Shafts);
    };
    const std::vector<float> small = of_size(1.0f);
    for (const float size : {10.0f, 100.0f}) {
        const std::vector<float> large = of_size(size);
        for (std::size_t index = 0; index < small.size(); ++index)
            CHECK(std::abs(large[index] - small[index]) < 1e-4f);
    }
}
} // namespace styled_shafts_test
