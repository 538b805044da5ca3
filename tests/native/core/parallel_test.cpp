// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "core/ragged_span.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <thread>

namespace parallel_test {
using namespace tyndall;

// Seen to fail with the block size derived from the number of threads.
TEST_CASE("a sum of floats has the same bits for any number of threads") {
    const Progress progress;
    const auto sum = [&](int thread_count) {
        return with_threads(thread_count, [&] {
            return parallel_sum(1 << 20, 1000, 0.0f, progress, [](std::size_t begin, std::size_t end) {
                float block = 0.0f;
                for (std::size_t index = begin; index < end; ++index)
                    block += std::sin(static_cast<float>(index));
                return block;
            });
        });
    };
    const float one_thread = sum(1);
    for (const int thread_count : {2, 3, 7, 0})
        CHECK(sum(thread_count) == one_thread);
}
TEST_CASE("every index is visited exactly once, also where the last block is short or there is none") {
    const Progress progress;
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{256}, std::size_t{1001}}) {
        std::vector<int> visits(count);
        parallel_for(count, progress, [&](std::size_t index) { ++visits[index]; });
        CHECK(std::all_of(visits.begin(), visits.end(), [](int visit) { return visit == 1; }));
    }
}
TEST_CASE("a loop that is cancelled from another thread throws Cancelled and leaves blocks undone") {
    Progress progress;
    std::atomic<std::size_t> done = 0;
    std::thread artist([&] {
        while (done == 0)
            std::this_thread::yield();
        progress.cancel();
    });
    const auto endless = [&] {
        parallel_for(
            std::size_t{1} << 40, progress, [&](std::size_t) { ++done; }, 1024);
    };
    CHECK_THROWS_AS(endless(), Cancelled);
    artist.join();
    CHECK(done < std::size_t{1} << 40);
}
TEST_CASE("progress never goes back, and knows the time left once something is done") {
    Progress progress;
    CHECK(progress.remaining_s() < 0.0);
    progress.advance_to(0.5f);
    progress.advance_to(0.25f);
    CHECK(progress.fraction() == 0.5f);
    progress.advance_to(7.0f);
    CHECK(progress.fraction() == 1.0f);
    CHECK(progress.remaining_s() == 0.0);
    progress.set_message("tracing");
    CHECK(progress.message() == "tracing");
}
TEST_CASE("ragged rows are checked once, when they are made") {
    std::array<int, 5> items{1, 2, 3, 4, 5};
    const std::array<std::uint32_t, 4> first{0, 2, 2, 5};
    const RaggedSpan<int> rows(first, items);
    CHECK(rows.size() == 3);
    CHECK(rows[0].size() == 2);
    CHECK(rows[1].empty());
    CHECK(rows[2].back() == 5);
    const std::array<std::uint32_t, 3> falling{0, 3, 2}, too_short{0, 2, 4}, late{1, 2, 5};
    CHECK_THROWS_AS((RaggedSpan<int>(too_short, items)), InvalidInput);
    CHECK_THROWS_AS((RaggedSpan<int>(late, items)), InvalidInput);
    CHECK_THROWS_WITH_AS((RaggedSpan<int>(falling, std::span(items).first(2))), "row 1 ends before it begins",
                         InvalidInput);
}
TEST_CASE("a value out of range is named, and a NaN is out of every range") {
    CHECK_THROWS_WITH_AS(require_in(2.0f, 0.0f, 1.0f, "albedo"), "albedo is 2, outside [0, 1]", InvalidInput);
    CHECK_THROWS_AS(require_in(std::nanf(""), 0.0f, 1.0f, "albedo"), InvalidInput);
    CHECK_NOTHROW(require_in(1.0f, 0.0f, 1.0f, "albedo"));
}
} // namespace parallel_test
