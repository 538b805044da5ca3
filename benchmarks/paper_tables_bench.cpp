// SPDX-License-Identifier: GPL-3.0-or-later
// Tables 5.1 and 5.2 of Kol 2018 on this machine, all of their sizes, in scene F (the forest, for his Tree); 5.1 in S
// (Sponza-LowPoly), too. Full HD; counter kol_gpu_ms: what the paper has on a GeForce GTX 980 Titan.
//   table_5_1/map         the sun's depth map                       plain_map         a shadow ray per texel
//   table_5_1/holes       moving holes of 5 octaves cut into it     plain_holes       textbook noise, one thread
//   table_5_1/g_buffer    camera rays                               plain_g_buffer    one by one
//   table_5_1/visibility  map to rows, and all rays asked: the      plain_visibility  1,024 steps through the map, one
//                         exact integral, where he averages                           ray in 64, times 64
//   table_5_1/function    of visibility and depth, to all rays      plain_function    one thread, no SIMD
//   table_5_2/disc, square, rows: closings of the map; plain_square, plain_rows: textbook. filled_percent: of the texels
//                         that light passes through, those it no longer does
#include "light_shafts/flat_filters.hpp"
#include "light_shafts/placed_edit.hpp"
#include "light_shafts/shadow_map.hpp"
#include "support/machine.hpp"
#include "support/row_frames.hpp"
#include "support/scenes.hpp"
#include "support/textbook.hpp"
#include "transfer_functions/apply.hpp"
#include <chrono>
#include <functional>
#include <map>
#include <ranges>
#include <sstream>

namespace tyndall::bench {
namespace {
constexpr std::size_t width = 1920, height = 1080;
const Progress progress;

struct Sized {
    std::uint32_t size = 0;
    ShaftScene* scene = nullptr;
    slope_rows::Layout layout;
    ShadowMap map;
    [[nodiscard]] DepthMap& face() { return map.faces.front(); }
    [[nodiscard]] std::span<float> texels() {
        return {face().texels->slopes.get(), face().texels->layout.sample_count};
    }
    [[nodiscard]] ShadowMap raster() const {
        return raster_shadow_map(layout, scene->sun, size, scene->occluders, progress);
    }
};

Sized make_sized(ShaftScene& scene, std::uint32_t size) {
    Sized made{.size = size, .scene = &scene, .layout = {}, .map = {}};
    slope_rows::LayoutConfig config = layout_config(size);
    config.slices_per_line = 1.0f;
    made.layout = slope_rows::make_layout(*slope_rows::make_frame(scene.view, scene.sun), scene.rays, config, progress);
    made.map = made.raster();
    return made;
}

/// A scene's map, kept from benchmark to benchmark; filters and holes take a copy.
Sized& sized(ShaftScene& scene, std::uint32_t size) {
    static std::map<std::pair<ShaftScene*, std::uint32_t>, Sized> all;
    const auto [at, is_new] = all.try_emplace({&scene, size});
    if (is_new)
        at->second = make_sized(scene, size);
    return at->second;
}

std::unique_ptr<Scene> traced_scene(const ShaftScene& scene) {
    std::vector<vec3> positions = scene.soup.positions;
    positions.pop_back(); // which Embree wanted
    return support::make_scene(
        {{.mesh = support::mesh_of({.name = "soup", .positions = positions, .triangles = scene.soup.triangles})}});
}

void map(benchmark::State& state, Sized& of) {
    for (auto _ : state)
        benchmark::DoNotOptimize(of.raster());
}
void plain_map(benchmark::State& state, Sized& of) {
    const slope_rows::Layout& layout = of.face().texels->layout;
    std::vector<float> depths(layout.sample_count);
    for (auto _ : state)
        parallel_for(of.size, progress, [&](std::size_t y) {
            for (std::size_t x = 0; x < of.size; ++x) {
                const MapAxes& axes = of.face();
                const vec3 from =
                    axes.origin +
                    (layout.first_line + (static_cast<float>(x) + 0.5f) * layout.line_step) * axes.x_axis +
                    (layout.first_slice + static_cast<float>(y) * layout.slice_step) * axes.y_axis +
                    500.0f * axes.z_axis;
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                RTCRayHit hit{};
                hit.ray = {.org_x = from.x,
                           .org_y = from.y,
                           .org_z = from.z,
                           .tnear = 0.0f,
                           .dir_x = -axes.z_axis.x,
                           .dir_y = -axes.z_axis.y,
                           .dir_z = -axes.z_axis.z,
                           .time = 0,
                           .tfar = 1e5f,
                           .mask = ~0u,
                           .id = 0,
                           .flags = 0};
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                rtcIntersect1(of.scene->embree, &context, &hit);
                depths[y * of.size + x] = hit.ray.tfar;
            }
        });
}

void holes(benchmark::State& state, Sized& of) {
    const Light light{.name = "Sun", .kind = LightKind::Sun, .towards_light = of.scene->sun.towards_light};
    OccluderEdit edit{.name = "holes", .kind = EditKind::Holes};
    edit.noise = {.octaves = 5, .sway = 1.0f, .turn_rad = 1.0f};
    Sized own = make_sized(*of.scene, of.size);
    float* const texels = own.texels().data();
    for (auto _ : state) {
        const PlacedEdit placed(edit, light, {});
        parallel_blocks(of.size, 16, progress, [&](std::size_t begin, std::size_t end) {
            std::vector<float> x, y, z;
            std::vector<std::uint8_t> is_hole(of.size);
            for (std::size_t row = begin; row < end; ++row) {
                placed.space.place_row(own.face(), static_cast<std::int32_t>(row), x, y, z);
                placed.find_holes(x, y, z, is_hole);
                float* const of_row = texels + own.face().texels->layout.rows[row].offset;
                for (std::size_t column = 0; column < of.size; ++column)
                    of_row[column] = is_hole[column] != 0 ? slope_rows::no_occluder : of_row[column];
            }
        });
    }
}
void plain_holes(benchmark::State& state, Sized& of) {
    const textbook::Noise noise;
    std::vector<float> texels(of.texels().begin(), of.texels().end());
    for (auto _ : state)
        for (std::size_t y = 0; y < of.size; ++y)
            for (std::size_t x = 0; x < of.size; ++x) {
                const vec2 at = 0.02f * vec2(static_cast<float>(x), static_cast<float>(y)) + 2.0f;
                const float moved = noise.fractal(at.x, at.y);
                if (noise.fractal(at.x + 0.8f * moved, at.y + 0.6f * moved) < -0.1f)
                    texels[y * of.size + x] = slope_rows::no_occluder;
            }
}

void g_buffer(benchmark::State& state, Sized& of, bool one_by_one) {
    const std::unique_ptr<Scene> scene = traced_scene(*of.scene);
    std::vector<Ray> rays;
    for (const std::uint32_t square : std::views::iota(0u, static_cast<std::uint32_t>(width * height / 16)))
        for (std::uint32_t i = 0; i < 16; ++i) { // squares of 4 x 4 pixels
            const std::size_t x = square % (width / 4) * 4 + i % 4, y = square / (width / 4) * 4 + i / 4;
            const ViewRay& ray = of.scene->rays[y * width + x];
            rays.push_back({.origin = ray.origin, .direction = ray.direction});
        }
    std::vector<Hit> hits(rays.size());
    for (auto _ : state)
        parallel_blocks(rays.size(), 4096, progress, [&](std::size_t begin, std::size_t end) {
            for (std::size_t ray = begin; one_by_one && ray < end; ++ray)
                hits[ray] = scene->closest_hit(rays[ray]);
            if (!one_by_one)
                for (std::size_t ray = begin; ray < end; ray += 16)
                    scene->closest_hits(std::span(rays).subspan(ray, 16), std::span(hits).subspan(ray, 16));
        });
}

void visibility(benchmark::State& state, Sized& of) {
    const PieceRows pieces = make_grey_pieces(*of.scene);
    std::vector<Rgb> radiance(of.scene->rays.size());
    slope_rows::Rows rows(of.layout);
    for (auto _ : state) {
        rectify(of.map, rows, progress);
        query_by_wedge(rows, *of.scene, pieces, radiance);
    }
}
void plain_visibility(benchmark::State& state, Sized& of) {
    constexpr std::size_t stride = 64;
    constexpr int step_count = 1024;
    const DepthMap& map = of.face();
    std::vector<float> found(of.scene->rays.size() / stride);
    for (auto _ : state) {
        const auto start = std::chrono::steady_clock::now();
        parallel_for(
            found.size(), progress,
            [&](std::size_t i) {
                const ViewRay& ray = of.scene->rays[i * stride];
                int lit = 0;
                for (int step = 0; step < step_count; ++step) {
                    const float at_m = ray.far_m * (static_cast<float>(step) + 0.5f) / step_count;
                    const vec3 p = map.axes_of(ray.origin + at_m * ray.direction - map.origin);
                    lit += map.depth_at(p.x, p.y) < p.z;
                }
                found[i] = static_cast<float>(lit) / step_count;
            },
            256);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        state.SetIterationTime(taken.count() * static_cast<double>(stride));
    }
}

struct FunctionFrame {
    transfer_functions::ComposedFunction function = transfer_functions::compose(
        {.name = "ramp",
         .layers = {{.name = "ramp",
                     .kind = transfer_functions::LayerKind::Gradient,
                     .ramp = {{0.0f, 0.1f, 0.4f, 1.0f}, {0.9f, 0.4f, 0.1f, 0.6f}, {1.0f, 0.9f, 0.6f, 1.0f}}}}},
        transfer_functions::default_size, progress);
    std::vector<vec2> parameters;
    std::vector<Rgb> radiance = std::vector<Rgb>(width * height, Rgb(0.5f)), change{width * height, Rgb(0.0f)};

    /// Of visibility, which nothing here depends on, and depth.
    explicit FunctionFrame(const ShaftScene& scene) {
        for (std::size_t ray = 0; ray < scene.rays.size(); ++ray)
            parameters.emplace_back(static_cast<float>(ray % width) / width, scene.rays[ray].far_m / 150.0f);
    }
};
void function(benchmark::State& state, Sized& of) {
    FunctionFrame frame(*of.scene);
    for (auto _ : state)
        apply(frame.function, {}, frame.parameters, frame.radiance, {}, frame.change, progress);
}
void plain_function(benchmark::State& state, Sized& of) {
    FunctionFrame frame(*of.scene);
    const auto size = static_cast<float>(frame.function.size);
    for (auto _ : state)
        for (std::size_t ray = 0; ray < frame.change.size(); ++ray) {
            const vec2 at = glm::clamp(frame.parameters[ray], 0.0f, 1.0f) * size - 0.5f;
            const vec2 corner = glm::clamp(glm::floor(at), 0.0f, size - 2.0f), share = at - corner;
            const vec4* const texel = frame.function.texels.data() +
                                      static_cast<std::size_t>(corner.y) * frame.function.size +
                                      static_cast<std::size_t>(corner.x);
            const vec4 colour =
                glm::mix(glm::mix(texel[0], texel[1], share.x),
                         glm::mix(texel[frame.function.size], texel[frame.function.size + 1], share.x), share.y);
            frame.change[ray] += vec3(colour) - colour.w * frame.radiance[ray];
        }
}

/// `close` works in place, on what it closed already but for the first time: it costs the same.
template <typename Close>
void close_map(benchmark::State& state, Sized& of, const Close& close) {
    std::vector<float> texels(of.texels().begin(), of.texels().end());
    const auto open = static_cast<double>(std::ranges::count(texels, slope_rows::no_occluder));
    close(texels);
    state.counters["filled_percent"] =
        100.0 * (1.0 - static_cast<double>(std::ranges::count(texels, slope_rows::no_occluder)) / open);
    for (auto _ : state)
        close(texels);
}

void add(const std::string& name, char scene, std::uint32_t size, double kol_gpu_ms,
         const std::function<void(benchmark::State&, Sized&)>& run, bool has_own_clock = false) {
    auto* const registered = benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
        ShaftScene* const shafts = scene == 'S' ? sponza_scene() : &forest_scene();
        if (!shafts) {
            state.SkipWithError("Sponza-LowPoly is not there: set TYNDALL_SHARED_DATA");
            return;
        }
        run(state, sized(*shafts, size));
        state.counters["kol_gpu_ms"] = kol_gpu_ms;
    });
    registered->Unit(benchmark::kMillisecond);
    if (has_own_clock)
        registered->UseManualTime();
    else
        registered->UseRealTime();
}

/// With a slash between them.
template <typename... Parts>
std::string joined(const char* first, const Parts&... parts) {
    std::ostringstream text;
    text << first;
    (text << ... << (std::ostringstream() << '/' << parts).str());
    return text.str();
}

struct Row51 {
    std::uint32_t size;
    double map_ms, holes_ms, g_buffer_ms, visibility_ms, function_ms;
};
struct Row52 {
    std::uint32_t size, kernel;
    double filtering_ms;
    std::uint32_t length;
    double rows_ms;
};

void add_table_5_1(char scene, const Row51& row) {
    const auto one = [&](const char* name, double ms, const std::function<void(benchmark::State&, Sized&)>& run,
                         bool has_own_clock = false) {
        add(joined("table_5_1", name, scene, row.size), scene, row.size, ms, run, has_own_clock);
    };
    one("map", row.map_ms, map), one("plain_map", row.map_ms, plain_map);
    one("holes", row.holes_ms, holes), one("plain_holes", row.holes_ms, plain_holes);
    one("g_buffer", row.g_buffer_ms, [](benchmark::State& state, Sized& of) { g_buffer(state, of, false); });
    one("plain_g_buffer", row.g_buffer_ms, [](benchmark::State& state, Sized& of) { g_buffer(state, of, true); });
    one("visibility", row.visibility_ms, visibility);
    one("plain_visibility", 67.8, plain_visibility, true); // his, naive, too
    one("function", row.function_ms, function), one("plain_function", row.function_ms, plain_function);
}

void add_table_5_2(char scene, const Row52& row) {
    const auto one = [&](const char* name, std::uint32_t texels, double ms, const auto& close) {
        add(joined("table_5_2", name, scene, row.size, texels), scene, row.size, ms,
            [=](benchmark::State& state, Sized& of) { close_map(state, of, close); });
    };
    const std::uint32_t size = row.size, reach = row.kernel / 2;
    const auto by = [=](KernelShape shape) {
        return [=](std::vector<float>& texels) {
            const auto side = static_cast<std::int32_t>(size);
            flat_filters::close_map({texels.data(), side, side, side}, shape, static_cast<float>(reach), progress);
        };
    };
    one("disc", row.kernel, row.filtering_ms, by(KernelShape::Disc));
    one("square", row.kernel, row.filtering_ms, by(KernelShape::Square));
    one("plain_square", row.kernel, row.filtering_ms, [=](std::vector<float>& texels) {
        std::vector<float> other(texels.size());
        textbook::close_square(texels, other, size, reach);
    });
    one("rows", row.length, row.rows_ms, [=](std::vector<float>& texels) {
        parallel_for(
            size, progress,
            [&](std::size_t y) {
                flat_filters::close_row(std::span(texels).subspan(y * size, size),
                                        static_cast<std::int32_t>(row.length));
            },
            16);
    });
    one("plain_rows", row.length, row.rows_ms,
        [=](std::vector<float>& texels) { textbook::close_rows(texels, size, row.length / 2); });
}

const bool is_registered = [] {
    add_machine_to_context();
    for (const char scene : {'S', 'F'}) {
        for (const Row51& row : {Row51{512, 1.3, 0.1, 4.0, 1.6, 0.2}, Row51{1024, 1.6, 0.3, 3.9, 2.5, 0.2},
                                 Row51{2048, 4.0, 1.4, 4.1, 4.6, 0.2}})
            add_table_5_1(scene, row);
    }
    for (const Row52& row :
         {Row52{512, 11, 1.1, 15, 0.6}, Row52{512, 21, 3.7, 30, 1.1}, Row52{512, 41, 13.3, 60, 1.9},
          Row52{1024, 11, 4.5, 15, 1.7}, Row52{1024, 21, 15.4, 30, 2.9}, Row52{1024, 41, 56.7, 60, 5.2},
          Row52{2048, 11, 18.0, 15, 5.4}, Row52{2048, 21, 60.9, 30, 9.3}, Row52{2048, 41, 222.0, 60, 16.8}})
        add_table_5_2('F', row);
    return true;
}();
} // namespace
} // namespace tyndall::bench
