// What a filter can say of a navigation state besides its estimate, whatever its model: by how much more it
// is uncertain, and how far a fix is off. East, north, up.
#pragma once

#include <Eigen/Core>

namespace truenorth {

// Variance that the errors gain: attitude [rad2], velocity [m2/s2], position [m2]; of the sensors' errors so
// many times their prior one, of each accelerometer's so much besides [m2/s4].
struct Uncertainty {
    Eigen::Matrix3d attitude = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d velocity = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d position = Eigen::Matrix3d::Zero();
    double sensors = 0.0;
    double accelerometer = 0.0;
};

// Of a fix from what was predicted.
struct Discrepancy {
    Eigen::Vector3d position;  // [m]
    Eigen::Vector3d velocity;  // [m/s]
};

}  // namespace truenorth
