// SPDX-License-Identifier: GPL-3.0-or-later
// Depth maps of edited lights: as fine as the error target asks for in this frame, and not much finer.
#include "core/parallel.hpp"
#include "light_shafts/edited_resolution.hpp"
#include "support/lattice.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <random>

namespace edited_resolution_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
/// A light over a lattice in fog, seen from the side.
std::unique_ptr<Scene> lattice_under(LightKind kind, const OccluderEdit& edit) {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    Light light{.name = "light", .kind = kind, .position = {0.1f, 0.2f, 4.0f}};
    light.towards_light = glm::normalize(vec3(0.2f, 0.3f, 1.0f));
    light.spot_half_angle_rad = 0.6f;
    light.occluder_edits = {edit};
    return make_scene({{.mesh = mesh_of(lattice())},
                       {.mesh = cube(), .world_from_object = glm::scale(mat4(1.0f), vec3(3.9f)), .material = fog}},
                      {{.name = "fog", .lobes = {{.sigma_s_per_m = Rgb(0.1f)}}}}, {light});
}
const View from_the_side{.is_orthographic = false, .position = {0.3f, -9.0f, -1.0f}};
std::vector<ViewRay> rays_through_fog() {
    std::vector<ViewRay> rays;
    for (int y = -27; y < 27; ++y)
        for (int x = -48; x < 48; ++x)
            rays.push_back(
                {from_the_side.position, glm::normalize(vec3(0.0125f * float(x), 1, 0.0125f * float(y))), 0.0f, 14.0f});
    return rays;
}
double count_of(const Result& result, std::string_view name) {
    for (const auto& count : result.statistics.counts)
        if (count.name == name)
            return count.value;
    return 0.0;
}

/// Lit up to a distance that lies beside the right one by a share of it that falls with the texels.
class Rough final : public Visibility {
public:
    Rough(double error) : error_(error) {}
    void lit_intervals(std::span<const ViewRay> rays, LitRows& lit) const override {
        std::mt19937 random(static_cast<std::uint32_t>(1e6 * error_));
        std::normal_distribution<double> deviation;
        for (const ViewRay& ray : rays) {
            const double length_m = 0.5 * (1.0 + error_ * deviation(random));
            lit.intervals.push_back({.near_m = ray.near_m, .far_m = ray.near_m + static_cast<float>(length_m)});
            lit.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }

private:
    double error_;
    Statistics statistics_;
};
} // namespace

// Seen to fail, as the last case here does, with a quarter of the error that a change tells.
TEST_CASE("the texels asked for keep the error target, whatever the order that errors fall by, and are not 8 times too "
          "many") {
    const auto scene = lattice_under(LightKind::Sun, {.name = "close"});
    Progress progress;
    const Media media(*scene, progress);
    const PreparedLights prepared{.media = media, .lights = {}, .statistics = {}};
    Beam beam;
    beam.sample = sample_light(scene->lights()[0], 0, vec3(0.5f));
    beam.sample.is_dimmed_by_media = false;
    beam.directional.emplace(media, beam.sample);
    constexpr float target = 0.002f;
    for (const double order : {0.75, 1.0})
        for (const double error_at_2048 : {1e-4, 1e-3, 3e-3, 6e-3, 3e-2}) {
            CAPTURE(order);
            CAPTURE(error_at_2048);
            const auto error_of = [&](double texels) { return error_at_2048 * std::pow(2048.0 / texels, order); };
            const float found =
                measured_error_target(prepared, beam, rays_through_fog(), target, [&](std::uint32_t texels) {
                    return std::make_unique<const Rough>(error_of(texels));
                });
            const double texels = double{texels_of_map(found)};
            CHECK((error_of(texels) < 1.1 * double{target} || found == target));
            CHECK((error_of(texels / 8) > double{target} || texels == 2048));
        }
}

TEST_CASE("light that the rays do not see leaves the error target as it is, and so does a coarse one") {
    const auto scene = lattice_under(LightKind::Sun, {.name = "close"});
    Progress progress;
    const Media media(*scene, progress);
    const PreparedLights prepared{.media = media, .lights = {}, .statistics = {}};
    Beam beam;
    beam.sample = sample_light(scene->lights()[0], 0, vec3(0.5f));
    beam.sample.is_dimmed_by_media = false;
    beam.directional.emplace(media, beam.sample);
    const auto dark = [](std::uint32_t) { return std::make_unique<const Rough>(-1e9); };
    CHECK(measured_error_target(prepared, beam, {}, 0.002f, dark) == 0.002f);
    bool is_asked = false;
    const auto asked = [&](std::uint32_t) {
        is_asked = true;
        return std::make_unique<const Rough>(0.0);
    };
    CHECK(measured_error_target(prepared, beam, rays_through_fog(), 0.02f, asked) == 0.02f);
    CHECK(!is_asked);
}

TEST_CASE("a resolution of 0 keeps the error target, to a quarter, against the finest map, with fewer texels where "
          "they are enough") {
    const std::vector<ViewRay> rays = rays_through_fog();
    const OccluderEdit close{.name = "close", .size_m = 0.5f, .distance_m = 4.0f},
        grow{.name = "grow", .kind = EditKind::Silhouette, .size_m = 0.5f, .distance_m = 4.0f};
    for (const LightKind kind : {LightKind::Sun, LightKind::Spot})
        for (const OccluderEdit& edit : {close, grow}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(static_cast<int>(edit.kind));
            const auto scene = lattice_under(kind, edit);
            Progress progress;
            const Result truth = run(*scene, from_the_side, rays, {.resolution = 8192}, progress);
            const Result found = run(*scene, from_the_side, rays, {.error_target = 0.002f}, progress);
            double squared_error = 0.0, sum = 0.0;
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                squared_error += std::pow(double{found.radiance[ray].x} - double{truth.radiance[ray].x}, 2.0);
                sum += double{truth.radiance[ray].x};
            }
            CHECK(std::sqrt(squared_error * static_cast<double>(rays.size())) < 1.25 * 0.002 * sum);
            CHECK(count_of(found, "slope rows: lines") < 0.6 * count_of(truth, "slope rows: lines"));
            if (kind != LightKind::Sun || edit.kind != close.kind)
                continue;
            const Result alone =
                with_threads(1, [&] { return run(*scene, from_the_side, rays, {.error_target = 0.002f}, progress); });
            CHECK(std::ranges::equal(alone.radiance, found.radiance));
        }
}
} // namespace edited_resolution_test
