// SPDX-License-Identifier: GPL-3.0-or-later
// A random walk below a surface, until it leaves the object.
// Based on: Chiang, Kutz, Burley, Practical and Controllable Subsurface Scattering for Production Path Tracing, SIGGRAPH
//           Talks 2016; Krivanek and d'Eon, A Zero-variance-based Sampling Scheme for Monte Carlo Subsurface Scattering,
//           SIGGRAPH Talks 2014 (directions and distances that lead back, after Dwivedi); Meng, Hanika, Dachsbacher,
//           Improving the Dwivedi Sampling Scheme, EGSR 2016 (eq. 9, 10); d'Eon and Krivanek, Zero-Variance Theory for
//           Efficient Subsurface Scattering, SIGGRAPH 2020 course (eq. 67; towards the far side of what is thin); Wyman,
//           Patterson, Baker, Similarity Relations in Reduced-Memory Monte Carlo Transport, 1989 (after some
//           scatterings the phase is even, and free paths longer).
// Differs:  what is to be found is what Cycles finds (4.5.0, measured in 3.4, 4.5 and 5.0): neither surface has a Fresnel
//           term, the tenth scattering ends the phase's anisotropy. But Cycles ends a walk at its 256th scattering, and
//           loses 6 % of a white object's light: here free paths grow from there on, and absorption with them, so that
//           diffusion stays what it is, and nothing is lost.
//           Each channel has a walk of its own, unless its free paths are another's: one that stands for all three, as
//           theirs does, finds little of those with short paths and dark colours: of a skin this takes 1.6 times as long,
//           with 0.2 (red) to 0.4 (blue) of the variance.
//           Walks that count little end by chance. The first scatterings have Sobol points.
// Bound:    a ray through the object per scattering, as long as the free path; 11 us for the three walks of a skin.
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "render/subsurface_exit.hpp"
#include "shading/lobes/ggx.hpp"
#include "volume/phase_function.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace tyndall::render {
namespace {
constexpr int anisotropic_steps = 10;    ///< Then the phase is even.
constexpr int exact_steps = 256;         ///< Then free paths grow,
constexpr int steps_per_doubling = 32;   ///< by 2 every so many,
constexpr int most_steps = 1024;         ///< up to 2^24: what is still inside is in no closed object.
constexpr float sure_throughput = 0.25f; ///< Of what entered; with less, walks end by chance.
constexpr float least_single_albedo = 0.2f;
constexpr float opposite_paths = 10.0f; ///< In which the first ray looks for a far side.

float largest(const Rgb& value) { return std::max({value.x, value.y, value.z}); }

/// Of what one walk takes: four numbers a step.
class Numbers {
public:
    explicit Numbers(const ProgramRandom& random) : random_(random) {}
    [[nodiscard]] vec4 of_step(std::uint32_t step) const {
        if (step < sobol_steps) {
            const vec2 first = sobol_point(random_.sample_index, hash(random_.seed, 2u * step + 1u));
            const vec2 second = sobol_point(random_.sample_index, hash(random_.seed, 2u * step + 2u));
            return {first, second};
        }
        const std::array<std::uint32_t, 4> bits = pcg4d({random_.seed, random_.sample_index, step, 0x7761'6c6b});
        return {unit_float(bits[0]), unit_float(bits[1]), unit_float(bits[2]), unit_float(bits[3])};
    }

private:
    static constexpr std::uint32_t sobol_steps = 3;
    const ProgramRandom& random_;
};

/// By facets of this width, into the surface.
vec3 refracted(const vec3& outgoing, const vec3& normal, float alpha, float ior, vec2 u) {
    const auto [tangent, bitangent] = orthonormal_basis(normal);
    const vec3 view(glm::dot(outgoing, tangent), glm::dot(outgoing, bitangent), glm::dot(outgoing, normal));
    const vec3 facet = ggx::sample_visible_normal(view, vec2(alpha), u);
    const vec3 half = facet.x * tangent + facet.y * bitangent + facet.z * normal;
    const float ratio = 1.0f / ior, cosine = glm::dot(half, outgoing);
    const float inner = std::sqrt(std::max(1.0f - ratio * ratio * (1.0f - cosine * cosine), 1e-14f));
    return glm::normalize((ratio * cosine - inner) * half - ratio * outgoing);
}

/// Into the surface; nothing where that fails, as in Cycles.
std::optional<vec3> entry_direction(const SubsurfaceEntry& entry, vec2 u) {
    const ShadingPoint& shading = entry.point.shading;
    const vec3 outside = shading.is_backface ? -shading.geometric_normal : shading.geometric_normal;
    const vec3& normal = entry.lobe.has_own_normal() ? entry.lobe.normal : shading.shading_normal;
    bool by_cosine = entry.lobe.subsurface == SubsurfaceMethod::CosineWalk ||
                     entry.lobe.subsurface == SubsurfaceMethod::CosineSkinWalk;
    if (entry.lobe.subsurface == SubsurfaceMethod::SkinWalk) {
        by_cosine = u.x < 0.5f;
        u.x = by_cosine ? 2.0f * u.x : 2.0f * u.x - 1.0f;
    }
    if (!by_cosine && glm::dot(normal, entry.outgoing) <= 0.0f)
        return std::nullopt;
    const vec3 direction = by_cosine ? from_frame(-normal, sample_cosine_hemisphere(u))
                                     : refracted(entry.outgoing, normal, entry.lobe.alpha, entry.lobe.ior, u);
    return glm::dot(direction, outside) < 0.0f ? std::optional(direction) : std::nullopt;
}

/// Of directions that lead towards a plane, for a diffusion length of so many free paths.
struct Guide {
    float length, logarithm;
    explicit Guide(float single_albedo) {
        // Eq. 67 of d'Eon and Krivanek.
        const float power = 2.44294f - 0.0215813f * single_albedo + 0.578637f / single_albedo;
        length = 1.0f / std::sqrt(1.0f - std::pow(single_albedo, power));
        length = std::max(length, 1.0f + 1e-4f);
        logarithm = std::log((length + 1.0f) / (length - 1.0f));
    }
    /// Eq. 9 of Meng et al., 1/sr.
    [[nodiscard]] float pdf_per_sr(float cosine) const {
        return 1.0f / (2.0f * std::numbers::pi_v<float> * (length - cosine) * logarithm);
    }
    [[nodiscard]] float sample_cosine(float u) const {
        return std::clamp(length - (length + 1.0f) * std::exp(-u * logarithm), -1.0f, 1.0f);
    }
    /// Of extinction, so that distances towards the plane are longer.
    [[nodiscard]] float stretch(float cosine) const { return 1.0f - cosine / length; }
};

/// What paths are inside, of channels that have the same free paths.
struct Inside {
    float sigma_t = 0.0f; ///< 1/m.
    Rgb single_albedo{0.0f};
    float g = 0.0f;
    /// With an even phase, and as much diffusion. Where the phase was not even, the channels have one albedo.
    [[nodiscard]] Inside similar() const {
        const float least = 1.0f - largest(single_albedo) * g;
        return {.sigma_t = sigma_t * least, .single_albedo = single_albedo * ((1.0f - g) / least)};
    }
    /// With free paths twice as long, and as much diffusion.
    [[nodiscard]] Inside coarser() const {
        return {.sigma_t = 0.5f * sigma_t,
                .single_albedo = glm::max(Rgb(0.0f), Rgb(1.0f) - 4.0f * (Rgb(1.0f) - single_albedo)),
                .g = g};
    }
};

/// Of channels that have the same free paths.
class Walk {
public:
    /// Throughput: of what enters, and 0 of channels that have other paths.
    Walk(const SubsurfaceEntry& entry, const Inside& inside, const Rgb& throughput)
        : entry_(entry), numbers_(entry.random), inside_(inside), guide_(largest(inside.single_albedo)),
          throughput_(throughput), first_throughput_(largest(throughput)) {}

    [[nodiscard]] std::optional<FoundExit> exit() {
        const vec4 entering = numbers_.of_step(0);
        const std::optional<vec3> direction = entry_direction(entry_, vec2(entering));
        if (!direction)
            return std::nullopt;
        normal_ = entry_.lobe.has_own_normal() ? entry_.lobe.normal : entry_.point.shading.shading_normal;
        ray_ = {.origin = entry_.point.spawn.towards(*direction), .direction = *direction};
        start_ = ray_.origin;
        // Where the phase leads ahead, guides that do not know it help little.
        const float g = inside_.g, guided = g > 0.0f ? 1.0f - std::max(0.5f, std::pow(g, 0.125f)) : 0.5f;
        bool is_out = enter(entering.w);
        for (std::uint32_t step = 1; !is_out && step < most_steps && survives(step); ++step) {
            if (step == anisotropic_steps)
                inside_ = inside_.similar();
            if (step >= exact_steps && step % steps_per_doubling == 0)
                inside_ = inside_.coarser();
            is_out = advance(step < anisotropic_steps || g == 0.0f ? guided : 0.75f, numbers_.of_step(step));
        }
        if (!is_out || !(largest(throughput_) > 0.0f))
            return std::nullopt;
        return FoundExit{
            // as if a ray came from outside
            .from_outside = {.origin = ray_.origin + hit_.distance_m * ray_.direction, .direction = -ray_.direction},
            .hit = hit_,
            .weight = throughput_};
    }

private:
    /// A walk that counts little goes on as often as it counts, and then counts more.
    bool survives(std::uint32_t step) {
        const float left = largest(throughput_) / (sure_throughput * first_throughput_);
        if (left >= 1.0f)
            return true;
        const std::array<std::uint32_t, 4> bits =
            pcg4d({entry_.random.seed, entry_.random.sample_index, step, 0x656e'6473});
        if (!(unit_float(bits[0]) < left))
            return false;
        throughput_ /= left;
        return true;
    }

    void trace(float far_m) {
        ray_.near_m = 0.0f;
        ray_.far_m = far_m;
        hit_ = entry_.scene.closest_hit_of(entry_.point.hit.instance, ray_);
    }
    /// By `stretch` times the extinction.
    [[nodiscard]] float draw_way_m(float stretch, float u) const {
        return -std::log1p(-u) / (stretch * inside_.sigma_t);
    }
    /// Of a way so drawn, 1/m; or that it is at least as long.
    [[nodiscard]] float pdf(float stretch, float way_m, bool is_out) const {
        const float sigma = stretch * inside_.sigma_t;
        return (is_out ? 1.0f : sigma) * std::exp(-sigma * way_m);
    }
    void go(float way_m, bool is_out, float pdf) {
        const float passing = std::exp(-inside_.sigma_t * way_m);
        throughput_ *= is_out ? Rgb(passing / pdf) : inside_.single_albedo * (inside_.sigma_t * passing / pdf);
        if (!(pdf > 0.0f) || !std::isfinite(largest(throughput_)))
            throughput_ = Rgb(0.0f);
        ray_.origin += way_m * ray_.direction;
    }

    /// The direction is known; looks for a far side beyond the way, too. True: it left the object.
    bool enter(float u) {
        const float way_m = draw_way_m(1.0f, u);
        trace(std::max(way_m, opposite_paths / inside_.sigma_t));
        if (hit_.is_hit())
            opposite_m_ = -glm::dot(hit_.distance_m * ray_.direction, normal_);
        const bool is_out = hit_.is_hit() && hit_.distance_m < way_m;
        const float gone_m = is_out ? hit_.distance_m : way_m;
        go(gone_m, is_out, pdf(1.0f, gone_m, is_out));
        return is_out;
    }

    bool advance(float guided_share, vec4 u) {
        float far_share = 0.0f;
        if (opposite_m_ > 0.0f) {
            const float depth_m = std::clamp(-glm::dot(ray_.origin - start_, normal_), 0.0f, opposite_m_);
            const float paths = (opposite_m_ - 2.0f * depth_m) * inside_.sigma_t;
            far_share = 1.0f / (1.0f + std::exp(std::clamp(paths / guide_.length, -40.0f, 40.0f)));
        }
        // By the phase, towards the surface, towards the far side: one is drawn, and all three are weighed.
        std::array<float, 3> share{1.0f - guided_share, guided_share * (1.0f - far_share), guided_share * far_share};
        std::size_t drawn = 0;
        while (drawn < 2 && u.x >= share[drawn])
            u.x -= share[drawn++];
        const vec3 before = ray_.direction;
        ray_.direction = drawn == 0 ? direction_around(before, sample_henyey_greenstein_cosine(inside_.g, u.z), u.w)
                                    : direction_around(drawn == 1 ? normal_ : -normal_, guide_.sample_cosine(u.z), u.w);
        const float cosine = glm::dot(ray_.direction, normal_);
        const float of_phase = henyey_greenstein_per_sr(glm::dot(before, ray_.direction), inside_.g);
        share[1] *= guide_.pdf_per_sr(cosine) / of_phase;
        share[2] *= guide_.pdf_per_sr(-cosine) / of_phase;
        const std::array<float, 3> stretch{1.0f, guide_.stretch(cosine), guide_.stretch(-cosine)};
        const float way_m = draw_way_m(stretch[drawn], u.y);
        trace(way_m);
        const bool is_out = hit_.is_hit();
        const float gone_m = is_out ? hit_.distance_m : way_m;
        float sum = 0.0f;
        for (std::size_t way = 0; way < 3; ++way)
            if (share[way] > 0.0f)
                sum += share[way] * pdf(stretch[way], gone_m, is_out);
        go(gone_m, is_out, sum);
        return is_out;
    }

    const SubsurfaceEntry& entry_;
    Numbers numbers_;
    Inside inside_;
    Guide guide_;
    Rgb throughput_;
    float first_throughput_;
    Ray ray_{};
    vec3 start_{0.0f}, normal_{0.0f};
    Hit hit_;
    float opposite_m_ = 0.0f; ///< Depth of a far side; 0: there is none near.
};
} // namespace

FoundExits walk_below(const SubsurfaceEntry& entry) {
    const Lobe& lobe = entry.lobe;
    FoundExits found;
    std::array<bool, 3> has_walked{};
    for (int channel = 0; channel < 3; ++channel) {
        Inside inside{.sigma_t = 1.0f / (std::max(lobe.a[channel], 1e-16f) * (1.0f - lobe.own_alpha)),
                      .g = lobe.own_alpha};
        Rgb throughput(0.0f);
        for (int other = channel; other < 3; ++other) {
            const bool is_alike =
                lobe.a[other] == lobe.a[channel] && (lobe.own_alpha == 0.0f || lobe.b[other] == lobe.b[channel]);
            bool& is_done = has_walked[static_cast<std::size_t>(other)];
            if (is_done || !is_alike || !(lobe.weight[other] > 0.0f) || !(lobe.b[other] > 0.0f))
                continue;
            is_done = true;
            const float single = subsurface::single_albedo(lobe.b[other], lobe.own_alpha);
            // There guides would point straight at the surface.
            inside.single_albedo[other] = std::max(single, least_single_albedo);
            throughput[other] = lobe.weight[other] / lobe.b[other] * std::min(single / least_single_albedo, 1.0f);
        }
        if (!(largest(throughput) > 0.0f))
            continue;
        if (const std::optional<FoundExit> exit = Walk(entry, inside, throughput).exit())
            found.each[found.count++] = *exit;
    }
    return found;
}
} // namespace tyndall::render
