// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

namespace tyndall::support {
/// Root of the mean square of the differences, over the mean of the truth.
inline double relative_rmse(const std::vector<double>& values, const std::vector<double>& truth) {
    double square_sum = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        square_sum += (values[i] - truth[i]) * (values[i] - truth[i]);
        sum += truth[i];
    }
    return std::sqrt(square_sum * static_cast<double>(values.size())) / sum;
}
} // namespace tyndall::support
