// SPDX-License-Identifier: GPL-3.0-or-later
// What a picture may still take of memory: asked before something large is filled, so that a machine which does not have
// it says so, in place of swapping or of ending the process. Memory that is reserved and not written costs nothing.
#pragma once
#include "core/errors.hpp"
#include <cstddef>
#include <iomanip>
#include <memory>
#include <mutex>

namespace tyndall {
class MemoryRoom {
public:
    explicit MemoryRoom(std::size_t free_bytes) : left_bytes_(free_bytes) {}

    /// Held for as long as what it stands for, which nothing may outlive: it gives the bytes back. `what` takes them, and
    /// `advice` says how it takes less. Throws InvalidInput. Safe from any thread.
    [[nodiscard]] static std::shared_ptr<const void> take(const std::shared_ptr<MemoryRoom>& room, std::size_t bytes,
                                                          const char* what, const char* advice) {
        room->take(bytes, what, advice);
        return {room.get(), [room, bytes](const void*) { room->give_back(bytes); }};
    }

private:
    void take(std::size_t bytes, const char* what, const char* advice) {
        const std::scoped_lock lock(mutex_);
        const auto gib = [](std::size_t count) { return static_cast<double>(count) / double{1 << 30}; };
        require(bytes <= left_bytes_, what, " take ", std::fixed, std::setprecision(1), gib(taken_bytes_ + bytes),
                " GiB of memory at least, and ", gib(taken_bytes_ + left_bytes_), " are free: ", advice);
        left_bytes_ -= bytes;
        taken_bytes_ += bytes;
    }
    void give_back(std::size_t bytes) {
        const std::scoped_lock lock(mutex_);
        left_bytes_ += bytes;
        taken_bytes_ -= bytes;
    }

    std::mutex mutex_;
    std::size_t left_bytes_, taken_bytes_ = 0;
};
} // namespace tyndall
