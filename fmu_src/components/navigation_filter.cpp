#include "components/navigation_filter.hpp"

#include <Eigen/Cholesky>

#include "filter/inertial_filter_run.hpp"

namespace truenorth {

template class InertialFilter<navigation_filter::Interface, NavigationEngine<Loose>, StateEngine<FullState>,
                              NavigationEngine<Tight>, InvariantEngine<false>>;

namespace {

// Throws InvalidParameter: inputs are data, but a filter cannot start without these.
void require_sound(const navigation_filter::Inputs& inputs) {
    validate(inputs);
    const HandedCovariance P = inputs.initial.covariance;
    const Vector<kHandedStates> sigma = P.diagonal().cwiseMax(0.0).cwiseSqrt();
    const bool symmetric =
        ((P - P.transpose()).cwiseAbs().array() <= 1e-9 * (sigma * sigma.transpose()).array()).all();
    if (!symmetric || (!P.isZero(0.0) && P.llt().info() != Eigen::Success)) {
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
    require_sound(inputs);
    set_out({.state = state_of(initial),
             .gyro_bias = initial.gyro_bias,
             .accelerometer_bias = initial.accelerometer_bias,
             .covariance = initial.covariance});
}

void NavigationFilter::step(double time, double step) {
    // What is handed over is valid at the time of the last sample, under a master that passes it on a step
    // late, or else at that of the new one.
    if (!under_way() && inputs.initial.valid && std::abs(inputs.initial.time - now()) <= kTimeTolerance) {
        hand_over();
    }
    advance(time, step);
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
            if (refused_) {
                return;  // and said so
            }
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
