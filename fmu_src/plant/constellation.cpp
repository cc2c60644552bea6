#include "plant/constellation.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "elementary/sincos.hpp"
#include "inertial/earth.hpp"

namespace truenorth::plant {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRadius = 26560e3;  // [m]
constexpr double kInclination = 55.0 * kDegree;
constexpr std::size_t kPerPlane = 4;

// `node`: longitude of the ascending node; `argument`: angle in the orbit from there, growing at
// `mean_motion`.
Satellite satellite(double node, double argument, double mean_motion) {
    const auto [sine, cosine] = sincos(Eigen::Array3d(node, argument, kInclination));
    const Eigen::Vector3d to_node(cosine[0], sine[0], 0.0);
    const Eigen::Vector3d across(-cosine[2] * to_node.y(), cosine[2] * to_node.x(),
                                 sine[2]);  // in the plane, 90 deg ahead of the node
    const Eigen::Vector3d position = kRadius * (cosine[1] * to_node + sine[1] * across);
    const Eigen::Vector3d inertial_velocity =
        kRadius * mean_motion * (cosine[1] * across - sine[1] * to_node);
    return {
        .position = position,
        .velocity = inertial_velocity - earth::kRate * Eigen::Vector3d::UnitZ().cross(position),
    };
}

}  // namespace

std::array<Satellite, kSatellites> constellation(double time) {
    const double mean_motion = std::sqrt(earth::kGravitationalParameter / (kRadius * kRadius * kRadius));
    std::array<Satellite, kSatellites> satellites;
    for (std::size_t i = 0; i < kSatellites; ++i) {
        const std::size_t plane = i / kPerPlane;
        const double node = 60.0 * kDegree * static_cast<double>(plane);
        const double argument =
            90.0 * kDegree * static_cast<double>(i % kPerPlane) + 15.0 * kDegree * static_cast<double>(plane);
        satellites[i] = satellite(node - earth::kRate * time, argument + mean_motion * time, mean_motion);
    }
    return satellites;
}

}  // namespace truenorth::plant
