// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/huge_pages.hpp"
#include <cstdint>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace tyndall {
#ifdef __linux__
void prefer_huge_pages(void* memory, std::size_t bytes) {
    // Whole ones alone: what shares a page with other memory stays as it is.
    constexpr std::uintptr_t page = 2 << 20;
    const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + page - 1) / page * page,
               end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / page * page;
    if (begin < end)
        madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE); // refused: small ones
}
#else
void prefer_huge_pages(void*, std::size_t) {}
#endif
} // namespace tyndall
