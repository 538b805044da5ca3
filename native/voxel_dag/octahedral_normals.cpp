// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/octahedral_normals.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include <numbers>

namespace tyndall::voxel_dag::octahedral {
/// Steps from -1 to 1 of each coordinate, even, so that 0 is one.
struct Lattice {
    std::uint32_t v_bits;
    double u_steps, v_steps;
};
static Lattice lattice_of(std::uint32_t bits) {
    const std::uint32_t v_bits = bits / 2, u_bits = bits - v_bits;
    return {v_bits, static_cast<double>((1u << u_bits) - 2), static_cast<double>((1u << v_bits) - 2)};
}

double most_error_degrees(std::uint32_t bits) {
    const Lattice lattice = lattice_of(bits);
    const double a = 2.0 * std::numbers::sqrt2 / lattice.u_steps, b = 2.0 * std::numbers::sqrt2 / lattice.v_steps;
    const double circumradius = std::sqrt((a * a + b * b - a * b) / 3.0);
    return 2.0 * std::atan(0.5 * std::numbers::sqrt3 * circumradius) * 180.0 / std::numbers::pi;
}

/// The lower half is folded outwards over the diagonals, and back by the same formula.
static dvec2 folded(const dvec2& at) {
    return {(1.0 - std::abs(at.y)) * (at.x < 0.0 ? -1.0 : 1.0), (1.0 - std::abs(at.x)) * (at.y < 0.0 ? -1.0 : 1.0)};
}
static dvec3 direction_at(const dvec2& at) {
    const double z = 1.0 - std::abs(at.x) - std::abs(at.y);
    const dvec2 xy = z < 0.0 ? folded(at) : at;
    return glm::normalize(dvec3(xy, z));
}

/// Where the ray of `scaled`, whose sum is finite and not 0, leaves the octahedron, unfolded.
static dvec2 unfolded(const dvec3& scaled) {
    const dvec3 n = scaled / (std::abs(scaled.x) + std::abs(scaled.y) + std::abs(scaled.z));
    return n.z < 0.0 ? folded({n.x, n.y}) : dvec2(n.x, n.y);
}

std::uint32_t encode_rounded(const dvec3& direction) {
    constexpr double steps = (1 << 16) - 2; // both coordinates', see lattice_of()
    const dvec2 at = unfolded(direction);
    const auto rounded = [](double value) { return static_cast<std::uint32_t>((0.5 * value + 0.5) * steps + 0.5); };
    return rounded(at.x) << 16 | rounded(at.y);
}

std::uint32_t encode(const dvec3& direction, std::uint32_t bits) {
    const Lattice lattice = lattice_of(bits);
    // By the largest coordinate first: the sum of three may overflow, and that of three tiny ones may be 0.
    const dvec3 scaled = direction / std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
    const dvec2 at = unfolded(scaled);
    const double u = std::floor((0.5 * at.x + 0.5) * lattice.u_steps);
    const double v = std::floor((0.5 * at.y + 0.5) * lattice.v_steps);
    double most = -2.0;
    std::uint32_t best = 0;
    for (const double du : {0.0, 1.0})
        for (const double dv : {0.0, 1.0}) {
            const double iu = std::clamp(u + du, 0.0, lattice.u_steps), iv = std::clamp(v + dv, 0.0, lattice.v_steps);
            const dvec3 there = direction_at({2.0 * iu / lattice.u_steps - 1.0, 2.0 * iv / lattice.v_steps - 1.0});
            // Cosines near 1 do not tell small angles apart: minus the squared chord does.
            const dvec3 chord = glm::normalize(scaled) - there;
            const double closeness = -glm::dot(chord, chord);
            if (closeness > most || (du == 0.0 && dv == 0.0)) {
                most = closeness;
                best = static_cast<std::uint32_t>(iu) << lattice.v_bits | static_cast<std::uint32_t>(iv);
            }
        }
    return best;
}

dvec3 decode(std::uint32_t code, std::uint32_t bits) {
    const Lattice lattice = lattice_of(bits);
    const std::uint32_t v = code & ((1u << lattice.v_bits) - 1), u = code >> lattice.v_bits;
    // The last code of a coordinate is none of encode()'s: it means the one before.
    return direction_at({2.0 * std::min(static_cast<double>(u), lattice.u_steps) / lattice.u_steps - 1.0,
                         2.0 * std::min(static_cast<double>(v), lattice.v_steps) / lattice.v_steps - 1.0});
}

std::vector<std::uint32_t> encode_all(std::span<const vec3> normals, std::uint32_t bits, const Progress& progress) {
    require(least_bits <= bits && bits <= most_bits, "normals of ", bits, " bits; from ", least_bits, " to ", most_bits,
            " are possible");
    for (std::size_t i = 0; i < normals.size(); ++i)
        require(std::isfinite(glm::dot(dvec3(normals[i]), dvec3(normals[i]))) && normals[i] != vec3(0.0f), "normal ", i,
                " is (", normals[i].x, ", ", normals[i].y, ", ", normals[i].z, "), which is no direction");
    std::vector<std::uint32_t> codes(normals.size());
    parallel_for(
        normals.size(), progress, [&](std::size_t i) { codes[i] = encode(dvec3(normals[i]), bits); }, 4096);
    return codes;
}
} // namespace tyndall::voxel_dag::octahedral
