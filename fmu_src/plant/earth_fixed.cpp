#include "plant/earth_fixed.hpp"

#include <cmath>

namespace truenorth::plant {

Eigen::Vector3d earth_fixed(const earth::Position& position) {
    const double N = earth::radii(position.latitude).prime_vertical;
    const double from_axis = (N + position.height) * std::cos(position.latitude);
    return {from_axis * std::cos(position.longitude), from_axis * std::sin(position.longitude),
            (N * (1.0 - earth::kEccentricity2) + position.height) * std::sin(position.latitude)};
}

Eigen::Matrix3d C_ne(const earth::Position& position) {
    const double s = std::sin(position.latitude);
    const double c = std::cos(position.latitude);
    const Eigen::Vector3d east(-std::sin(position.longitude), std::cos(position.longitude), 0.0);
    const Eigen::Vector3d outward(east.y(), -east.x(), 0.0);  // from the axis
    Eigen::Matrix3d C;
    C << east, c * Eigen::Vector3d::UnitZ() - s * outward, c * outward + s * Eigen::Vector3d::UnitZ();
    return C;
}

}  // namespace truenorth::plant
