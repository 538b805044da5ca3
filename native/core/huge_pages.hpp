// SPDX-License-Identifier: GPL-3.0-or-later
// Large tables in large pages, where the system has them: a table of 150 MB that is read here and there otherwise waits for
// its page tables, and a fresh one of 10 MB for thousands of small pages.
#pragma once
#include <cstddef>
#include <vector>

namespace tyndall {
/// Asks for large pages in memory that nothing was written to yet; a hint, without effect where there are none.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// A vector of `size` zeros in such pages.
template <class Value>
[[nodiscard]] std::vector<Value> large_vector(std::size_t size) {
    std::vector<Value> result;
    result.reserve(size);
    prefer_huge_pages(result.data(), size * sizeof(Value));
    result.resize(size);
    return result;
}
} // namespace tyndall
