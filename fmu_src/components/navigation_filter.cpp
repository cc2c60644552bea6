#include "components/navigation_filter.hpp"

#include <Eigen/Cholesky>
#include <numbers>

#include "components/inertial_filter_fix.hpp"
#include "components/inertial_filter_run.hpp"

namespace truenorth {

template class InertialFilter<navigation_filter::Interface, NavigationEngine<Loose>, StateEngine<FullState>,
                              NavigationEngine<Tight>>;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kLargestGyroBias = 0.1;            // [rad/s]
constexpr double kLargestAccelerometerBias = 10.0;  // [m/s2]

void require_within(std::string_view name, double value, double least, double most) {
    rules::finite(name, value);
    rules::at_least(name, value, least);
    rules::at_most(name, value, most);
}

void require_small(std::string_view name, const Eigen::Vector3d& vector, double limit) {
    for (int i = 0; i < 3; ++i) {
        require_within(text(name, "[", i + 1, "]"), vector(i), -limit, limit);
    }
}

// Throws InvalidParameter: the inputs initial.* are data, but a filter cannot start without them.
template <class Initial>
void require_sound(const Initial& initial) {
    require_within("initial.roll", initial.roll, -kTurn, kTurn);
    require_within("initial.pitch", initial.pitch, -kTurn / 4.0, kTurn / 4.0);
    require_within("initial.heading", initial.heading, -2.0 * kTurn, 2.0 * kTurn);
    require_within("initial.latitude", initial.latitude, -earth::kHighestLatitude, earth::kHighestLatitude);
    require_within("initial.longitude", initial.longitude, -GnssInput::kLargestLongitude,
                   GnssInput::kLargestLongitude);
    require_within("initial.height", initial.height, GnssInput::kLowest, GnssInput::kHighest);
    require_small("initial.velocity", initial.velocity, GnssInput::kLargestSpeed);
    require_small("initial.gyro_bias", initial.gyro_bias, kLargestGyroBias);
    require_small("initial.accelerometer_bias", initial.accelerometer_bias, kLargestAccelerometerBias);

    const HandedCovariance P = initial.covariance;
    const bool symmetric = (P - P.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * P.cwiseAbs().maxCoeff();
    if (!P.allFinite() || !symmetric || (!P.isZero(0.0) && P.llt().info() != Eigen::Success)) {
        throw InvalidParameter(
            "initial.covariance: must be symmetric and positive definite, or zero to take prior.*");
    }
}

}  // namespace

void NavigationFilter::initialise(double start_time) {
    prepare(start_time);
    refused_ = false;
    if (inputs.initial.valid) {
        set_out_from_inputs();
    }
    publish();
}

void NavigationFilter::set_out_from_inputs() {
    const auto& initial = inputs.initial;
    require_sound(initial);
    set_out({.state = {.q_bn = Eigen::Quaterniond(
                           dcm({.roll = initial.roll, .pitch = initial.pitch, .heading = initial.heading})),
                       .velocity = initial.velocity,
                       .position = {.latitude = initial.latitude,
                                    .longitude = wrap_angle(initial.longitude),
                                    .height = initial.height}},
             .gyro_bias = initial.gyro_bias,
             .accelerometer_bias = initial.accelerometer_bias,
             .covariance = initial.covariance});
}

void NavigationFilter::step(double /*time*/, double /*step*/) {
    // What is handed over is valid at the time of the last sample, under a master that passes it on a step
    // late, or else at that of the new one.
    if (!under_way() && inputs.initial.valid && std::abs(inputs.initial.time - now()) <= kTimeTolerance) {
        hand_over();
    }
    advance();
    if (!under_way() && inputs.initial.valid) {
        hand_over();
        publish();
    }
    refused_ = refused_ && inputs.initial.valid;
}

void NavigationFilter::hand_over() {
    const double valid_at = inputs.initial.time;
    try {
        if (valid_at >= 0.0 && std::abs(valid_at - now()) > kTimeTolerance) {
            rules::refuse("initial.time", valid_at,
                          text("that of the last IMU sample, ", now(), " s, or negative for just that"));
        }
        set_out_from_inputs();
        if (log().listens()) {
            log().event(text("navigation starts at ", now(), " s"));
        }
    } catch (const InvalidParameter& error) {
        if (!refused_ && log().listens()) {
            log().event(text("hand-over refused: ", error.what()));
        }
        refused_ = true;
    }
}

}  // namespace truenorth
