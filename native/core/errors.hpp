// SPDX-License-Identifier: GPL-3.0-or-later
// The errors that leave the core. Each message names the culprit; bindings translate each type once.
#pragma once
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tyndall {
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};
/// A value, array or scene part that cannot be used. Python: InvalidInput, a ValueError.
class InvalidInput : public Error {
public:
    using Error::Error;
};
/// A file that cannot be read or written. Python: IoError, an OSError.
class IoError : public Error {
public:
    using Error::Error;
};
/// The caller's Progress was cancelled. Python: Cancelled.
class Cancelled : public Error {
public:
    Cancelled() : Error("cancelled") {}
};

/// Throws InvalidInput with the parts written one after another.
template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
    std::ostringstream message;
    (message << ... << parts);
    throw InvalidInput(message.str());
}
template <typename... Parts>
void require(bool condition, const Parts&... parts) {
    if (!condition)
        refuse(parts...);
}
/// Throws unless lowest <= value <= highest; a NaN throws, too.
inline void require_in(float value, float lowest, float highest, std::string_view name) {
    require(lowest <= value && value <= highest, name, " is ", value, ", outside [", lowest, ", ", highest, "]");
}
} // namespace tyndall
