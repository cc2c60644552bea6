// The steps of a master, one after another on its own clock. A master that adds up its steps rounds each
// time, always in the same direction: 2 s within 24 h for steps of 0.0025 s from 1.4e9 s on. So a step is
// held against the one before it, and never against the start of the run.
#pragma once

#include <cmath>
#include <limits>

namespace truenorth {

class StepSequence {
  public:
    StepSequence() = default;
    explicit StepSequence(double start) : next_(start) {}

    // Where the next step begins, as the master says it [s].
    [[nodiscard]] double next() const { return next_; }

    // Whether a step that begins at `time` [s] is the next one: neither skips nor repeats more than `slack`
    // [s]. Besides, a few roundings of times of this size are forgiven.
    [[nodiscard]] bool continues(double time, double slack) const {
        return std::abs(time - next_) <=
               slack + 4.0 * std::numeric_limits<double>::epsilon() * std::abs(time);
    }

    void advance(double time, double step) { next_ = time + step; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(next_);
    }

  private:
    double next_ = 0.0;
};

}  // namespace truenorth
