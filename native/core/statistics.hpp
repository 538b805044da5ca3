// SPDX-License-Identifier: GPL-3.0-or-later
// What a frame did, what it skipped and why, and what the artist should know. Shown in the add-on and written as JSON.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tyndall {
struct Statistics {
    struct Stage {
        std::string name;
        double seconds;
    };
    struct Skipped {
        std::string what;   ///< "light shafts"
        std::string reason; ///< "no medium in the scene"
    };
    struct Count {
        std::string name;
        double value;
    };
    std::vector<Stage> stages; ///< In the order they ended.
    std::vector<Skipped> skipped;
    std::vector<Count> counts;
    std::vector<std::string> reports; ///< One line each, naming the culprit and what was done instead.

    void skip(std::string what, std::string reason) { skipped.push_back({std::move(what), std::move(reason)}); }
    void report(std::string line) { reports.push_back(std::move(line)); }
    void count(std::string name, double value) { counts.push_back({std::move(name), value}); }
    void append(const Statistics& other) {
        stages.insert(stages.end(), other.stages.begin(), other.stages.end());
        skipped.insert(skipped.end(), other.skipped.begin(), other.skipped.end());
        counts.insert(counts.end(), other.counts.begin(), other.counts.end());
        reports.insert(reports.end(), other.reports.begin(), other.reports.end());
    }
};

/// Times one stage from construction to destruction.
class StageTimer {
public:
    StageTimer(Statistics& statistics, std::string name) : statistics_(statistics), name_(std::move(name)) {}
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;
    ~StageTimer() {
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
        statistics_.stages.push_back({std::move(name_), elapsed.count()});
    }

private:
    Statistics& statistics_;
    std::string name_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};
} // namespace tyndall
