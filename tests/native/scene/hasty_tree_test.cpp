// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh whose tree was built in haste shows what any other does, before that is finished and after.
#include "core/errors.hpp"
#include "support/soup.hpp"
#include <doctest/doctest.h>

namespace hasty_tree_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
const Bounds3 box{vec3(-1.0f), vec3(1.0f)};

std::shared_ptr<const TriangleMesh> soup(TreeQuality quality, std::size_t triangle_count) {
    return std::make_shared<const TriangleMesh>(soup_mesh(triangle_count, box, 0.02f, 7)->arrays(), Progress(),
                                                quality);
}

/// Of two panes of the soup, one of them turned and mirrored.
std::unique_ptr<Scene> panes(const std::shared_ptr<const TriangleMesh>& mesh) {
    Material pane{.name = "pane"};
    pane.constant = {.diffuse_albedo = Rgb(0.1f), .transparent = Rgb(0.5f, 0.7f, 0.9f), .emission = Rgb(0.0f)};
    const mat4 turned = glm::scale(glm::rotate(mat4(1.0f), 1.0f, vec3(0.6f, 0.8f, 0.0f)), vec3(1.0f, -2.0f, 1.0f));
    return make_scene({{.mesh = mesh, .material = pane}, {.mesh = mesh, .world_from_object = turned}});
}

/// How many of the rays meet something.
std::size_t check_same(const Scene& scene, const Scene& expected) {
    std::size_t met = 0;
    SceneRandom random(3);
    for (int packet = 0; packet < 100; ++packet) {
        std::vector<Ray> rays(16);
        const vec3 origin = 3.0f * random.direction(), target = 0.5f * random.direction();
        for (Ray& ray : rays)
            ray = {.origin = origin, .direction = glm::normalize(target + 0.1f * random.direction() - origin)};
        std::vector<Hit> hits(rays.size()), expected_hits(rays.size());
        std::vector<Rgb> passing(rays.size()), expected_passing(rays.size());
        scene.closest_hits(rays, hits), expected.closest_hits(rays, expected_hits);
        scene.shadow_transmittances(rays, passing), expected.shadow_transmittances(rays, expected_passing);
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
            CHECK(hits[ray].instance == expected_hits[ray].instance);
            CHECK(hits[ray].triangle == expected_hits[ray].triangle);
            CHECK(hits[ray].distance_m == expected_hits[ray].distance_m);
            CHECK(passing[ray] == expected_passing[ray]);
            CHECK(scene.closest_hit(rays[ray]).distance_m == hits[ray].distance_m);
            met += hits[ray].is_hit();
        }
    }
    return met;
}
} // namespace

// Seen to fail where a cancelled tree is left as it is.
TEST_CASE("rays meet what they meet in any tree: a hasty one, one that was cancelled, one that was finished") {
    const auto expected = panes(soup(TreeQuality::Best, TriangleMesh::fewest_for_haste));
    const auto mesh = soup(TreeQuality::Hasty, TriangleMesh::fewest_for_haste);
    const auto before = panes(mesh);
    REQUIRE(mesh->has_hasty_tree());
    CHECK(check_same(*before, *expected) > 500);
    Progress progress;
    progress.cancel();
    CHECK_THROWS_AS(mesh->finish_tree(progress), Cancelled);
    CHECK(mesh->has_hasty_tree());
    CHECK(check_same(*before, *expected) > 500);
    mesh->finish_tree(Progress());
    CHECK(!mesh->has_hasty_tree());
    CHECK(check_same(*before, *expected) > 500);
    CHECK(check_same(*panes(mesh), *expected) > 500);
    mesh->finish_tree(progress); // nothing is left to be cancelled
}

TEST_CASE("a small mesh has the best tree at once") {
    CHECK(!soup(TreeQuality::Hasty, TriangleMesh::fewest_for_haste - 1)->has_hasty_tree());
}
} // namespace hasty_tree_test
