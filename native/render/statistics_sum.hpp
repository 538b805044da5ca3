// SPDX-License-Identifier: GPL-3.0-or-later
// Statistics of a frame whose rooms run many times: seconds and counts add up by name, lines appear once.
#pragma once
#include "core/statistics.hpp"

namespace tyndall::render {
void add_up(Statistics& total, const Statistics& part);
} // namespace tyndall::render
