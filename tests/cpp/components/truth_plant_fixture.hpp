// What the tests of the plant share.
#pragma once

#include <gtest/gtest.h>

#include "components/truth_plant.hpp"
#include "lines.hpp"

namespace truenorth {

// No errors of any kind.
inline void make_perfect(truth_plant::Parameters& parameters) {
    parameters.imu.gyro.bias_sigma = 0.0;
    parameters.imu.gyro.white_noise = 0.0;
    parameters.imu.accelerometer.bias_sigma = 0.0;
    parameters.imu.accelerometer.white_noise = 0.0;
    parameters.gnss.position_sigma.setZero();
    parameters.gnss.velocity_sigma.setZero();
    parameters.gnss.pseudorange_sigma = 0.0;
    parameters.gnss.range_rate_sigma = 0.0;
}

// From IMU period `from` to IMU period `to` after time 0, `periods` a step.
inline void run(TruthPlant& plant, int from, int to, int periods = 1) {
    for (int k = from; k < to; k += periods) {
        plant.step(k / plant.parameters.imu.rate, periods / plant.parameters.imu.rate);
    }
}

class TruthPlantTest : public testing::Test {
  protected:
    Lines log_;
    TruthPlant plant_{log_};
};

}  // namespace truenorth
