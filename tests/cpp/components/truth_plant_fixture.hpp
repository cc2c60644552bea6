// What the tests of the plant share.
#pragma once

#include <gtest/gtest.h>

#include <cereal/archives/binary.hpp>
#include <sstream>
#include <string>

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

// Every error source at once.
inline void switch_everything_on(truth_plant::Parameters& parameters) {
    parameters.seed = 42;
    parameters.motion.wave.velocity.setConstant(0.5);
    parameters.motion.turn.angle[0] = 1.0;
    parameters.motion.turn.begin[0] = 1.0;
    parameters.motion.turn.duration[0] = 3.0;
    parameters.imu.gyro.markov_sigma = 1e-6;
    parameters.imu.gyro.wave_sigma = 1e-6;
    parameters.imu.gyro.quantisation = 1e-6;
    parameters.imu.gyro.scale_factor.setConstant(1e-4);
    parameters.imu.gyro.misalignment.setConstant(1e-4);
    parameters.imu.gyro.bias_step.setConstant(1e-6);
    parameters.imu.gyro.bias_step_time = 2.0;
    parameters.imu.accelerometer.markov_sigma = 1e-3;
    parameters.imu.accelerometer.wave_sigma = 1e-3;
    parameters.imu.accelerometer.quantisation = 1e-5;
    parameters.gnss.rate = 10.0;
    parameters.gnss.latency = 0.25;
    parameters.gnss.lever_arm = {1.0, 2.0, 3.0};
    parameters.gnss.velocity_outlier.probability = 0.3;
    parameters.gnss.position_outlier.probability = 0.3;
    parameters.motion.segment.duration.head<3>() = Eigen::Vector3d(1.0, 2.0, 1.5);
    parameters.motion.segment.acceleration[0] = 3.0;
    parameters.motion.segment.climb_angle[1] = 0.1;
    parameters.motion.segment.turn_angle[2] = -0.4;
    parameters.imu.accelerometer.bias_step.setConstant(1e-2);
    parameters.imu.accelerometer.bias_step_time = 1.0;
    parameters.imu.accelerometer.bias_step_duration = 1.5;
    parameters.gnss.outlier_epoch.probability = 0.3;
    parameters.gnss.pseudorange_outlier.probability = 0.3;
    parameters.gnss.range_rate_outlier.probability = 0.3;
    parameters.gnss.satellite_limit = {.count = 3, .begin = 2.0, .end = 4.0};
    parameters.gnss.clock = {.bias = 300.0, .drift = 5.0, .bias_noise = 1.0, .drift_noise = 0.1};
}

inline std::string bytes(const truth_plant::Outputs& outputs) {
    std::ostringstream stream;
    cereal::BinaryOutputArchive{stream}(outputs);
    return stream.str();
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
