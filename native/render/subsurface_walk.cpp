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
//           Walks that count little end by chance. The first scatterings have Sobol points.
// Bound:    a ray through the object per scattering, as long as the free path.
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "render/subsurface_exit.hpp"
#include "shading/lobes/ggx.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tyndall::render {
namespace {
constexpr int anisotropic_steps = 10;    ///< Then the phase is even.
constexpr int exact_steps = 256;         ///< Then free paths grow,
constexpr int steps_per_doubling = 32;   ///< by 2 every so many,
constexpr int most_steps = 1024;         ///< up to 2^24: what is still inside is in no closed object.
constexpr float least_throughput = 0.1f; ///< Of what entered; with less, walks end by chance.
constexpr float least_single_albedo = 0.2f;
constexpr float opposite_reach = 10.0f; ///< Free paths in which the first ray looks for a far side.

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
    const vec3 facet = ggx::sample_visible_normal(view, alpha, u);
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

/// Henyey's and Greenstein's, 1/sr.
float phase(float g, float cosine) {
    const float base = 1.0f + g * g - 2.0f * g * cosine;
    return (1.0f - g * g) / (4.0f * std::numbers::pi_v<float> * base * std::sqrt(base));
}
float sample_phase_cosine(float g, float u) {
    if (std::abs(g) < 1e-3f)
        return 1.0f - 2.0f * u;
    const float ratio = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
    return std::clamp((1.0f + g * g - ratio * ratio) / (2.0f * g), -1.0f, 1.0f);
}
vec3 around(const vec3& axis, float cosine, float u) {
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)), turn = 2.0f * std::numbers::pi_v<float> * u;
    return from_frame(axis, vec3(sine * std::cos(turn), sine * std::sin(turn), cosine));
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

/// What a channel's paths are inside.
struct Inside {
    Rgb sigma_t, single_albedo; ///< 1/m; 0 of channels without a walk.
    float g = 0.0f;
    [[nodiscard]] Rgb sigma_s() const { return sigma_t * single_albedo; }
    /// With an even phase, and as much diffusion.
    [[nodiscard]] Inside similar() const {
        const Rgb reduced = sigma_s() * (1.0f - g), extinction = sigma_t - sigma_s() + reduced;
        Inside even{.sigma_t = extinction, .single_albedo = Rgb(0.0f)};
        for (int channel = 0; channel < 3; ++channel)
            even.single_albedo[channel] = extinction[channel] > 0.0f ? reduced[channel] / extinction[channel] : 0.0f;
        return even;
    }
    /// With free paths twice as long, and as much diffusion.
    [[nodiscard]] Inside coarser() const {
        Inside coarse{.sigma_t = 0.5f * sigma_t, .single_albedo = Rgb(0.0f), .g = g};
        for (int channel = 0; channel < 3; ++channel)
            coarse.single_albedo[channel] = std::max(0.0f, 1.0f - 4.0f * (1.0f - single_albedo[channel]));
        return coarse;
    }
};

class Walk {
public:
    explicit Walk(const SubsurfaceEntry& entry) : entry_(entry), numbers_(entry.random) {
        const Lobe& lobe = entry.lobe;
        inside_.g = lobe.own_alpha;
        inside_.sigma_t = inside_.single_albedo = Rgb(0.0f);
        for (int channel = 0; channel < 3; ++channel) {
            if (!(lobe.weight[channel] > 0.0f) || !(lobe.b[channel] > 0.0f))
                continue;
            float single = subsurface::single_albedo(lobe.b[channel], lobe.own_alpha);
            throughput_[channel] = lobe.weight[channel] / lobe.b[channel];
            if (single < least_single_albedo) { // there guides would point straight at the surface
                throughput_[channel] *= single / least_single_albedo;
                single = least_single_albedo;
            }
            inside_.single_albedo[channel] = single;
            inside_.sigma_t[channel] = 1.0f / (std::max(lobe.a[channel], 1e-16f) * (1.0f - lobe.own_alpha));
        }
        first_throughput_ = largest(throughput_);
        even_ = inside_.similar();
    }

    std::optional<FoundExit> exit() {
        if (!(first_throughput_ > 0.0f))
            return std::nullopt;
        const vec4 entering = numbers_.of_step(0);
        const std::optional<vec3> direction = entry_direction(entry_, vec2(entering));
        if (!direction)
            return std::nullopt;
        const ShadingPoint& shading = entry_.point.shading;
        normal_ = entry_.lobe.has_own_normal() ? entry_.lobe.normal : shading.shading_normal;
        ray_ = {.origin = entry_.point.spawn.towards(*direction), .direction = *direction};
        start_ = ray_.origin;
        const Guide guide(largest(inside_.single_albedo));
        const float g = inside_.g;
        // Where the phase leads ahead, guides that do not know it help little.
        const float guided = g > 0.0f ? 1.0f - std::max(0.5f, std::pow(g, 0.125f)) : 0.5f;
        if (advance_first(vec2(entering.z, entering.w)))
            return found();
        for (std::uint32_t step = 1; step < most_steps; ++step) {
            if (step == anisotropic_steps)
                inside_ = even_;
            if (step >= exact_steps && step % steps_per_doubling == 0)
                inside_ = inside_.coarser();
            const vec4 u = numbers_.of_step(step);
            if (step > 2 && !survives(step))
                return std::nullopt;
            if (advance(guide, step < anisotropic_steps || g == 0.0f ? guided : 0.75f, u))
                return found();
            if (!(largest(throughput_) > 0.0f))
                return std::nullopt;
        }
        return std::nullopt;
    }

private:
    struct Channels {
        Rgb pdf;
        int drawn = 0;
    };
    /// By what each still counts; u is even again within the drawn one.
    [[nodiscard]] Channels draw_channel(float& u) const {
        Channels channels{.pdf = throughput_ * (inside_.single_albedo + 1e-3f)};
        channels.pdf /= channels.pdf.x + channels.pdf.y + channels.pdf.z;
        while (channels.drawn < 2 && u >= channels.pdf[channels.drawn])
            u -= channels.pdf[channels.drawn++];
        while (channels.drawn > 0 && channels.pdf[channels.drawn] <= 0.0f)
            --channels.drawn;
        u = std::min(u / channels.pdf[channels.drawn], 0.99999994f);
        return channels;
    }

    bool survives(std::uint32_t step) {
        const float left = largest(throughput_) / (least_throughput * first_throughput_);
        if (left >= 1.0f)
            return true;
        const std::array<std::uint32_t, 4> bits =
            pcg4d({entry_.random.seed, entry_.random.sample_index, step, 0x656e'6473});
        if (unit_float(bits[0]) >= left)
            return false;
        throughput_ /= left;
        return true;
    }

    /// Up to `distance_m`, or to the surface before it; true: there.
    bool trace(float distance_m, float reach_m) {
        ray_.near_m = 0.0f;
        ray_.far_m = reach_m;
        hit_ = entry_.scene.closest_hit_of(entry_.point.hit.instance, ray_);
        way_m_ = hit_.is_hit() ? std::min(hit_.distance_m, distance_m) : distance_m;
        return hit_.is_hit() && hit_.distance_m < distance_m;
    }
    /// Per channel of the distance that was gone, or that it is at least as long; `stretch` is of extinction.
    [[nodiscard]] Rgb pdf(float stretch, bool is_out) const {
        const Rgb sigma = stretch * inside_.sigma_t, passing = glm::exp(-sigma * way_m_);
        return is_out ? passing : sigma * passing;
    }
    void weigh(const Rgb& channel_pdf, const Rgb& pdf_of_channel, bool is_out) {
        const Rgb passing = glm::exp(-inside_.sigma_t * way_m_);
        const float density = glm::dot(channel_pdf, pdf_of_channel);
        throughput_ *= (is_out ? passing : inside_.sigma_s() * passing) / density;
        if (!(density > 0.0f))
            throughput_ = Rgb(0.0f);
        ray_.origin += way_m_ * ray_.direction;
    }

    /// The direction is known; looks for a far side beyond, too.
    bool advance_first(vec2 u) {
        const Channels channels = draw_channel(u.x);
        const float distance_m = -std::log1p(-u.y) / inside_.sigma_t[channels.drawn];
        float least_sigma = largest(inside_.sigma_t);
        for (int channel = 0; channel < 3; ++channel)
            if (inside_.sigma_t[channel] > 0.0f)
                least_sigma = std::min(least_sigma, inside_.sigma_t[channel]);
        const bool is_out = trace(distance_m, std::max(distance_m, opposite_reach / least_sigma));
        if (hit_.is_hit())
            opposite_m_ = -glm::dot(hit_.distance_m * ray_.direction, normal_);
        weigh(channels.pdf, pdf(1.0f, is_out), is_out);
        return is_out;
    }

    bool advance(const Guide& guide, float guided_share, vec4 u) {
        const Channels channels = draw_channel(u.x);
        float far_share = 0.0f;
        if (opposite_m_ > 0.0f) {
            const float depth_m = std::clamp(-glm::dot(ray_.origin - start_, normal_), 0.0f, opposite_m_);
            const float paths = (opposite_m_ - 2.0f * depth_m) * glm::dot(channels.pdf, inside_.sigma_t);
            far_share = 1.0f / (1.0f + std::exp(std::clamp(paths / guide.length, -40.0f, 40.0f)));
        }
        bool is_guided = false, leads_far = false;
        if (u.x < guided_share) {
            is_guided = true;
            u.x /= guided_share;
            leads_far = u.x < far_share;
        }
        const vec3 before = ray_.direction;
        if (is_guided) {
            const float cosine = guide.sample_cosine(u.z);
            ray_.direction = around(leads_far ? -normal_ : normal_, cosine, u.w);
        } else {
            ray_.direction = around(before, sample_phase_cosine(inside_.g, u.z), u.w);
        }
        const float cosine = glm::dot(ray_.direction, normal_);
        const float near_stretch = guide.stretch(cosine), far_stretch = guide.stretch(-cosine);
        const float stretch = !is_guided ? 1.0f : leads_far ? far_stretch : near_stretch;
        const float distance_m = -std::log1p(-u.y) / (stretch * inside_.sigma_t[channels.drawn]);
        const bool is_out = trace(distance_m, distance_m);
        const float of_phase = phase(inside_.g, glm::dot(before, ray_.direction));
        Rgb guided_pdf = guide.pdf_per_sr(cosine) / of_phase * pdf(near_stretch, is_out);
        if (far_share > 0.0f)
            guided_pdf =
                glm::mix(guided_pdf, guide.pdf_per_sr(-cosine) / of_phase * pdf(far_stretch, is_out), far_share);
        weigh(channels.pdf, glm::mix(pdf(1.0f, is_out), guided_pdf, guided_share), is_out);
        return is_out;
    }

    [[nodiscard]] std::optional<FoundExit> found() const {
        if (!(largest(throughput_) > 0.0f) || !std::isfinite(largest(throughput_)))
            return std::nullopt;
        // As if a ray came from outside.
        return FoundExit{{.origin = ray_.origin + hit_.distance_m * ray_.direction, .direction = -ray_.direction},
                         hit_,
                         throughput_};
    }

    const SubsurfaceEntry& entry_;
    Numbers numbers_;
    Inside inside_, even_;
    Rgb throughput_{0.0f};
    float first_throughput_ = 0.0f;
    Ray ray_{};
    vec3 start_{0.0f}, normal_{0.0f};
    Hit hit_;
    float way_m_ = 0.0f;
    float opposite_m_ = 0.0f; ///< Depth of a far side; 0: there is none near.
};
} // namespace

std::optional<FoundExit> walk_below(const SubsurfaceEntry& entry) { return Walk(entry).exit(); }
} // namespace tyndall::render
