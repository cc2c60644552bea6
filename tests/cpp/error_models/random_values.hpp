// Random states, motions and intervals for the tests of error models.
#pragma once

#include <numbers>
#include <random>

#include "error_models/navigation_interval.hpp"

namespace truenorth {

class RandomValues {
  public:
    explicit RandomValues(unsigned seed) : generator_(seed) {}

    double operator()(double limit) {
        return std::uniform_real_distribution<double>(-limit, limit)(generator_);
    }
    Eigen::Vector3d vector(double limit) { return {(*this)(limit), (*this)(limit), (*this)(limit)}; }

    EulerAngles angles() {
        return {.roll = (*this)(0.5), .pitch = (*this)(0.5), .heading = (*this)(std::numbers::pi)};
    }
    earth::Position position() {
        return {.latitude = (*this)(1.2), .longitude = (*this)(3.0), .height = 1000.0 + (*this)(900.0)};
    }
    NavigationState navigation_state() {
        return {.q_bn = Eigen::Quaterniond(dcm(angles())), .velocity = vector(100.0), .position = position()};
    }
    NavigationInterval interval() {
        const Eigen::Matrix3d C_bn = dcm(angles());
        const Eigen::Vector3d force = Eigen::Vector3d(0.0, 0.0, 9.8) + vector(2.0);
        return {1.0, C_bn, force, vector(100.0), position()};
    }

  private:
    std::mt19937 generator_;
};

// An interval of the model's own type with the content of `content`.
template <class Model>
typename Model::Interval interval_of(const NavigationInterval& content) {
    typename Model::Interval interval(IntervalAverage{}, {}, Model::State::Zero());
    static_cast<NavigationInterval&>(interval) = content;
    return interval;
}

}  // namespace truenorth
