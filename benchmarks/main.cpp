// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the benchmarks of an executable, as Google Benchmark's own main does, and beyond it:
//   --simd=AVX-512,AVX2   each benchmark on each of these instruction sets; their names become parts of its name
//   --rounds=N            all of that N times, in turn: what else the machine does meets all of them alike
// --benchmark_out is written at the end, with all that benchmarks have added to its context.
#include "core/simd.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <charconv>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string_view>

namespace tyndall::bench {
namespace {
struct Wanted {
    std::vector<std::string> simd; ///< Names; empty: the widest there is, unnamed.
    int rounds = 1;
    std::string report_path;
};

/// Takes its own arguments out of argv.
Wanted parse(int& argc, char** argv) {
    Wanted wanted;
    const auto take = [&](std::string_view argument) {
        const auto value_of = [&](std::string_view name) -> std::optional<std::string> {
            return argument.starts_with(name) ? std::optional(std::string(argument.substr(name.size()))) : std::nullopt;
        };
        if (const auto names = value_of("--simd=")) {
            std::istringstream list(*names);
            for (std::string name; std::getline(list, name, ',');)
                wanted.simd.push_back(name);
        } else if (const auto rounds = value_of("--rounds=")) {
            std::from_chars(rounds->data(), rounds->data() + rounds->size(), wanted.rounds);
        } else if (const auto path = value_of("--benchmark_out=")) {
            wanted.report_path = *path;
        } else {
            return false;
        }
        return true;
    };
    char** const end = std::remove_if(argv + 1, argv + argc, [&](char* argument) { return take(argument); });
    argc = static_cast<int>(end - argv);
    return wanted;
}

/// Shows runs, and keeps them for the report.
class KeepingReporter final : public benchmark::ConsoleReporter {
public:
    std::string simd; ///< Of the benchmarks that run now.

    bool ReportContext(const Context& context) override {
        if (context_)
            return true;
        context_.emplace(context);
        return ConsoleReporter::ReportContext(context);
    }
    void ReportRuns(const std::vector<Run>& runs) override {
        std::vector<Run> named = runs;
        for (Run& run : named)
            if (!simd.empty())
                run.run_name.function_name += "/" + simd;
        ConsoleReporter::ReportRuns(named);
        runs_.insert(runs_.end(), named.begin(), named.end());
    }
    void write(const std::string& path) const {
        std::ofstream file(path);
        benchmark::JSONReporter report;
        report.SetOutputStream(&file);
        report.SetErrorStream(&std::cerr);
        if (context_ && report.ReportContext(*context_)) {
            report.ReportRuns(runs_);
            report.Finalize();
        }
    }

private:
    std::optional<Context> context_;
    std::vector<Run> runs_;
};

void run(const Wanted& wanted, KeepingReporter& reporter) {
    for (int round = 0; round < wanted.rounds; ++round) {
        if (wanted.simd.empty()) {
            benchmark::RunSpecifiedBenchmarks(&reporter);
            continue;
        }
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            reporter.simd = simd_target_name();
            if (std::ranges::find(wanted.simd, reporter.simd) != wanted.simd.end())
                benchmark::RunSpecifiedBenchmarks(&reporter);
        }
    }
}
} // namespace
} // namespace tyndall::bench

int main(int argc, char** argv) {
    const tyndall::bench::Wanted wanted = tyndall::bench::parse(argc, argv);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 1;
    tyndall::bench::KeepingReporter reporter;
    tyndall::bench::run(wanted, reporter);
    if (!wanted.report_path.empty())
        reporter.write(wanted.report_path);
    benchmark::Shutdown();
    return 0;
}
