#include "plant/gnss_fault.hpp"

#include "inertial/earth.hpp"
#include "plant/fault_axes.hpp"

namespace truenorth::plant {

GnssFault::GnssFault(const Settings& settings, double period)
    : settings_(settings),
      window_(TimeWindow::lasting(settings.begin, settings.duration, period)),
      concerned_(concerned_by<Eigen::Vector3d>(settings.axis)) {}

Fix GnssFault::shown(Fix antenna) const {
    const Eigen::Vector3d offset = settings_.size * concerned_;
    if (acts(Kind::position_jump, antenna.time)) {
        antenna.position = earth::displaced(antenna.position, offset);
    } else if (acts(Kind::drift, antenna.time)) {
        antenna.position = earth::displaced(antenna.position, (antenna.time - settings_.begin) * offset);
        antenna.velocity += offset;
    }
    return antenna;
}

Fix GnssFault::reported(Fix measured, Fix& before) const {
    const double time = measured.time;
    if (!window_.contains(time)) {
        before = measured;
        return measured;
    }
    if (settings_.kind == Kind::frozen) {
        measured = before;
        measured.time = time;
    } else if (settings_.kind == Kind::velocity_sign) {
        measured.velocity.array() *= 1.0 - 2.0 * concerned_.array();
    } else if (settings_.kind == Kind::time_offset) {
        measured.time = time + settings_.size;
    }
    return measured;
}

}  // namespace truenorth::plant
