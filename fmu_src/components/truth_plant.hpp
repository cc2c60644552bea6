// The TruthPlant component: moves a ship, a parked vehicle or an aircraft and puts out what its IMU and GNSS
// receiver measure.
#pragma once

#include <cstdint>
#include <optional>

#include "TruthPlant/variables.hpp"
#include "components/log.hpp"
#include "components/serialisation.hpp"
#include "plant/channel_allocation.hpp"
#include "plant/channel_receiver.hpp"
#include "plant/fix_queue.hpp"
#include "plant/gnss_receiver.hpp"
#include "plant/inertial_sensor.hpp"
#include "plant/receiver_clock.hpp"
#include "plant/trajectory.hpp"

namespace truenorth {

class TruthPlant {
  public:
    truth_plant::Parameters parameters;
    truth_plant::Inputs inputs;
    truth_plant::Outputs outputs;

    explicit TruthPlant(Log& log) : log_(&log) {}

    void initialise(double start_time);
    void retune();
    void step(double time, double step);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, inputs, outputs, state_);
        if constexpr (Archive::is_loading::value) {
            models_ = state_.initialised ? std::optional<Models>(parameters) : std::nullopt;
        }
    }

  private:
    // Constant between two calls of initialise() and retune(): a function of the parameters.
    struct Models {
        explicit Models(const truth_plant::Parameters& parameters);

        plant::Trajectory trajectory;
        plant::InertialSensor gyro;
        plant::InertialSensor accelerometer;
        plant::GnssReceiver receiver;
        plant::ChannelReceiver channel_receiver;
        plant::ReceiverClock clock;
        std::uint64_t samples_per_fix;
        std::uint64_t samples_of_latency;
    };

    struct State {
        bool initialised = false;
        double start_time = 0.0;    // [s]
        std::uint64_t samples = 0;  // IMU samples since then
        plant::Trajectory::State trajectory;
        plant::InertialSensor::State gyro;
        plant::InertialSensor::State accelerometer;
        plant::ReceiverClock::State clock;  // at the last fix, lost ones included
        plant::ChannelAllocation channels;
        plant::FixQueue fixes;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(initialised, start_time, samples, trajectory, gyro, accelerometer, clock, channels,
                    fixes);
        }
    };

    void sample(const Models& models);
    void receive(const Models& models);
    [[nodiscard]] plant::Fix antenna(const Models& models) const;
    void put_out(const plant::Fix& fix);
    void put_out_truth(const Models& models);

    Log* log_;
    std::optional<Models> models_;
    State state_;
};

}  // namespace truenorth
