// SPDX-License-Identifier: GPL-3.0-or-later
// Light below a surface: what comes out of a half-space by Chandrasekhar's H, of slabs and with phases that lead ahead by
// walks of no art, of a closed white body all of it; and distances as their profile says.
#include "core/random.hpp"
#include "render/subsurface_exit.hpp"
#include "support/close_to.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <functional>
#include <numbers>

namespace subsurface_test {
using namespace tyndall;
using namespace tyndall::support;
using render::SubsurfaceEntry;
using render::SubsurfaceExit;

namespace {
constexpr double pi = std::numbers::pi;

/// Of a walk whose free path is so long, in all channels; white light enters, so that what is found is an albedo.
Lobe lobe_of(SubsurfaceMethod method, const Rgb& colour, const Rgb& path_m, float g = 0.0f, float alpha = 1e-4f,
             float ior = 1.4f) {
    return {.kind = Lobe::Kind::Subsurface,
            .subsurface = method,
            .alpha = alpha,
            .own_alpha = g,
            .ior = ior,
            .weight = colour,
            .a = path_m,
            .b = colour};
}

struct Mean {
    dvec3 mean{0.0}, error{0.0}; ///< Of the mean.
};
/// Of what `count` counts of each exit, over so many from one place on the top of part 0, seen at this angle.
Mean mean_of(const Scene& scene, const Lobe& lobe, std::uint32_t samples, double view_rad,
             const std::function<dvec3(const SubsurfaceExit&)>& count) {
    const vec3 outgoing(static_cast<float>(std::sin(view_rad)), 0.0f, static_cast<float>(std::cos(view_rad)));
    const vec3 start(0.013f, 0.021f, scene.bounds().max.z);
    const Ray ray{.origin = start + 0.5f * outgoing, .direction = -outgoing};
    const Hit hit = scene.closest_hit(ray);
    REQUIRE(hit.is_hit());
    const render::SurfacePoint point = render::surface_point(scene, ray, hit, 1);
    dvec3 sum(0.0), squares(0.0);
    for (std::uint32_t sample = 0; sample < samples; ++sample) {
        // Each of a pixel of its own: their errors are then those of independent samples.
        const auto exits = render::subsurface_exits({.scene = scene,
                                                     .point = point,
                                                     .lobe = lobe,
                                                     .outgoing = outgoing,
                                                     .footprint_m = 0.0f,
                                                     .random = {hash(5u, sample), 0}});
        dvec3 found(0.0);
        for (const SubsurfaceExit& exit : exits.all())
            found += count(exit);
        sum += found;
        squares += found * found;
    }
    const double n = samples;
    const dvec3 mean = sum / n;
    return {mean, glm::sqrt(glm::max(squares / n - mean * mean, dvec3(0.0)) / n)};
}
dvec3 weight_of(const SubsurfaceExit& exit) { return dvec3(exit.weight); }

/// Half a metre deep at least, and a metre to each side.
std::unique_ptr<Scene> block(double height_m, double side_m = 2.0) {
    const mat4 stretched = glm::scale(mat4(1.0f), 0.5f * vec3(side_m, side_m, height_m));
    return make_scene({{.mesh = cube(), .world_from_object = stretched}});
}

void check_near(const Mean& found, const dvec3& expected, double bound = 0.0) {
    for (int channel = 0; channel < 3; ++channel) {
        CAPTURE(channel);
        CAPTURE(found.mean[channel]);
        CAPTURE(found.error[channel]);
        CAPTURE(expected[channel]);
        CHECK(std::abs(found.mean[channel] - expected[channel]) <=
              4.0 * found.error[channel] + bound * expected[channel] + 1e-6);
    }
}

/// Chandrasekhar, Radiative Transfer, 1950, section 38: of an isotropically scattering half-space.
class HalfSpace {
public:
    explicit HalfSpace(double single_albedo) : single_albedo_(single_albedo), h_(node_count, 1.0) {
        for (int round = 0; round < 300; ++round) {
            std::vector<double> next(node_count);
            for (std::size_t i = 0; i < node_count; ++i)
                next[i] = 1.0 / inverse(node(i));
            h_ = next;
        }
    }
    /// Share of light from a cosine that comes out again.
    [[nodiscard]] double albedo(double cosine) const { return 1.0 - std::sqrt(1.0 - single_albedo_) / inverse(cosine); }
    [[nodiscard]] double albedo_by_cosine() const {
        double sum = 0.0;
        for (std::size_t i = 0; i < node_count; ++i)
            sum += 2.0 * node(i) * albedo(node(i)) / node_count;
        return sum;
    }

private:
    static constexpr std::size_t node_count = 200;
    static double node(std::size_t i) { return (static_cast<double>(i) + 0.5) / node_count; }
    [[nodiscard]] double inverse(double cosine) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < node_count; ++i)
            sum += node(i) * h_[i] / (cosine + node(i)) / node_count;
        return std::sqrt(1.0 - single_albedo_) + 0.5 * single_albedo_ * sum;
    }
    double single_albedo_;
    std::vector<double> h_;
};

struct Out {
    double reflected = 0.0, passed = 0.0;
};
/// Walks in a slab of this optical depth that are not guided and weigh nothing; the phase is even from the tenth scattering.
Out analog_slab(double depth, double single_albedo, double g, double extinction, std::uint32_t walks) {
    Out out;
    const double scattering = extinction * single_albedo, reduced = scattering * (1.0 - g);
    const double even_extinction = extinction - scattering + reduced;
    for (std::uint32_t walk = 0; walk < walks; ++walk) {
        std::uint32_t place = 0;
        const auto number = [&] { return double{unit_float(hash(77u, walk, place++))}; };
        double z = 0.0, cosine = std::sqrt(number());
        for (int scatterings = 0;; ++scatterings) {
            const bool is_even = scatterings >= 10;
            const double sigma = is_even ? even_extinction : extinction;
            z += cosine * -std::log(1.0 - number()) / sigma;
            if (z < 0.0 || z > depth) {
                (z < 0.0 ? out.reflected : out.passed) += 1.0 / walks;
                break;
            }
            if (number() >= (is_even ? reduced / even_extinction : single_albedo))
                break;
            const double mean = scatterings + 1 >= 10 ? 0.0 : g, u = number(), turn = 2.0 * pi * number();
            const double ratio = (1.0 - mean * mean) / (1.0 - mean + 2.0 * mean * u);
            const double bend = mean == 0.0 ? 1.0 - 2.0 * u : (1.0 + mean * mean - ratio * ratio) / (2.0 * mean);
            cosine = cosine * bend +
                     std::sqrt(std::max(0.0, (1.0 - cosine * cosine) * (1.0 - bend * bend))) * std::cos(turn);
        }
    }
    return out;
}
} // namespace

// Seen to fail: with distances weighed as if none was stretched.
TEST_CASE("a half-space sends back what Chandrasekhar's H says, by the cosine and of one direction") {
    const auto scene = block(2.0);
    const Rgb colour(0.8f, 0.3f, 0.55f), path_m(0.01f, 0.004f, 0.002f);
    for (const bool by_cosine : {true, false}) {
        CAPTURE(by_cosine);
        const Lobe lobe =
            lobe_of(by_cosine ? SubsurfaceMethod::CosineWalk : SubsurfaceMethod::RefractedWalk, colour, path_m);
        const double view = 1.1;
        dvec3 expected;
        for (int channel = 0; channel < 3; ++channel) {
            const HalfSpace half(subsurface::single_albedo(colour[channel], 0.0f));
            const double inside = std::sqrt(1.0 - std::pow(std::sin(view) / 1.4, 2.0));
            expected[channel] = by_cosine ? half.albedo_by_cosine() : half.albedo(inside);
            if (by_cosine) // what the inversion is for
                CHECK(std::abs(expected[channel] / colour[channel] - 1.0) < 0.02);
        }
        check_near(mean_of(*scene, lobe, 20000, view, weight_of), expected, 2e-3);
    }
}

// Seen to fail: with an even phase after the tenth scattering, and free paths as before.
TEST_CASE("of a slab as much is reflected and passes as of walks without any art") {
    for (const float g : {0.0f, 0.7f}) {
        CAPTURE(g);
        const float colour = 0.7f, path_m = 0.02f;
        const double extinction = 1.0 / (path_m * (1.0 - g)), depth_m = 0.05;
        const auto scene = block(depth_m, 4.0);
        const Out expected = analog_slab(depth_m, subsurface::single_albedo(colour, g), g, extinction, 200'000);
        const Lobe lobe = lobe_of(SubsurfaceMethod::CosineWalk, Rgb(colour), Rgb(path_m), g);
        const auto found = mean_of(*scene, lobe, 40000, 0.3, [](const SubsurfaceExit& exit) {
            const bool is_above = exit.point.shading.position.z > 0.0f;
            CHECK(exit.point.shading.shading_normal.z == close_to(is_above ? 1.0 : -1.0, 1e-5));
            return dvec3(is_above ? exit.weight.x : 0.0, is_above ? 0.0 : exit.weight.x, 0.0);
        });
        check_near(found, {expected.reflected, expected.passed, 0.0}, 5e-3);
    }
}

// Seen to fail: with walks that end at the 256th scattering, by 2 to 10 %.
TEST_CASE("nothing is lost in a white body, however thick, and nothing won") {
    for (const double height_m : {0.02, 0.3, 4.0})
        for (const SubsurfaceMethod method : {SubsurfaceMethod::CosineWalk, SubsurfaceMethod::SkinWalk}) {
            CAPTURE(height_m);
            const auto scene = block(height_m);
            const Lobe lobe = lobe_of(method, Rgb(1.0f), Rgb(0.01f, 0.02f, 0.005f));
            check_near(mean_of(*scene, lobe, 3000, 0.5, weight_of), dvec3(1.0), 4e-3);
        }
}

TEST_CASE("the radius is of the scene, whatever scale the object has") {
    const Lobe lobe = lobe_of(SubsurfaceMethod::CosineWalk, Rgb(0.8f), Rgb(0.05f));
    const auto spread = [&](const Scene& scene) {
        return mean_of(scene, lobe, 4000, 0.0,
                       [](const SubsurfaceExit& exit) {
                           const vec3& there = exit.point.shading.position;
                           return dvec3(exit.weight.x * std::hypot(there.x - 0.013f, there.y - 0.021f));
                       })
            .mean.x;
    };
    // Random numbers are the same: the meshes alone differ.
    const MeshArrays small = [] {
        MeshArrays arrays = arrays_of(*cube());
        for (vec3& position : arrays.positions)
            position *= vec3(0.1f, 0.02f, 0.5f);
        return arrays;
    }();
    const auto scaled =
        make_scene({{.mesh = mesh_of(small), .world_from_object = glm::scale(mat4(1.0f), vec3(10.0f, 50.0f, 2.0f))}});
    CHECK(spread(*scaled) == close_to(spread(*block(2.0)), 0.01));
}

TEST_CASE("distances on a plane are as often as the profile says") {
    const Rgb scale_m(0.03f, 0.006f, 0.003f), colour(0.8f, 0.5f, 0.3f);
    const auto scene = make_scene({{.mesh = square()}});
    const Lobe lobe = lobe_of(SubsurfaceMethod::Profile, colour, scale_m);
    for (const float within_m : {0.004f, 0.02f, 0.1f, 1.0f}) {
        CAPTURE(within_m);
        dvec3 expected(0.0);
        for (int channel = 0; channel < 3; ++channel) {
            constexpr int steps = 4000;
            for (int step = 0; step < steps; ++step)
                expected[channel] += colour[channel] * within_m / steps *
                                     subsurface::profile_density_per_m(
                                         scale_m[channel], within_m * (static_cast<float>(step) + 0.5f) / steps);
        }
        check_near(mean_of(*scene, lobe, 20000, 0.4,
                           [&](const SubsurfaceExit& exit) {
                               const vec3& there = exit.point.shading.position;
                               const bool is_within = std::hypot(there.x - 0.013f, there.y - 0.021f) < within_m;
                               return is_within ? dvec3(exit.weight) : dvec3(0.0);
                           }),
                   expected, 2e-3);
    }
}

TEST_CASE("a channel without a radius leaves its share to the surface, and no walk counts it") {
    const auto scene = block(1.0);
    const Lobe lobe = lobe_of(SubsurfaceMethod::RefractedWalk, Rgb(0.5f, 0.0f, 0.8f), Rgb(0.01f, 0.0f, 0.002f));
    const Mean found = mean_of(*scene, lobe, 200, 0.2, weight_of);
    CHECK(found.mean.y == 0.0);
    CHECK(found.mean.x > 0.2);
}
} // namespace subsurface_test
