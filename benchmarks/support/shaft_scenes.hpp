// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of the light shaft benchmarks: S, the atrium of Sponza-LowPoly (where its file is present), easy for shafts; F,
// a forest of leaves, hard. Full HD, a sun, a homogeneous grey medium; view rays end at surfaces or at the fog's box.
#pragma once
#include "core/parallel.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/visibility.hpp"
#include "support/forest.hpp"
#include <cstdlib>
#include <embree3/rtcore.h>
#include <fstream>
#include <optional>
#include <string>

namespace tyndall::bench {
using light_shafts::ViewRay;

struct ShaftCamera {
    vec3 position, forward;
    float tan_half_width = 0.6f;
    Bounds3 fog;

    /// Through a point of the picture of full HD, in pixels from its lower left corner.
    [[nodiscard]] vec3 direction_at(float x_px, float y_px) const {
        constexpr float width = 1920.0f, height = 1080.0f;
        const vec3 right = glm::normalize(glm::cross(forward, vec3(0, 0, 1)));
        const vec3 up = glm::cross(right, forward);
        const float u = x_px / width * 2 - 1, v = (y_px / height * 2 - 1) * height / width;
        return glm::normalize(forward + tan_half_width * (u * right + v * up));
    }
};

struct ShaftScene {
    support::TriangleSoup soup;
    ShaftCamera camera;
    mat4 identity{1.0f};
    light_shafts::Occluders occluders;
    light_shafts::View view;
    LightSample sun;
    std::vector<ViewRay> rays; ///< Full HD, row by row.
    float sigma_t_per_m = 0.02f;
    RTCScene embree = nullptr;
    /// Of some rays: the scattered share by brute-force marching, the truth of all errors here.
    std::vector<std::uint32_t> truth_rays;
    std::vector<double> truth;
};

inline float far_in_box(const Bounds3& box, const vec3& origin, const vec3& direction) {
    const vec3 a = (box.min - origin) / direction, b = (box.max - origin) / direction, far = glm::max(a, b);
    return std::max(0.0f, std::min(far.x, std::min(far.y, far.z)));
}

inline RTCDevice embree_device() {
    static const RTCDevice device = rtcNewDevice(nullptr);
    return device;
}

inline void commit_embree(ShaftScene& scene) {
    scene.embree = rtcNewScene(embree_device());
    const RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    scene.soup.positions.emplace_back(0.0f); // Embree reads 16 bytes of the last vertex
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.soup.positions.data(), 0,
                               sizeof(vec3), scene.soup.positions.size() - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.soup.triangles.data(), 0,
                               sizeof(uvec3), scene.soup.triangles.size());
    rtcSetSceneFlags(scene.embree, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.embree, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene.embree);
}

inline bool is_lit(const ShaftScene& scene, const vec3& point) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const vec3 l = scene.sun.towards_light;
    RTCRay ray{.org_x = point.x,
               .org_y = point.y,
               .org_z = point.z,
               .tnear = 1e-5f,
               .dir_x = l.x,
               .dir_y = l.y,
               .dir_z = l.z,
               .time = 0,
               .tfar = 1e5f,
               .mask = ~0u,
               .id = 0,
               .flags = 0};
    rtcOccluded1(scene.embree, &context, &ray);
    return ray.tfar >= 0.0f;
}

inline void prepare(ShaftScene& scene, const ShaftCamera& camera, int truth_ray_count, int march_steps) {
    constexpr std::size_t width = 1920, height = 1080;
    commit_embree(scene);
    scene.occluders.add(light_shafts::make_occluder_mesh(scene.soup.positions, scene.soup.triangles), &scene.identity);
    scene.camera = camera;
    scene.view.position = camera.position;
    scene.rays.resize(width * height);
    Progress progress;
    parallel_for(width * height, progress, [&](std::size_t pixel) {
        const vec3 direction =
            camera.direction_at(static_cast<float>(pixel % width) + 0.5f, static_cast<float>(pixel / width) + 0.5f);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit hit{};
        hit.ray = {.org_x = camera.position.x,
                   .org_y = camera.position.y,
                   .org_z = camera.position.z,
                   .tnear = 0.0f,
                   .dir_x = direction.x,
                   .dir_y = direction.y,
                   .dir_z = direction.z,
                   .time = 0,
                   .tfar = far_in_box(camera.fog, camera.position, direction),
                   .mask = ~0u,
                   .id = 0,
                   .flags = 0};
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene.embree, &context, &hit);
        scene.rays[pixel] = {camera.position, direction, 0.0f, hit.ray.tfar};
    });
    support::SceneRandom random(11);
    for (int i = 0; i < truth_ray_count; ++i)
        scene.truth_rays.push_back(static_cast<std::uint32_t>(random.uniform() * static_cast<float>(width * height)));
    scene.truth.resize(scene.truth_rays.size());
    parallel_for(
        scene.truth.size(), progress,
        [&](std::size_t i) {
            const ViewRay& ray = scene.rays[scene.truth_rays[i]];
            const double step_m = double{ray.far_m} / march_steps, sigma = scene.sigma_t_per_m;
            double share = 0.0;
            for (int step = 0; step < march_steps; ++step)
                if (is_lit(scene, ray.origin + static_cast<float>((step + 0.5) * step_m) * ray.direction))
                    share += std::exp(-sigma * step * step_m) * -std::expm1(-sigma * step_m);
            scene.truth[i] = share;
        },
        8);
}

inline ShaftScene& forest_scene() {
    static ShaftScene scene;
    if (scene.rays.empty()) {
        scene.soup = support::make_forest();
        scene.sun.towards_light = support::forest_towards_sun();
        prepare(scene, {support::forest_camera_position, {0, 1, 0}, 0.6f, support::forest_fog_box}, 1500, 4096);
    }
    return scene;
}

/// Sponza-LowPoly from TYNDALL_SHARED_DATA, or from shared/data beside the repository; nothing where it is absent.
inline std::optional<support::TriangleSoup> load_sponza() {
    const char* folder = std::getenv("TYNDALL_SHARED_DATA");
    std::ifstream file((folder ? std::string(folder) : std::string("../shared/data")) +
                           "/sponza_lowpoly/Sponza_LowPoly.bin",
                       std::ios::binary);
    if (!file)
        return std::nullopt;
    std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
    support::TriangleSoup soup;
    // Two meshes, offsets as its .gltf states them; +Y up there.
    struct Part {
        std::size_t positions, position_count, indices, index_count;
    };
    for (const Part part : {Part{0, 64806, 777672, 175905}, Part{1129484, 4697, 1185848, 13347}}) {
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        const auto* p = reinterpret_cast<const vec3*>(bytes.data() + part.positions);
        for (std::size_t i = 0; i < part.position_count; ++i)
            soup.positions.push_back(0.008f * vec3(p[i].x, -p[i].z, p[i].y));
        const auto* index = reinterpret_cast<const std::uint16_t*>(bytes.data() + part.indices);
        for (std::size_t i = 0; i < part.index_count; i += 3)
            soup.triangles.push_back(uvec3(index[i], index[i + 1], index[i + 2]) + first);
    }
    return soup;
}

inline ShaftScene* sponza_scene() {
    static ShaftScene scene;
    if (!scene.rays.empty())
        return &scene;
    std::optional<support::TriangleSoup> soup = load_sponza();
    if (!soup)
        return nullptr;
    scene.soup = std::move(*soup);
    scene.sun.towards_light = glm::normalize(vec3(-0.5f, 0.2f, 0.8f));
    scene.sigma_t_per_m = 0.05f;
    const Bounds3 fog{.min = vec3(-15.5f, -9.5f, -1.1f), .max = vec3(14.5f, 9.5f, 11.5f)};
    // Between the arcades, along the atrium: about 2 transitions per ray.
    prepare(scene, {{8.0f, 0.0f, 2.0f}, glm::normalize(vec3(-1.0f, 0.1f, 0.1f)), 0.8f, fog}, 1500, 4096);
    return &scene;
}
} // namespace tyndall::bench
