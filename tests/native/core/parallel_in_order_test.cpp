// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel_in_order.hpp"
#include <doctest/doctest.h>
#include <numeric>

namespace parallel_in_order_test {
using namespace tyndall;

// Seen to fail with pieces that leave as soon as they are made, and with a slot less than the pieces on the way.
TEST_CASE("pieces are put in order, each with what was made of it, however few slots there are") {
    for (const std::size_t slot_count : {1u, 2u, 5u}) {
        std::vector<std::vector<std::size_t>> slots(slot_count);
        std::vector<std::size_t> put;
        parallel_in_order(
            300, slots, Progress(),
            [](std::size_t index, std::vector<std::size_t>& slot) {
                slot.assign(index % 10 == 0 ? 1000000 : 3, index); // some take far longer than others
            },
            [&](std::size_t index, const std::vector<std::size_t>& slot) {
                CHECK(slot.size() == (index % 10 == 0 ? 1000000 : 3));
                CHECK(slot.back() == index);
                put.push_back(index);
            });
        std::vector<std::size_t> in_order(300);
        std::iota(in_order.begin(), in_order.end(), std::size_t{0});
        CHECK(put == in_order);
    }
}
TEST_CASE("no piece is made once the caller has cancelled") {
    std::vector<int> slots(2);
    Progress progress;
    std::size_t put_count = 0;
    CHECK_THROWS_AS(parallel_in_order(
                        100000, slots, progress, [](std::size_t, int&) {},
                        [&](std::size_t index, int&) {
                            ++put_count;
                            if (index == 10)
                                progress.cancel();
                        }),
                    Cancelled);
    CHECK(put_count < 20);
}
} // namespace parallel_in_order_test
