// SPDX-License-Identifier: GPL-3.0-or-later
// Which corner moves a vertex, and normals afterwards: as the rule says it, vertex by vertex, in random soups.
#include "scene/displaced_corners.hpp"
#include <doctest/doctest.h>
#include <memory>
#include <random>

namespace displaced_corners_test {
using namespace tyndall;

namespace {
constexpr std::size_t vertex_count = 60, triangle_count = 90;

struct Soup {
    std::vector<vec3> positions, corner_normals;
    std::vector<uvec3> triangles;
    std::unique_ptr<bool[]> marks = std::make_unique<bool[]>(triangle_count); // NOLINT: a span of bool

    explicit Soup(std::uint32_t seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> one(-1.0f, 1.0f);
        for (std::size_t index = 0; index < vertex_count; ++index)
            positions.emplace_back(one(random), one(random), one(random));
        for (std::size_t index = 0; index < triangle_count; ++index) {
            // A few have no area.
            const auto a = random() % vertex_count, b = random() % vertex_count;
            triangles.emplace_back(a, b, random() % 9 == 0 ? a : random() % vertex_count);
            marks[index] = random() % 3 == 0;
            for (int corner = 0; corner < 3; ++corner)
                corner_normals.push_back(random() % 4 == 0 ? vec3(0.0f) : vec3(0.0f, 0.6f, 0.8f));
        }
    }
    [[nodiscard]] std::span<const bool> marked() const { return {marks.get(), triangle_count}; }
};
} // namespace

TEST_CASE("a vertex is moved by the first corner of a moved triangle") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        const Soup soup(seed);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t vertex = 0; vertex < vertex_count; ++vertex)
            for (std::uint32_t corner = 0; corner < 3 * triangle_count; ++corner)
                if (soup.marks[corner / 3] && soup.triangles[corner / 3][static_cast<int>(corner % 3)] == vertex) {
                    expected.push_back(corner);
                    break;
                }
        CHECK(first_corners(soup.triangles, soup.marked(), vertex_count) == expected);
    }
}

TEST_CASE("normals at renewed triangles are means of theirs, at every corner that is not flat") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        const Soup soup(seed);
        std::vector<vec3> renewed = soup.corner_normals;
        renew_normals(soup.positions, soup.triangles, soup.marked(), renewed, Progress());
        std::size_t changed_count = 0;
        for (std::size_t corner = 0; corner < renewed.size(); ++corner) {
            const auto vertex = soup.triangles[corner / 3][static_cast<int>(corner % 3)];
            dvec3 sum(0.0);
            bool is_around = false;
            for (std::size_t index = 0; index < triangle_count; ++index)
                for (int of = 0; soup.marks[index] && of < 3; ++of)
                    if (soup.triangles[index][of] == vertex) {
                        const uvec3& at = soup.triangles[index];
                        const dvec3 a(soup.positions[at[0]]), b(soup.positions[at[1]]), c(soup.positions[at[2]]);
                        const dvec3 across = glm::cross(b - a, c - a);
                        const double length = glm::length(across);
                        sum += length > 0.0 ? across / length : dvec3(0.0);
                        is_around = true;
                    }
            const vec3 before = soup.corner_normals[corner];
            const double length = glm::length(sum);
            const dvec3 expected = !is_around || before == vec3(0.0f) ? dvec3(before)
                                   : length > 0.0                     ? sum / length
                                                                      : dvec3(0.0);
            CHECK(glm::length(dvec3(renewed[corner]) - expected) < 1e-4);
            changed_count += renewed[corner] != before;
        }
        CHECK(changed_count > triangle_count / 2);
    }
}

TEST_CASE("a triangle without an area, or whose area is no number, has no normal") {
    const std::vector<vec3> positions{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, std::nanf(""), 0}, {0, 1, 0}};
    CHECK(face_normal(positions, {0, 1, 2}) == vec3(0.0f));
    CHECK(face_normal(positions, {0, 1, 3}) == vec3(0.0f));
    CHECK(face_normal(positions, {0, 1, 4}) == vec3(0, 0, 1));
}
} // namespace displaced_corners_test
