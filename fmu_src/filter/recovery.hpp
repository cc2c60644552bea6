// The way back of a filter whose gate refuses one fix after another: a ladder whose rungs forget more and
// more of what contradicts the fixes, and which has no end.
//
//   1  what the fix measures is as uncertain as the fix is far off: it passes, and sets them
//   2  of a filter that has been sure of itself: the sensors are blamed too, which may wander more than they
//      are said to; of any other the next rung
//   3  so is the attitude, and the gate stands open for a while
//   4  the filter starts again from the fix, level as the force of late says, with its coarse stage if it has
//      one; the gate stands open for a while
//   5  likewise, with another heading: a filter that tries one after the other comes to one that its
//      equations take. Each time the gate stands open for twice as long, up to 32 times gate.patience
//
// Where changes of velocity tell the heading (heading_finder.hpp), it is taken from there from the second
// rung on. A model of the errors of a mechanisation, which goes on, keeps its tilts and what it has learned
// of the sensors; and its heading, where its equations take any error, else on the fourth rung alone.
//
// The filter climbs a rung each time that the gate has refused gate.patience fixes in a row, and is back on
// the ground when it has gone without for twice kCalm.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#include "contract/time_tolerance.hpp"

namespace truenorth {

class Recovery {
  public:
    static constexpr int kSensors = 2;
    static constexpr int kAttitude = 3;
    static constexpr int kRestart = 4;
    static constexpr int kLast = 5;
    static constexpr int kMostClimbs = 8;  // beyond it the gate stands open no longer
    static constexpr double kTilt = 0.1;   // sigma of a tilt that is in doubt [rad]
    static constexpr double kCalm = 60.0;  // after the last rung the filter is recovering for so long [s]

    void start() { *this = Recovery{}; }

    // The gate has run out of patience; the filter has been `sure` of its attitude before, or not. Returns
    // the rung to take.
    int climb(double clock, int patience, bool sure) {
        if (calm(clock)) {
            climbs_ = 0;
        }
        on_ladder_ = true;
        climbs_ = std::min(climbs_ + 1, kMostClimbs);
        if (climbs_ == kSensors && !sure) {
            climbs_ = kAttitude;
        }
        climbed_ = clock;
        constexpr std::array<int, kMostClimbs> times{0, 0, 1, 2, 4, 8, 16, 32};
        open_for_ = patience * times.at(static_cast<std::size_t>(climbs_ - 1));
        return std::min(climbs_, kLast);
    }

    static constexpr double kHeading = 0.6;     // of a heading near the one that is tried [rad]
    static constexpr double kAnyHeading = 1.8;  // of one that may be any: uniform on the circle [rad]

    // Of the next try, far from all before: in steps of the golden angle [rad].
    double next_heading() {
        constexpr double kGoldenAngle = 2.39996322972865;
        constexpr double kTurn = 2.0 * std::numbers::pi;
        heading_ += kGoldenAngle;
        heading_ = heading_ > kTurn ? heading_ - kTurn : heading_;
        return heading_;
    }

    // Something has been doubted without a rung being climbed: the filter is recovering as it is after one.
    void doubt(double clock) {
        doubts_ = calm(clock) ? 1 : doubts_ + 1;
        on_ladder_ = false;
        climbs_ = std::max(climbs_, 1);
        climbed_ = clock;
    }

    // Doubts that follow one another do not help.
    [[nodiscard]] bool may_doubt(double clock) const { return calm(clock) || doubts_ < kMostDoubts; }

    // What is beyond the gate then, only the next rung answers.
    [[nodiscard]] bool on_ladder(double clock) const { return on_ladder_ && !calm(clock); }

    // The next fix passes whatever its innovation.
    [[nodiscard]] bool open() const { return open_for_ > 0; }

    // One has passed.
    void pass(double clock) {
        if (open()) {
            --open_for_;
            climbed_ = clock;
        }
    }

    [[nodiscard]] bool under_way(double clock) const {
        return climbs_ > 0 && (open() || clock - climbed_ < kCalm - kTimeTolerance);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(climbs_, doubts_, on_ladder_, open_for_, climbed_, heading_);
        doubts_ = std::clamp(doubts_, 0, kMostDoubts);
        climbs_ = std::clamp(climbs_, 0, kMostClimbs);  // whatever a damaged state says
    }

  private:
    static constexpr int kMostDoubts = 3;

    [[nodiscard]] bool calm(double clock) const { return clock - climbed_ > 2.0 * kCalm; }

    int doubts_ = 0;           // one after the other
    bool on_ladder_ = false;   // climbed it last, and did not doubt since
    int climbs_ = 0;           // in this recovery
    int open_for_ = 0;         // fixes
    double heading_ = 0.0;     // tried last [rad]
    double climbed_ = -1e300;  // when it climbed or the gate stood open last, by the master's clock [s]
};

}  // namespace truenorth
