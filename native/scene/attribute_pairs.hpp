// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of surfaces, as colours are, for programs that read them: two UV maps each, of red and green, and of blue and
// alpha, under names that no UV map has. A number is a colour of three equal channels.
#pragma once
#include <string_view>

namespace tyndall::attribute_pairs {
inline constexpr std::string_view mark = "\x1f", red_green = "\x1frg ",
                                  blue_alpha = "\x1f"
                                               "ba ";

/// Whether a map is what a program asks for: by its name; by none, a UV map; by one of the beginnings, that pair of
/// whatever attribute.
[[nodiscard]] inline bool answers(std::string_view map, std::string_view asked) {
    if (asked.empty())
        return !map.starts_with(mark);
    if (asked == red_green || asked == blue_alpha)
        return map.starts_with(asked);
    return map == asked;
}
} // namespace tyndall::attribute_pairs
