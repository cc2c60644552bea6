// Times of steps, measured in turns: a batch of each, and again, so that whatever else the machine does meets
// all of them.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <vector>

namespace truenorth::benchmark {

inline constexpr int kStepsPerBatch = 250;  // within the slice of a processor that is shared
inline constexpr int kBatches = 401;

// Many steps of a filter, of which each batch has a fresh copy.
template <class Step>
std::function<void()> batch(const Step& start) {
    return [start] {
        Step step = start;
        for (int k = 0; k < kStepsPerBatch; ++k) {
            step();
        }
    };
}

// Of a step in the fastest batch of each.
inline std::vector<double> microseconds(const std::vector<std::function<void()>>& batches) {
    std::vector<double> fastest(batches.size(), std::numeric_limits<double>::infinity());
    for (int turn = 0; turn < kBatches; ++turn) {
        for (std::size_t i = 0; i < batches.size(); ++i) {
            const auto start = std::chrono::steady_clock::now();
            batches[i]();
            const std::chrono::duration<double, std::micro> taken = std::chrono::steady_clock::now() - start;
            fastest[i] = std::min(fastest[i], taken.count() / kStepsPerBatch);
        }
    }
    return fastest;
}

}  // namespace truenorth::benchmark
