// The way back of a filter whose gate refuses one fix after another: a ladder whose rungs forget more and more
// of what contradicts the fixes, and which has no end.
//
//   1  what the fix measures is as uncertain as the fix is far off: it passes, and sets them
//   2  the attitude and the sensors are blamed too, and the gate stands open for a while
//   3  the filter starts again from the fix, level as the mean force of late says; with the coarse stage, if it
//      has one; the gate stands open for a while
//   4  likewise, with another heading: no error equation finds one that is wrong by more than a right angle,
//      but a filter that tries one after the other comes to one that is not
//
// The filter climbs a rung each time that the gate has refused gate.patience fixes in a row, and is back on
// the ground when it has gone without for twice kCalm.
#pragma once

#include <algorithm>

namespace truenorth {

class Recovery {
  public:
    static constexpr int kRestart = 3;
    static constexpr int kLast = 4;
    static constexpr double kTilt = 0.1;    // sigma of a tilt that is in doubt [rad]
    static constexpr double kCalm = 60.0;   // after the last rung the filter is recovering for so long [s]

    void start() { *this = Recovery{}; }

    // The gate has run out of patience. Returns the rung to take.
    int climb(double clock, int patience) {
        if (clock - climbed_ > 2.0 * kCalm) {
            rung_ = 0;
        }
        rung_ = std::min(rung_ + 1, kLast);
        climbed_ = clock;
        open_for_ = rung_ > 1 ? patience : 0;
        return rung_;
    }

    static constexpr double kHeading = 0.6;  // of a heading [rad]
    static constexpr double kAnotherHeading = 2.39996;  // the golden angle: the next try is far from all before [rad]

    // The next fix passes whatever its innovation.
    [[nodiscard]] bool open() const { return open_for_ > 0; }
    void pass() { open_for_ = std::max(open_for_ - 1, 0); }

    [[nodiscard]] bool under_way(double clock) const {
        return rung_ > 0 && (open() || clock - climbed_ < kCalm);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(rung_, open_for_, climbed_);
    }

  private:
    int rung_ = 0;
    int open_for_ = 0;         // fixes
    double climbed_ = -1e300;  // by the master's clock [s]
};

}  // namespace truenorth
