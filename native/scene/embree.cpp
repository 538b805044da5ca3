// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/embree.hpp"
#include "core/errors.hpp"
#include "core/simd.hpp"
#include <atomic>
#include <string>

namespace tyndall {
// Embree reports on the thread that made the call, also where a worker failed.
static thread_local std::string last_message;
static std::atomic<std::ptrdiff_t> held_bytes{0}, most_held_bytes{0};

/// Embree's choice, or the instruction set that is forced.
static const char* device_settings() {
    if (!is_simd_target_forced())
        return nullptr;
    switch (available_simd_targets().back()) {
    case SimdTarget::Sse4:
        return "isa=sse42";
    case SimdTarget::Avx2:
        return "isa=avx2";
    case SimdTarget::Avx512:
        return "isa=avx512";
    }
    return nullptr;
}

static RTCDevice new_device() {
    const RTCDevice device = rtcNewDevice(device_settings());
    if (device == nullptr)
        throw Error("Embree did not start, error " + std::to_string(rtcGetDeviceError(nullptr)));
    rtcSetDeviceErrorFunction(
        device, [](void*, RTCError, const char* message) { last_message = message; }, nullptr);
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void*, ssize_t bytes, bool) {
            const std::ptrdiff_t held = held_bytes.fetch_add(bytes, std::memory_order_relaxed) + bytes;
            std::ptrdiff_t most = most_held_bytes.load(std::memory_order_relaxed);
            while (held > most && !most_held_bytes.compare_exchange_weak(most, held, std::memory_order_relaxed)) {
            }
            return true;
        },
        nullptr);
    return device;
}

RTCDevice embree_device() {
    // Never released: at exit TBB's threads may end before our statics do, and Embree's device waits for them.
    static const RTCDevice device = new_device();
    return device;
}

std::size_t most_embree_bytes() { return static_cast<std::size_t>(most_held_bytes.load(std::memory_order_relaxed)); }

void check_embree(std::string_view what) {
    const RTCError error = rtcGetDeviceError(embree_device());
    if (error == RTC_ERROR_NONE)
        return;
    if (error == RTC_ERROR_CANCELLED)
        throw Cancelled();
    throw Error("Embree: " + std::string(what) + ": " + last_message);
}

void commit(RTCScene scene, std::string_view what, const Progress& progress) {
    const auto goes_on = [](void* pointer, double) { return !static_cast<const Progress*>(pointer)->is_cancelled(); };
    // Embree promises not to change what the pointer shows; the callback only reads it.
    rtcSetSceneProgressMonitorFunction(scene, goes_on, const_cast<Progress*>(&progress));
    rtcCommitScene(scene);
    rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    check_embree(what);
}

void attach_instance(RTCScene scene, RTCScene instanced, const mat4& scene_from_object, unsigned int id,
                     unsigned int mask) {
    const RTCGeometry geometry = rtcNewGeometry(embree_device(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, instanced);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &scene_from_object[0][0]);
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

RTCRay embree_ray(const Ray& ray, unsigned int mask) {
    RTCRay result{};
    result.org_x = ray.origin.x;
    result.org_y = ray.origin.y;
    result.org_z = ray.origin.z;
    result.tnear = ray.near_m;
    result.dir_x = ray.direction.x;
    result.dir_y = ray.direction.y;
    result.dir_z = ray.direction.z;
    result.tfar = ray.far_m;
    result.mask = mask;
    return result;
}
} // namespace tyndall
