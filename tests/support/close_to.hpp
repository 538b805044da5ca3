// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers that agree within a share of the larger one. doctest::Approx by itself allows its epsilon of 1, too,
// within which all small numbers agree.
#pragma once
#include <doctest/doctest.h>

namespace tyndall::support {
inline doctest::Approx close_to(double value, double share) {
    return doctest::Approx(value).epsilon(share).scale(1e-9);
}
} // namespace tyndall::support
