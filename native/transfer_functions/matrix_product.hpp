// SPDX-License-Identifier: GPL-3.0-or-later
// Products of small matrices, rows after one another.
#pragma once
#include <cstddef>

namespace tyndall::transfer_functions {
/// Values in 64 bytes, the widest vector: the columns of `right` and `product` are a multiple of it.
template <typename Value>
inline constexpr std::size_t values_per_line = 64 / sizeof(Value);

/// product (rows x columns) = left (rows x inner) * right (inner x columns). Overwrites; nothing may overlap.
void multiply(const float* left, const float* right, std::size_t rows, std::size_t inner, std::size_t columns,
              float* product);
void multiply(const double* left, const double* right, std::size_t rows, std::size_t inner, std::size_t columns,
              double* product);
} // namespace tyndall::transfer_functions
