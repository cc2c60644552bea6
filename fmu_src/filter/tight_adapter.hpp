// The tightly coupled model (Chen 2019) in a filter.
#pragma once

#include <cereal/types/array.hpp>

#include "error_models/tight.hpp"
#include "filter/adapter.hpp"
#include "filter/navigation_engine.hpp"

namespace truenorth {

template <>
struct Adapter<Tight> {
    static constexpr bool small_angles = true;
    static constexpr Block attitude{.first = Tight::kPhi, .count = 3};
    static constexpr Block velocity{.first = Tight::kVelocity, .count = 3};
    static constexpr Block position{.first = Tight::kPosition, .count = 3};
    static constexpr Block gyro{.first = Tight::kGyro, .count = 3};
    static constexpr Block accelerometer{.first = Tight::kAccelerometer, .count = 3};
    static constexpr Block markov{.first = Tight::kGyroMarkov, .count = 3};

    // Beyond these a channel shows a fault of the receiver.
    static constexpr double kLongestRange = 1e8;      // [m]; satellites are at 4.2e7 m at most
    static constexpr double kFastestSatellite = 1e5;  // [m/s]

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        return p.error_model == decltype(p.error_model)::tight;
    }

    template <class Parameters>
    static void check(const Parameters& /*p*/) {}

    template <class Parameters>
    static void configure(Tight& model, const Parameters& p) {
        model.propagation = p.propagation == decltype(p.propagation)::nonlinear
                                ? Tight::Propagation::nonlinear
                                : Tight::Propagation::linear;
        model.noise = {.angle_random_walk = p.process.angle_random_walk,
                       .velocity_random_walk = p.process.velocity_random_walk,
                       .gyro_random_walk = p.process.gyro_bias_random_walk,
                       .gyro_markov_sigma = p.process.gyro_markov_sigma,
                       .gyro_markov_time = p.process.gyro_markov_time,
                       .accelerometer_random_walk = p.process.accelerometer_bias_random_walk,
                       .clock_bias_random_walk = p.process.clock_bias_noise,
                       .clock_drift_random_walk = p.process.clock_drift_noise,
                       .pseudorange_sigma = p.measurement.pseudorange_sigma,
                       .range_rate_sigma = p.measurement.range_rate_sigma};
    }

    template <class Parameters>
    static void set_prior(Vector<Tight::kStates>& sigma, const Parameters& p) {
        sigma.segment<3>(Tight::kGyroMarkov).setConstant(p.process.gyro_markov_sigma);
        sigma(Tight::kClockBias) = p.prior.clock_bias_sigma;
        sigma(Tight::kClockDrift) = p.prior.clock_drift_sigma;
    }

    // What makes position and velocity uncertain may lie with the receiver's clock.
    static void blame(Matrix<Tight::kStates>& P, const Uncertainty& more) {
        P(Tight::kClockBias, Tight::kClockBias) = more.position.trace();
        P(Tight::kClockDrift, Tight::kClockDrift) = more.velocity.trace();
    }

    // How far off the fix is at most: of the ranges [m], of the range rates [m/s].
    static Discrepancy discrepancy(const Vector<Tight::kMeasurements>& residual) {
        return {
            .position = Eigen::Vector3d::Constant(residual.head<Tight::kChannels>().cwiseAbs().maxCoeff()),
            .velocity = Eigen::Vector3d::Constant(residual.tail<Tight::kChannels>().cwiseAbs().maxCoeff())};
    }

    // Channels whose values are not finite or impossible count as absent.
    template <class Port>
    Tight::Fix fix_of(const Sighting& seen, const Port& gnss) {
        Tight::Fix fix{.channels = {},
                       .position = seen.then.position,
                       .velocity = seen.then.velocity,
                       .antenna = {.C_bn = seen.then.q_bn.toRotationMatrix(),
                                   .lever_arm = seen.lever_arm,
                                   .omega_eb_b = seen.then.omega_eb_b}};
        const auto& port = gnss.channel;
        for (int i = 0; i < Tight::kChannels; ++i) {
            const Tight::Channel channel{.valid = true,
                                         .pseudorange = port.pseudorange(i),
                                         .range_rate = port.range_rate(i),
                                         .satellite_position = port.satellite_position.row(i),
                                         .satellite_velocity = port.satellite_velocity.row(i)};
            if (port.valid[i] && plausible(channel)) {
                fix.channels[i] = channel;
            } else if (port.valid[i]) {
                ++rejected_;
            }
        }
        return fix;
    }

    // A channel that follows another satellite than before.
    template <class Port, class Restart>
    void renewed(const Port& gnss, const Restart& restart) {
        for (int i = 0; i < Tight::kChannels; ++i) {
            const int satellite = gnss.channel.satellite[i];
            if (satellite != satellites_[i]) {
                satellites_[i] = satellite;
                restart(i);
                restart(Tight::kChannels + i);
            }
        }
    }

    template <class Outputs>
    void publish(Outputs& outputs, const Tight::State& x, const Tight::State& sigma) const {
        outputs.gyro_markov = x.segment<3>(Tight::kGyroMarkov);
        outputs.clock_bias = x(Tight::kClockBias);
        outputs.clock_bias_sigma = sigma(Tight::kClockBias);
        outputs.clock_drift = x(Tight::kClockDrift);
        outputs.clock_drift_sigma = sigma(Tight::kClockDrift);
        outputs.rejected_channels = rejected_;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(satellites_, rejected_);
    }

  private:
    // Comparisons are false for what is not a number.
    static bool plausible(const Tight::Channel& channel) {
        return std::abs(channel.pseudorange) < kLongestRange &&
               std::abs(channel.range_rate) < kFastestSatellite &&
               channel.satellite_position.norm() < kLongestRange &&
               channel.satellite_velocity.norm() < kFastestSatellite;
    }

    std::array<int, Tight::kChannels> satellites_{};
    int rejected_ = 0;
};

extern template class Engine<Tight>;
extern template class NavigationEngine<Tight>;
extern template struct AidUpdate<NavigationEngine<Tight>>;
extern template class Estimator<Tight>;
extern template class Corrector<Tight::kStates, Tight::kMeasurements>;

}  // namespace truenorth
