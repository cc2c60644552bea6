// What an inertial filter is doing: whether it works, what it waits for, and whether its heading is to be
// believed. It runs on the master's clock: a sensor that has failed has no time.
#pragma once

#include <cstdint>
#include <limits>

namespace truenorth {

class FilterStatus {
  public:
    // Numbered as the items of the enumeration Status of the interface, to which it is cast.
    enum class State : std::uint8_t {
        waiting = 1,
        aligning,
        converged,
        coasting,
        faulted,
        coarse,
        inconsistent,
        silent,
        suspect,
        recovering
    };

    struct Rules {
        double heading_sigma;   // below it the heading may count as converged [rad]
        double hold_time;       // when it has stayed so for this long [s]
        double coasting_delay;  // without a fix for longer, the filter coasts [s]
    };

    struct Evidence {
        bool sensing;          // an IMU sample has been accepted
        bool silent;           // but none for too long
        bool suspect;          // the IMU data of late cannot be all right
        bool coarse;           // the attitude is not the filter's yet
        bool recovering;       // the filter is on its way back
        bool consistent;       // the innovations of late agree with their covariance
        bool measured;         // the heading is not one that was guessed after a start was found wrong
        double heading_sigma;  // [rad]
    };

    void start(double clock);

    // A fix has corrected the estimate.
    void use_fix(double clock);

    // The estimate cannot be used any more.
    void fault() { faulted_ = true; }
    [[nodiscard]] bool faulted() const { return faulted_; }

    // Since the last fix used, or the start [s].
    [[nodiscard]] double since_fix(double clock) const { return clock - last_use_; }

    // Call after every step.
    State judge(double clock, const Evidence& evidence, const Rules& rules);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(last_use_, below_since_, used_, faulted_);
    }

  private:
    [[nodiscard]] State hindrance(double clock, const Evidence& evidence, const Rules& rules) const;

    double last_use_ = 0.0;  // time of the last fix used, or the start [s]
    // Since when the heading is good enough and nothing speaks against it [s]; NaN: it is not.
    double below_since_ = std::numeric_limits<double>::quiet_NaN();
    bool used_ = false;
    bool faulted_ = false;
};

}  // namespace truenorth
