// The motions that the plant can make. Each is a class with `Kinematics at(double time) const`, closed form,
// any time; another motion is one more class in this list.
#pragma once

#include <variant>

#include "plant/flight.hpp"
#include "plant/kinematics.hpp"
#include "plant/parked_vehicle.hpp"
#include "plant/passage.hpp"
#include "plant/road_vehicle.hpp"
#include "plant/ship.hpp"

namespace truenorth::plant {

using Motion = std::variant<Ship, ParkedVehicle, Flight, Passage, RoadVehicle>;

inline Kinematics at(const Motion& motion, double time) {
    return std::visit([time](const auto& kind) { return kind.at(time); }, motion);
}

}  // namespace truenorth::plant
