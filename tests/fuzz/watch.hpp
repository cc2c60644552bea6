// Looks after the calls of a fuzz run: none may take longer than a second, or several under a sanitizer.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace truenorth::fuzz {

class Watch {
  public:
    using Clock = std::chrono::steady_clock;

    // Runs one call of the kind `what` that says whether it was honoured.
    template <class Call>
    bool run(const std::string& what, Call call) {
        const auto begin = Clock::now();
        const bool honoured = call();
        const std::chrono::duration<double> taken = Clock::now() - begin;
        auto& [honoured_calls, refused_calls] = counts_[what];
        ++(honoured ? honoured_calls : refused_calls);
        ++calls_;
        longest_ = std::max(longest_, taken.count());
        if (longest_ > limit_) {
            fail(what + " took " + std::to_string(taken.count()) + " s");
        }
        return honoured;
    }

    [[noreturn]] void fail(const std::string& why) const {
        std::fprintf(stderr, "call %ld: %s\n", calls_, why.c_str());
        std::abort();
    }

    void print() const {
        std::printf("  longest call %.3f s\n  %-36s %9s %9s\n", longest_, "", "honoured", "refused");
        for (const auto& [what, count] : counts_) {
            std::printf("  %-36s %9ld %9ld\n", what.c_str(), count.first, count.second);
        }
    }

    [[nodiscard]] long calls() const { return calls_; }

  private:
    static constexpr double limit_ = 5.0;  // [s]
    double longest_ = 0.0;                 // [s]
    std::map<std::string, std::pair<long, long>> counts_;
    long calls_ = 0;
};

}  // namespace truenorth::fuzz
