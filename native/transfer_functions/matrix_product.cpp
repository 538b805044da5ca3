// SPDX-License-Identifier: GPL-3.0-or-later
#include "transfer_functions/matrix_product.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "transfer_functions/matrix_product.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::transfer_functions::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Of `tile` rows: one vector of `right` is loaded for all of them, and their sums hide one another's latency.
template <std::size_t tile, typename Value>
static HWY_INLINE void multiply_rows(const Value* left, const Value* right, std::size_t inner, std::size_t columns,
                                     Value* product) {
    const hn::CappedTag<Value, values_per_line<Value>> d;
    using V = hn::Vec<decltype(d)>;
    for (std::size_t column = 0; column < columns; column += hn::Lanes(d)) {
        V sum[tile];
        for (V& of_row : sum)
            of_row = hn::Zero(d);
        for (std::size_t i = 0; i < inner; ++i) {
            const V factor = hn::LoadU(d, right + i * columns + column);
            for (std::size_t row = 0; row < tile; ++row)
                sum[row] = hn::MulAdd(hn::Set(d, left[row * inner + i]), factor, sum[row]);
        }
        for (std::size_t row = 0; row < tile; ++row)
            hn::StoreU(sum[row], d, product + row * columns + column);
    }
}

template <typename Value>
static void multiply_of(const Value* left, const Value* right, std::size_t rows, std::size_t inner, std::size_t columns,
                        Value* product) {
    std::size_t row = 0;
    for (; row + 8 <= rows; row += 8)
        multiply_rows<8>(left + row * inner, right, inner, columns, product + row * columns);
    for (; row + 4 <= rows; row += 4)
        multiply_rows<4>(left + row * inner, right, inner, columns, product + row * columns);
    for (; row < rows; ++row)
        multiply_rows<1>(left + row * inner, right, inner, columns, product + row * columns);
}
void multiply_floats(const float* left, const float* right, std::size_t rows, std::size_t inner, std::size_t columns,
                     float* product) {
    multiply_of(left, right, rows, inner, columns, product);
}
void multiply_doubles(const double* left, const double* right, std::size_t rows, std::size_t inner, std::size_t columns,
                      double* product) {
    multiply_of(left, right, rows, inner, columns, product);
}
} // namespace tyndall::transfer_functions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::transfer_functions {
HWY_EXPORT(multiply_floats);
HWY_EXPORT(multiply_doubles);

void multiply(const float* left, const float* right, std::size_t rows, std::size_t inner, std::size_t columns,
              float* product) {
    HWY_DYNAMIC_DISPATCH(multiply_floats)(left, right, rows, inner, columns, product);
}
void multiply(const double* left, const double* right, std::size_t rows, std::size_t inner, std::size_t columns,
              double* product) {
    HWY_DYNAMIC_DISPATCH(multiply_doubles)(left, right, rows, inner, columns, product);
}
} // namespace tyndall::transfer_functions
#endif
