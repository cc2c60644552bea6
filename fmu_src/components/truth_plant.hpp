// The TruthPlant component: moves a ship, a parked vehicle or an aircraft, or follows a vehicle that somebody
// else moves, and puts out what its IMU and GNSS receiver measure.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "TruthPlant/variables.hpp"
#include "components/external_vehicle.hpp"
#include "components/truth_plant_models.hpp"
#include "contract/log.hpp"
#include "contract/repetition.hpp"
#include "contract/serialisation.hpp"
#include "contract/step_sequence.hpp"
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
    // them, of several fixes the last is put out and all are counted. With an external motion they cover the
    // periods up to the last state that is known, and where none has passed the outputs stand still. A step
    // of 0 s, with which model exchange tells of new inputs, changes nothing. Throws std::invalid_argument
    // for a step that cannot be made, and nothing has changed then; std::runtime_error when the motion comes
    // to a pole on the way, and the run is over then.
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
        std::uint64_t due = 0;      // that the master's clock has come to; later than `samples` where the
                                    // motion is not known so far
        std::int64_t steps = 0;     // that had samples, and breaks in the motion
        StepSequence sequence;
        plant::Trajectory::State trajectory;
        plant::Trajectory::Increments begun;  // of the IMU period in which the trajectory is
        ExternalVehicle vehicle;
        plant::InertialSensor::State gyro;
        plant::InertialSensor::State accelerometer;
        plant::ReceiverClock::State clock;  // at the last fix, lost ones included
        plant::ChannelAllocation channels;
        plant::FixQueue fixes;
        plant::ImuFault::State imu_fault;
        plant::Fix before_gnss_fault;
        Repetition<2> told_losses;
        Repetition<1> told_refusals;  // of states of the vehicle

        template <class Archive>
        void serialize(Archive& archive) {
            archive(initialised, start_time, samples, due, steps, sequence, trajectory, begun, vehicle, gyro,
                    accelerometer, clock, channels, fixes, imu_fault, before_gnss_fault, told_losses,
                    told_refusals);
        }
    };

    // A part of the motion, which is known until `end` [s]; there the vehicle is at `arrival`.
    struct Leg {
        const plant::Trajectory* trajectory = nullptr;
        double end = std::numeric_limits<double>::infinity();
        earth::Position arrival{};
    };

    // When an IMU sample ends [s].
    [[nodiscard]] double end_of(std::uint64_t sample) const {
        return state_.start_time + static_cast<double>(sample) / parameters.imu.rate;
    }
    // Makes the IMU samples to number `last`, on one leg or along the vehicle of somebody else, as far as the
    // motion is known; how many these were. A step begins at `begin` [s].
    std::uint64_t travel(const Models& models, const Leg& leg, std::uint64_t last, plant::ImuOutput& output);
    std::uint64_t follow(const Models& models, double begin, plant::ImuOutput& output);
    void advance(const Leg& leg, double to);
    // Looks at the vehicle of somebody else; without a stamp its state is that at `begin` [s].
    ExternalVehicle::Verdict look(double begin);
    void refuse_state(double time);
    // What the inertial sensors make of the IMU period that ends here, added to the increments of `output`.
    void measure(const Models& models, plant::ImuOutput& output);
    // The fix that becomes valid at this IMU sample, and the fixes that appear at it.
    void receive(const Models& models);
    // What the aids measure at this IMU sample.
    void aid(const Models& models);
    enum class Loss : std::uint8_t { outage, fault };
    void lose(double time, Loss cause);
    // The antenna's true state, as the receiver would see it without errors and channels.
    [[nodiscard]] plant::Fix antenna() const;
    void put_out(const plant::ImuOutput& output);
    void put_out(const Models& models, const plant::Fix& fix);
    void put_out_truth(const Models& models);

    Log* log_;
    std::optional<Models> models_;  // constant between two calls of initialise() and retune()
    State state_;
};

}  // namespace truenorth
