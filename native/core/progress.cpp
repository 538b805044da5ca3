// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/progress.hpp"
#include <algorithm>

namespace tyndall {
void Progress::advance_to(float fraction) {
    const float bounded = std::clamp(fraction, 0.0f, 1.0f);
    float seen = fraction_.load(std::memory_order_relaxed);
    while (seen < bounded && !fraction_.compare_exchange_weak(seen, bounded, std::memory_order_relaxed)) {
    }
}

std::string Progress::message() const {
    const std::scoped_lock lock(message_mutex_);
    return message_;
}

void Progress::set_message(std::string message) {
    const std::scoped_lock lock(message_mutex_);
    message_ = std::move(message);
}

double Progress::elapsed_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

double Progress::remaining_s() const {
    const double done = fraction();
    return done > 0.0 ? elapsed_s() * (1.0 - done) / done : -1.0;
}
} // namespace tyndall
