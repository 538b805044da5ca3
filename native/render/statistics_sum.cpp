// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/statistics_sum.hpp"
#include <algorithm>
#include <functional>
#include <utility>

namespace tyndall::render {
/// The entry whose `key` is that of `wanted`, appended if there is none; true if it was there.
template <typename Entry, typename Key>
static std::pair<Entry&, bool> entry_like(std::vector<Entry>& entries, const Entry& wanted, Key key) {
    const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
        return std::invoke(key, entry) == std::invoke(key, wanted);
    });
    if (found != entries.end())
        return {*found, true};
    entries.push_back(wanted);
    return {entries.back(), false};
}

void add_up(Statistics& total, const Statistics& part) {
    for (const Statistics::Stage& stage : part.stages)
        if (auto [entry, was_there] = entry_like(total.stages, stage, &Statistics::Stage::name); was_there)
            entry.seconds += stage.seconds;
    for (const Statistics::Count& count : part.counts)
        if (auto [entry, was_there] = entry_like(total.counts, count, &Statistics::Count::name); was_there)
            entry.value += count.value;
    for (const Statistics::Skipped& skipped : part.skipped)
        entry_like(total.skipped, skipped, [](const Statistics::Skipped& s) { return std::pair(s.what, s.reason); });
    for (const std::string& line : part.reports)
        entry_like(total.reports, line, [](const std::string& s) { return s; });
}
} // namespace tyndall::render
