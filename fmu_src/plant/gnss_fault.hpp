// What can go wrong with a GNSS receiver, with the signals that it receives and on the way of its fixes; one
// fault at a time. Components east, north, up.
#pragma once

#include <Eigen/Core>

#include "plant/fix.hpp"
#include "plant/time_window.hpp"

namespace truenorth::plant {

class GnssFault {
  public:
    enum class Kind {
        none,
        silence,
        frozen,
        position_jump,
        drift,
        velocity_sign,
        time_offset,
        latency,
    };

    struct Settings {
        Kind kind = Kind::none;
        double begin = 0.0;     // [s]
        double duration = 0.0;  // [s]; 0: for ever
        double size = 0.0;      // in SI units of the kind
        int axis = 0;           // 0: all; 1 to 3: east, north, up
    };

    // `period`: of the IMU samples, at whose ends fixes are valid [s].
    GnssFault(const Settings& settings, double period);

    // True when a fix valid at `time` is not put out.
    [[nodiscard]] bool silences(double time) const { return acts(Kind::silence, time); }

    // The antenna's state as the signals show it, of the true one.
    [[nodiscard]] Fix shown(Fix antenna) const;

    // What the receiver reports of the fix that it has measured, at its time of validity; `before`, the last
    // one before the fault, is the receiver's memory.
    [[nodiscard]] Fix reported(Fix measured, Fix& before) const;

    // How much later than it should a fix valid at `time` is put out [s].
    [[nodiscard]] double latency(double time) const {
        return acts(Kind::latency, time) ? settings_.size : 0.0;
    }

  private:
    // Whether the fault is of this kind, and on.
    [[nodiscard]] bool acts(Kind kind, double time) const {
        return settings_.kind == kind && window_.contains(time);
    }

    Settings settings_;
    TimeWindow window_;
    Eigen::Vector3d concerned_;  // 1 for the components of the axis, 0 for others
};

}  // namespace truenorth::plant
