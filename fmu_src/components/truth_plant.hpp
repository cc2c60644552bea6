// The TruthPlant component: moves a ship, a parked vehicle or an aircraft and puts out what its IMU and GNSS
// receiver measure.
#pragma once

#include <cstdint>
#include <optional>

#include "TruthPlant/variables.hpp"
#include "components/log.hpp"
#include "components/repetition.hpp"
#include "components/serialisation.hpp"
#include "components/step_sequence.hpp"
#include "components/truth_plant_models.hpp"
#include "plant/channel_allocation.hpp"
#include "plant/fix.hpp"
#include "plant/fix_queue.hpp"
#include "plant/imu_fault.hpp"
#include "plant/inertial_sensor.hpp"
#include "plant/receiver_clock.hpp"
#include "plant/trajectory.hpp"

namespace truenorth {

class TruthPlant {
  public:
    truth_plant::Parameters parameters;
    truth_plant::Inputs inputs;
    truth_plant::Outputs outputs;

    // `log` must outlive the plant.
    explicit TruthPlant(Log& log) : log_(&log) {}

    // Begins at `start_time` [s] with these parameters, as if nothing had been before; outputs are valid
    // afterwards. Throws InvalidParameter.
    void initialise(double start_time);

    // Tunable parameters have changed between two steps. Throws InvalidParameter, and goes on with what was.
    void retune();

    // From `time` to `time + step` [s], a whole number of IMU periods: the increments put out cover all of
    // them, of several fixes the last is put out and all are counted. Throws std::invalid_argument for a step
    // that cannot be made, and nothing has changed then; std::runtime_error when the motion comes to a pole
    // on the way, and the run is over then.
    void step(double time, double step);

    // Of the IMU [s].
    [[nodiscard]] double sample_period() const { return 1.0 / parameters.imu.rate; }

    // The complete state, as bytes; what follows from the parameters is made anew. Loading throws
    // InvalidParameter when they are none that an initialisation has accepted.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, inputs, outputs, state_);
        if constexpr (Archive::is_loading::value) {
            models_.reset();
            if (state_.initialised) {
                retune();
            }
        }
    }

  private:
    using Models = truth_plant::Models;

    struct State {
        bool initialised = false;
        double start_time = 0.0;    // [s]
        std::uint64_t samples = 0;  // IMU samples since then
        std::int64_t steps = 0;     // likewise
        StepSequence sequence;
        plant::Trajectory::State trajectory;
        plant::InertialSensor::State gyro;
        plant::InertialSensor::State accelerometer;
        plant::ReceiverClock::State clock;  // at the last fix, lost ones included
        plant::ChannelAllocation channels;
        plant::FixQueue fixes;
        plant::ImuFault::State imu_fault;
        plant::Fix before_gnss_fault;
        Repetition<2> told_losses;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(initialised, start_time, samples, steps, sequence, trajectory, gyro, accelerometer, clock,
                    channels, fixes, imu_fault, before_gnss_fault, told_losses);
        }
    };

    // One IMU period: the motion, and what the IMU makes of it, added to the increments of `output`.
    void sample(const Models& models, plant::ImuOutput& output);
    // The fix that becomes valid at this IMU sample, and the fixes that appear at it.
    void receive(const Models& models);
    // What the aids measure at this IMU sample.
    void aid(const Models& models);
    enum class Loss : std::uint8_t { outage, fault };
    void lose(double time, Loss cause);
    // The antenna's true state, as the receiver would see it without errors and channels.
    [[nodiscard]] plant::Fix antenna(const Models& models) const;
    void put_out(const plant::ImuOutput& output);
    void put_out(const Models& models, const plant::Fix& fix);
    void put_out_truth(const Models& models);

    Log* log_;
    std::optional<Models> models_;  // constant between two calls of initialise() and retune()
    State state_;
};

}  // namespace truenorth
