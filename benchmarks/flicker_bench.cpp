// SPDX-License-Identifier: GPL-3.0-or-later
// Flicker: how the light of the air changes from frame to frame where the camera stands still, beside a reference that
// moves alike and is computed 8 times as finely, at 2,000 pixels of full HD. 12 frames, 24 per second, in scenes S
// (Sponza-LowPoly) and F (the forest):
//   wind     1 m/s in the air's texture; setting: steps per ray. Reference: 512 steps, of the same noise, whose 256^3
//            texels are what is drawn and no approximation
//   holes    that sway, a turn in 10 s, 30 % of the occluders; setting: texels and lines, 8192 is the default. Reference:
//            8192, and for the default 16384, the most there is (in S)
//   louvre   swings by 10 degrees, half a time per second; setting: method and lines. Reference: EXACT
//   pixels   of each of them, in S: the reference at one ray per pixel against 8 x 8 rays of each pixel
// Counters, percent of the mean light: error; change, RMS difference of one frame and the next; reference_change; excess,
// the first less the second; change_of_error, RMS change of what lies between the two, which is 0 only where all moves
// as it should; worst_change_of_error, its 99.9th percentile; at_<f>_hz, RMS amplitude over time of what changes at this
// frequency (of a Hann window), and reference_at_<f>_hz. fast and reference_fast: share of what changes, above 6 Hz.
#include "support/moving_shots.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <complex>
#include <cstdio>
#include <map>

namespace tyndall::bench {
namespace {
using light_shafts::Config;
using light_shafts::Method;
constexpr int frame_count = 12;
constexpr std::size_t pixel_count = 2000;
using Film = std::vector<std::vector<float>>; ///< By frame and pixel.

struct Case {
    std::string name;
    Motion motion;
    FilmSetting setting, reference;
};

FilmSetting of_steps(std::uint32_t steps, std::uint32_t side = 1) {
    return {.shafts = {.resolution = 2048}, .step_count = steps, .rays_per_side = side};
}
FilmSetting of_lines(Method method, std::uint32_t lines, std::uint32_t side = 1) {
    return {.shafts = {.method = method, .resolution = lines}, .rays_per_side = side};
}

std::vector<Case> cases_of(char scene) {
    const FilmSetting exact = of_lines(Method::Exact, 0), fine = of_lines(Method::ShadowMap, 8192);
    std::vector<Case> cases{
        {"wind/16", Motion::Wind, of_steps(16), of_steps(512)},
        {"wind/64", Motion::Wind, of_steps(64), of_steps(512)},
        {"holes/1024", Motion::Holes, of_lines(Method::ShadowMap, 1024), fine},
        {"holes/2048", Motion::Holes, of_lines(Method::ShadowMap, 2048), fine},
        {"louvre/SHADOW_MAP 2048", Motion::Louvre, of_lines(Method::ShadowMap, 2048), exact},
        {"louvre/EPIPOLAR 2048", Motion::Louvre, of_lines(Method::Epipolar, 2048), exact},
        {"louvre/EPIPOLAR 10000", Motion::Louvre, of_lines(Method::Epipolar, 10000), exact},
    };
    if (scene == 'F') // where a frame of the finest takes many seconds
        return cases;
    cases.push_back({"wind/pixels", Motion::Wind, of_steps(512), of_steps(512, 8)});
    cases.push_back({"holes/8192", Motion::Holes, fine, of_lines(Method::ShadowMap, 16384)});
    cases.push_back({"holes/pixels", Motion::Holes, fine, of_lines(Method::ShadowMap, 8192, 8)});
    cases.push_back({"louvre/pixels", Motion::Louvre, exact, of_lines(Method::Exact, 0, 8)});
    return cases;
}

/// Films that several cases need are kept.
const Film& film(ShaftScene& scene, Motion motion, const FilmSetting& setting) {
    static std::map<std::pair<ShaftScene*, Motion>, std::unique_ptr<MovingShot>> shots;
    std::unique_ptr<MovingShot>& shot = shots[{&scene, motion}];
    if (!shot)
        shot = std::make_unique<MovingShot>(scene, motion, pixel_count);
    using Key = std::tuple<ShaftScene*, Motion, Method, std::uint32_t, std::uint32_t, std::uint32_t>;
    static std::map<Key, Film> films;
    Film& kept = films[{&scene, motion, setting.shafts.method, setting.shafts.resolution, setting.step_count,
                        setting.rays_per_side}];
    for (int frame = static_cast<int>(kept.size()); frame < frame_count; ++frame)
        kept.push_back(shot->picture(frame, setting));
    return kept;
}

/// Root of the mean square over all pixels of `value(pixel, frame)`, frames from `first` on.
template <typename Value>
double root_mean_square(int first, const Value& value) {
    double sum = 0.0;
    for (int frame = first; frame < frame_count; ++frame)
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            sum += value(pixel, static_cast<std::size_t>(frame)) * value(pixel, static_cast<std::size_t>(frame));
    return std::sqrt(sum / (static_cast<double>(frame_count - first) * static_cast<double>(pixel_count)));
}

double change(const Film& of, std::size_t pixel, std::size_t frame) {
    return double{of[frame][pixel]} - double{of[frame - 1][pixel]};
}

/// RMS amplitude over the pixels at k periods per film, k = 1 to frame_count / 2.
std::vector<double> spectrum(const Film& of) {
    constexpr double turn = 2.0 * std::numbers::pi;
    std::vector<double> squares(frame_count / 2, 0.0);
    for (std::size_t pixel = 0; pixel < pixel_count; ++pixel) {
        double mean = 0.0;
        for (const std::vector<float>& picture : of)
            mean += double{picture[pixel]} / frame_count;
        for (int k = 1; k <= frame_count / 2; ++k) {
            std::complex<double> sum = 0.0;
            for (int frame = 0; frame < frame_count; ++frame) {
                const double window = 1.0 - std::cos(turn * (frame + 0.5) / frame_count); // mean 1
                sum += window * (double{of[static_cast<std::size_t>(frame)][pixel]} - mean) *
                       std::polar(1.0, -turn * k * frame / frame_count);
            }
            squares[static_cast<std::size_t>(k - 1)] += std::norm(2.0 / frame_count * sum);
        }
    }
    for (double& value : squares)
        value = std::sqrt(value / static_cast<double>(pixel_count));
    return squares;
}

double share_above_6_hz(const std::vector<double>& amplitudes) {
    double fast = 0.0, all = 0.0;
    for (std::size_t k = 0; k < amplitudes.size(); ++k) {
        const double power = amplitudes[k] * amplitudes[k];
        all += power;
        if ((static_cast<double>(k) + 1.0) * frames_per_s / frame_count > 6.0)
            fast += power;
    }
    return fast / all;
}

void report(benchmark::State& state, const Film& found, const Film& reference) {
    double mean = 0.0;
    for (const std::vector<float>& picture : reference)
        for (const float light : picture)
            mean += double{light} / (static_cast<double>(frame_count) * static_cast<double>(pixel_count));
    const auto count = [&](const std::string& name, double value) { state.counters[name] = 100.0 * value / mean; };
    const double changes = root_mean_square(1, [&](std::size_t p, std::size_t f) { return change(found, p, f); });
    const double due = root_mean_square(1, [&](std::size_t p, std::size_t f) { return change(reference, p, f); });
    const auto change_of_error = [&](std::size_t p, std::size_t f) {
        return change(found, p, f) - change(reference, p, f);
    };
    count("error_percent", root_mean_square(0, [&](std::size_t p, std::size_t f) {
              return double{found[f][p]} - double{reference[f][p]};
          }));
    count("change_percent", changes);
    count("reference_change_percent", due);
    count("excess_percent", changes - due);
    count("change_of_error_percent", root_mean_square(1, change_of_error));
    std::vector<double> all;
    for (std::size_t frame = 1; frame < frame_count; ++frame)
        for (std::size_t pixel = 0; pixel < pixel_count; ++pixel)
            all.push_back(std::abs(change_of_error(pixel, frame)));
    const auto worst = all.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(all.size()));
    std::nth_element(all.begin(), worst, all.end());
    count("worst_change_of_error_percent", *worst);
    const std::vector<double> amplitudes = spectrum(found), due_amplitudes = spectrum(reference);
    state.counters["fast_percent"] = 100.0 * share_above_6_hz(amplitudes);
    state.counters["reference_fast_percent"] = 100.0 * share_above_6_hz(due_amplitudes);
    for (std::size_t k = 0; k < amplitudes.size(); ++k) {
        std::array<char, 32> hertz{};
        std::snprintf(hertz.data(), hertz.size(), "at_%04.1f_hz_percent",
                      (static_cast<double>(k) + 1.0) * frames_per_s / frame_count);
        count(hertz.data(), amplitudes[k]);
        count(std::string("reference_") + hertz.data(), due_amplitudes[k]);
    }
}

const bool is_registered = [] {
    for (const char scene : {'S', 'F'})
        for (const Case& what : cases_of(scene))
            benchmark::RegisterBenchmark(("flicker/" + std::string(1, scene) + "/" + what.name).c_str(),
                                         [=](benchmark::State& state) {
                                             ShaftScene* shafts = scene == 'S' ? sponza_scene() : &forest_scene();
                                             if (!shafts) {
                                                 state.SkipWithError(
                                                     "Sponza-LowPoly is not there: set TYNDALL_SHARED_DATA");
                                                 return;
                                             }
                                             const Film& reference = film(*shafts, what.motion, what.reference);
                                             for (auto _ : state)
                                                 film(*shafts, what.motion, what.setting);
                                             report(state, film(*shafts, what.motion, what.setting), reference);
                                         })
                ->Iterations(1)
                ->Repetitions(1)
                ->UseRealTime()
                ->Unit(benchmark::kSecond);
    return true;
}();
} // namespace
} // namespace tyndall::bench
