// SPDX-License-Identifier: GPL-3.0-or-later
// What a long call tells its caller, and how the caller stops it. Safe to read and cancel from any thread.
#pragma once
#include "core/errors.hpp"
#include <atomic>
#include <chrono>
#include <mutex>
#include <string>

namespace tyndall {
class Progress {
public:
    void cancel() { is_cancelled_.store(true, std::memory_order_relaxed); }
    [[nodiscard]] bool is_cancelled() const { return is_cancelled_.load(std::memory_order_relaxed); }
    /// Throws Cancelled after cancel(). Loops call it at least every 50 ms.
    void poll() const {
        if (is_cancelled())
            throw Cancelled();
    }

    /// Share of the whole job that is done, [0, 1]; never goes back.
    [[nodiscard]] float fraction() const { return fraction_.load(std::memory_order_relaxed); }
    void advance_to(float fraction);

    /// The stage at work, for a status bar: "Embree: 1,000,000 triangles".
    [[nodiscard]] std::string message() const;
    void set_message(std::string message);

    [[nodiscard]] double elapsed_s() const;
    /// Elapsed time scaled to what is left; negative while nothing is known yet.
    [[nodiscard]] double remaining_s() const;

private:
    std::atomic<bool> is_cancelled_ = false;
    std::atomic<float> fraction_ = 0.0f;
    mutable std::mutex message_mutex_;
    std::string message_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};
} // namespace tyndall
