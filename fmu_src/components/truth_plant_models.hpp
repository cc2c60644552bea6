// What the plant is made of, as its parameters say: motion, sensors, receiver, clock, faults.
#pragma once

#include <cstdint>

#include "TruthPlant/variables.hpp"
#include "plant/aid_sensor.hpp"
#include "plant/channel_receiver.hpp"
#include "plant/gnss_fault.hpp"
#include "plant/gnss_receiver.hpp"
#include "plant/imu_fault.hpp"
#include "plant/inertial_sensor.hpp"
#include "plant/receiver_clock.hpp"
#include "plant/trajectory.hpp"

namespace truenorth::truth_plant {

// Tolerance when a number of IMU periods is taken for a whole number.
inline constexpr double kWhole = 1e-3;

// A function of the parameters alone.
struct Models {
    explicit Models(const Parameters& parameters);

    plant::Trajectory trajectory;
    plant::InertialSensor gyro;
    plant::InertialSensor accelerometer;
    plant::GnssReceiver receiver;
    plant::ChannelReceiver channel_receiver;
    plant::ReceiverClock clock;
    plant::ImuFault imu_fault;
    plant::GnssFault gnss_fault;
    std::uint64_t samples_per_fix;
    plant::BodyVelocitySensor body_velocity;
    plant::AidSchedule body_velocity_schedule;
    plant::ScalarSensor heading_aid;
    plant::AidSchedule heading_aid_schedule;
    plant::ScalarSensor height_aid;
    plant::AidSchedule height_aid_schedule;
};

}  // namespace truenorth::truth_plant
