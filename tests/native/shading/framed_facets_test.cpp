// SPDX-License-Identifier: GPL-3.0-or-later
// Facets that are wider along one direction than across it, and those of Beckmann and of Ashikhmin and Shirley: closed forms,
// the same both ways, drawn from as their densities say, and those of one width where both are the same.
#include "core/random.hpp"
#include "shading/lobes/ashikhmin_shirley.hpp"
#include "shading/lobes/beckmann.hpp"
#include "shading/lobes/framed_facets.hpp"
#include "shading/lobes/ggx_energy.hpp"
#include "shading/lobes/lobe_models.hpp"
#include "shading/lobes/lobe_set.hpp"
#include "shading/material.hpp"
#include "support/angles.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace framed_facets_test {
using namespace tyndall;
using support::at_angle;
using tyndall::support::close_to;
using Kind = Lobe::Kind;

namespace {
constexpr Kind kinds[] = {Kind::GgxAlongTangent, Kind::Beckmann, Kind::AshikhminShirley};
const vec3 up(0, 0, 1);

vec2 number(std::uint32_t index) {
    const auto unit = [](std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; };
    return {unit(hash(1, index)), unit(hash(2, index))};
}
/// White, of these widths along an axis that is turned by `turn` from x, and across it.
Lobe facets(Kind kind, float along, float across, float turn = 0.0f) {
    return {.kind = kind,
            .alpha = std::sqrt(along * across),
            .own_alpha = std::sqrt(along * across),
            .sampling = 1.0f,
            .weight = Rgb(1.0f),
            .tangent = std::sqrt(along / across) * vec3(std::cos(turn), std::sin(turn), 0.0f)};
}
LobeSet seen(const Lobe& lobe, const vec3& outgoing) {
    return {.lobes = {&lobe, 1}, .normal = up, .outgoing = outgoing};
}

/// Directions above the horizon, or all, in cells of cosine and azimuth: how many a density promises and how many come.
struct Cells {
    static constexpr int rows = 12, columns = 8, fine = 48;
    static constexpr std::uint32_t count = 100'000;
    std::vector<double> promised = std::vector<double>(rows * columns), drawn = promised;

    Cells(const LobeSet& set, float lowest) {
        const double height = 1.0 - static_cast<double>(lowest);
        for (int row = 0; row < rows * fine; ++row)
            for (int column = 0; column < columns * fine; ++column) {
                const double cosine = 1.0 - height * (row + 0.5) / (rows * fine);
                const double around = 2.0 * std::numbers::pi * (column + 0.5) / (columns * fine);
                const double sine = std::sqrt(1.0 - cosine * cosine);
                const vec3 direction(sine * std::cos(around), sine * std::sin(around), cosine);
                promised[static_cast<std::size_t>(row / fine * columns + column / fine)] +=
                    set.pdf_per_sr(direction) * count * height * 2.0 * std::numbers::pi /
                    (rows * fine * columns * fine);
            }
        for (std::uint32_t index = 0; index < count; ++index) {
            const vec3 direction = set.sample(number(index));
            if (direction.z <= lowest)
                continue;
            double around = std::atan2(direction.y, direction.x) / (2.0 * std::numbers::pi);
            around -= std::floor(around);
            const int row = std::min(rows - 1, static_cast<int>((1.0 - direction.z) / height * rows));
            drawn[static_cast<std::size_t>(row * columns +
                                           std::min(columns - 1, static_cast<int>(around * columns)))] += 1.0;
        }
    }
    static double share(const std::vector<double>& of) {
        double sum = 0.0;
        for (const double cell : of)
            sum += cell;
        return sum / count;
    }
};

Lobes built(const LobeSource& source, const std::vector<Rgb>& inputs, const LobeNormals& normals) {
    LobeInputs values{};
    std::ranges::copy(inputs, values.begin());
    ShadingPoint point;
    point.view_cosine = normals.outgoing.z;
    SurfaceClosures closures;
    Lobes lobes;
    add_lobes(source, values, point, closures, &lobes, normals);
    return lobes;
}
} // namespace

TEST_CASE("the error function's inverse gives back what it was made of") {
    for (const float y : {-0.9999f, -0.99f, -0.7f, -0.1f, 1e-4f, 0.3f, 0.84f, 0.995f, 0.99999f})
        CHECK(std::abs(std::erf(double{beckmann::inverse_erf(y)}) / double{y} - 1.0) < 1e-6);
}

// Seen to fail with the fit of Lambda that Walter gives, with one step of Newton, and with the angle of Ashikhmin and
// Shirley drawn evenly.
TEST_CASE("every facet that is seen mirrors one direction, and directions come as often as densities say") {
    for (const Kind kind : kinds)
        for (const vec2 alpha : {vec2(0.6f, 0.15f), vec2(0.2f, 0.8f), vec2(0.35f, 0.35f)})
            for (const float degrees : {0.0f, 50.0f, 80.0f}) {
                CAPTURE(static_cast<int>(kind));
                CAPTURE(alpha.x);
                CAPTURE(degrees);
                Lobe lobe = facets(kind, alpha.x, alpha.y, 0.5f);
                if (alpha.x == alpha.y)
                    lobe.tangent = vec3(0.0f);
                const LobeSet set = seen(lobe, at_angle(degrees, 2.0f));
                // Half vectors of Ashikhmin and Shirley may be turned away from the viewer: those go below.
                const Cells cells(set, kind == Kind::AshikhminShirley ? 0.0f : -1.0f);
                if (kind != Kind::AshikhminShirley)
                    CHECK(Cells::share(cells.promised) == close_to(1.0, 5e-4));
                CHECK(Cells::share(cells.drawn) == close_to(Cells::share(cells.promised), 0.01));
                CHECK(support::is_plausible(support::chi_square_p_value(cells.drawn, cells.promised), 27));
            }
}

// Seen to fail with both widths exchanged.
TEST_CASE("facets that lean along the tangent are those of the width along it") {
    constexpr std::uint32_t count = 40'000;
    const vec2 alpha(0.4f, 0.1f);
    for (const Kind kind : kinds) {
        CAPTURE(static_cast<int>(kind));
        const Lobe lobe = facets(kind, alpha.x, alpha.y, 0.7f);
        const vec3 along = glm::normalize(lobe.tangent), across = glm::cross(up, along);
        dvec2 squares(0.0), within(0.0);
        for (std::uint32_t index = 0; index < count; ++index) {
            const vec3 facet = framed_facets::sample_normal(lobe, up, up, number(index));
            const dvec2 slope(glm::dot(facet, along) / facet.z, glm::dot(facet, across) / facet.z);
            squares += slope * slope / double{count};
            for (int axis = 0; axis < 2; ++axis)
                within[axis] += std::abs(slope[axis]) < double{alpha[axis]} / std::numbers::sqrt3 ? 1.0 / count : 0.0;
        }
        for (int axis = 0; axis < 2; ++axis) {
            CAPTURE(axis);
            if (kind == Kind::Beckmann) // a normal distribution of this variance
                CHECK(squares[axis] == close_to(0.5 * alpha[axis] * alpha[axis], 0.02));
            if (kind == Kind::GgxAlongTangent) // one of Student's, with two degrees of freedom: half of it is within
                CHECK(within[axis] == close_to(0.5, 0.02));
        }
        if (kind == Kind::AshikhminShirley)
            CHECK(squares.x > 10.0 * squares.y);
    }
}

TEST_CASE("what comes back straight from above is the density of facets there, of both widths") {
    for (const vec2 alpha : {vec2(0.3f, 0.3f), vec2(0.5f, 0.02f), vec2(0.004f, 0.9f)}) {
        CAPTURE(alpha.x);
        const double exact = 0.25 / (std::numbers::pi * alpha.x * alpha.y);
        for (const Kind kind : {Kind::GgxAlongTangent, Kind::Beckmann})
            CHECK(seen(facets(kind, alpha.x, alpha.y), up).per_irradiance(up).x == close_to(exact, 1e-5));
        const double phong =
            std::sqrt((2.0 / (alpha.x * alpha.x) - 1.0) * (2.0 / (alpha.y * alpha.y) - 1.0)) / (8.0 * std::numbers::pi);
        CHECK(seen(facets(Kind::AshikhminShirley, alpha.x, alpha.y), up).per_irradiance(up).x == close_to(phong, 1e-4));
    }
}

TEST_CASE("light that goes the other way is reflected as much, and none is made") {
    for (const Kind kind : kinds)
        for (const bool is_separable : {false, true}) {
            CAPTURE(static_cast<int>(kind));
            Lobe lobe = facets(kind, 0.5f, 0.1f, 1.0f);
            lobe.is_separable = is_separable;
            for (std::uint32_t index = 0; index < 50; ++index) {
                const vec3 a = sample_uniform_cone(number(2 * index), 0.98f),
                           b = sample_uniform_cone(number(2 * index + 1), 0.98f);
                CHECK(seen(lobe, a).per_irradiance(b).x == close_to(seen(lobe, b).per_irradiance(a).x, 1e-4));
            }
            for (const float degrees : {0.0f, 45.0f, 80.0f}) {
                const LobeSet set = seen(lobe, at_angle(degrees, 0.3f));
                double albedo = 0.0;
                constexpr std::uint32_t count = 20'000;
                for (std::uint32_t index = 0; index < count; ++index) {
                    const vec3 direction = set.sample(number(index));
                    if (direction.z > 0.0f)
                        albedo += set.per_irradiance(direction).x * direction.z / set.pdf_per_sr(direction) / count;
                }
                CHECK(albedo < 1.0 + 1e-4);
                CHECK(albedo > 0.5);
            }
        }
}

TEST_CASE("facets of two widths that are the same are those of one") {
    for (const float alpha : {0.02f, 0.3f, 1.0f})
        for (std::uint32_t index = 0; index < 50; ++index) {
            CAPTURE(alpha);
            const Lobe one{.kind = Kind::Ggx, .alpha = alpha, .sampling = 1.0f, .weight = Rgb(1.0f)};
            const Lobe two = facets(Kind::GgxAlongTangent, alpha, alpha, 0.4f);
            const vec3 outgoing = sample_uniform_cone(number(2 * index), 0.95f);
            const LobeSet by_one = seen(one, outgoing), by_two = seen(two, outgoing);
            const vec3 incoming = by_two.sample(number(2 * index + 1));
            if (incoming.z <= 0.01f)
                continue;
            CHECK(by_two.per_irradiance(incoming).x == close_to(by_one.per_irradiance(incoming).x, 2e-4));
            CHECK(by_two.pdf_per_sr(incoming) == close_to(by_one.pdf_per_sr(incoming), 2e-4));
        }
}

TEST_CASE("no direction of GGX and Beckmann is denser than the bound") {
    for (const Kind kind : {Kind::GgxAlongTangent, Kind::Beckmann})
        for (const vec2 alpha : {vec2(0.05f, 0.3f), vec2(1.0f, 0.2f), vec2(0.9f, 0.9f)})
            for (const float degrees : {0.0f, 60.0f, 89.0f}) {
                CAPTURE(static_cast<int>(kind));
                CAPTURE(alpha.x);
                CAPTURE(degrees);
                const Lobe lobe = facets(kind, alpha.x, alpha.y);
                const LobeSet set = seen(lobe, at_angle(degrees, 1.0f));
                const float most = framed_facets::most_pdf_per_sr(lobe, up, set.outgoing) * 1.0001f;
                float found = 0.0f;
                for (std::uint32_t index = 0; index < 2000; ++index)
                    found = std::max(found, set.pdf_per_sr(set.sample(number(index))));
                CHECK(found <= most);
                CHECK(found > 0.3f * most);
            }
}

TEST_CASE(
    "a tangent widens facets along it, none beyond 1, and where it is no direction across the normal, not at all") {
    const LobeSource glossy{.model = LobeModel::Glossy};
    const std::vector<Rgb> inputs{Rgb(1.0f), Rgb(1.0f), Rgb(0.5f)};
    const Lobe plain = built(glossy, inputs, {}).at(0);
    CHECK_FALSE(plain.is_anisotropic());
    // It leans towards the normal, which takes nothing from its length.
    const Lobe wide = built(glossy, inputs, {.tangent = 2.0f * glm::normalize(vec3(0, 3, 4))}).at(0);
    CHECK(wide.kind == Kind::GgxAlongTangent);
    CHECK(glm::length(wide.tangent - vec3(0, 2, 0)) < 1e-5f);
    CHECK(wide.alpha == close_to(0.25f, 1e-5));
    const Lobe clamped = built(glossy, inputs, {.tangent = vec3(10, 0, 0)}).at(0); // of 2.5 and 0.025
    CHECK(clamped.alpha == close_to(std::sqrt(0.025f), 1e-5));
    CHECK(clamped.tangent.x == close_to(1.0 / std::sqrt(0.025), 1e-5));
    for (const vec3& none : {vec3(0, 0, 3), vec3(1, 0, 0), vec3(NAN, 1, 0), vec3(INFINITY, 0, 0)})
        CHECK_FALSE(built(glossy, inputs, {.tangent = none}).at(0).is_anisotropic());
    const vec3 own = at_angle(30.0f);
    const Lobe bent = built(glossy, inputs, {.facets = own, .tangent = vec3(2, 0, 0)}).at(0);
    CHECK(std::abs(glm::dot(bent.tangent, own)) < 1e-6f);
    CHECK(glm::length(bent.tangent) == close_to(2.0f, 1e-5));
    // Tables know them by the root of both widths.
    const LobeSource whole{.model = LobeModel::Glossy, .preserves_energy = true};
    const LobeNormals tilted{.outgoing = at_angle(60.0f), .tangent = vec3(10, 0, 0)};
    CHECK(built(whole, inputs, tilted).at(0).weight.x ==
          close_to(1.0f / ggx::albedo(std::sqrt(clamped.alpha), 0.5f).seen, 1e-5));
}

TEST_CASE("what Cycles takes for a mirror shows no light without a size") {
    for (const Kind kind : kinds) {
        CAPTURE(static_cast<int>(kind));
        Lobe lobe = facets(kind, 1e-3f, 1e-3f);
        lobe.tangent = vec3(0.0f);
        const LobeSet set = seen(lobe, at_angle(20.0f));
        lobe.own_alpha = kind == Kind::AshikhminShirley ? 1e-4f : 1e-5f;
        CHECK(set.per_irradiance_of_point(at_angle(-20.0f)).x == 0.0f);
        lobe.own_alpha = kind == Kind::AshikhminShirley ? 1.1e-4f : 2e-5f;
        CHECK(set.per_irradiance_of_point(at_angle(-20.0f)).x > set.per_irradiance(at_angle(-20.0f)).x);
    }
}

TEST_CASE("a distribution that a model does not have is named") {
    LobeSource source{.model = LobeModel::Glossy, .distribution = FacetDistribution::Beckmann};
    source.constants.resize(3);
    source.registers.assign(3, LobeSource::no_register);
    CHECK_NOTHROW(validate(source, "Steel"));
    source.distribution = FacetDistribution::Count;
    CHECK_THROWS_WITH(validate(source, "Steel"),
                      "material \"Steel\" has a distribution 3 of facets, which its model 4 does not know");
    source.model = LobeModel::Sheen;
    source.distribution = FacetDistribution::Beckmann;
    CHECK_THROWS_WITH(validate(source, "Steel"),
                      "material \"Steel\" has a distribution 1 of facets, which its model 16 does not know");
}
} // namespace framed_facets_test
