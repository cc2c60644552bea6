// The Playback component: puts out what the sensors of a recording measured, as TruthPlant does of a motion.
//
// Simulation begins where the recording does, whatever the start time: the time stamps that are put out are
// those of the recording, moved by what lies between the two. A sample comes at the end of the step in which
// its stamp is reached, and with it all that was measured until then.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "Playback/variables.hpp"
#include "components/recorded_signals.hpp"
#include "contract/log.hpp"

namespace truenorth {

class Playback {
  public:
    // What the FMU reads of its resources.
    using Resources = RecordedSignals;

    playback::Parameters parameters;
    playback::Inputs inputs;
    playback::Outputs outputs;

    // `log` must outlive it.
    Playback(Log& log, std::shared_ptr<const RecordedSignals> signals)
        : log_(&log), signals_(std::move(signals)) {}

    // Begins at `start_time` [s] with these parameters. Throws InvalidParameter.
    void initialise(double start_time);

    // There are no tunable parameters. Throws InvalidParameter when those that are set are none that an
    // initialisation has accepted.
    void retune() const { check(); }

    // From `time` to `time + step` [s]: the increments put out are those of all samples in between.
    void step(double time, double step);

    // Of the steps that suit the recording [s].
    [[nodiscard]] double sample_period() const { return signals_->step(); }

    // The complete state but for the recording. Loading throws std::runtime_error when it is of another one.
    template <class Archive>
    void serialize(Archive& archive) {
        recorded::Sums sums = signals_->sums();
        archive(parameters, inputs, outputs, sums, state_);
        if constexpr (Archive::is_loading::value) {
            if (sums != signals_->sums() || !state_.fits(*signals_)) {
                throw std::runtime_error("the stored state is one of another recording, or damaged");
            }
        }
    }

  private:
    struct State {
        bool initialised = false;
        double start_time = 0.0;  // of the simulation [s]
        double begin = 0.0;       // the same by the recording's clock [s]
        std::uint64_t first = 0;  // sample that comes first
        // Rows of the tables that have come, of the aids in the order of the file.
        std::uint64_t samples = 0;
        std::uint64_t fixes = 0;
        std::uint64_t body_velocities = 0;
        std::uint64_t headings = 0;
        std::uint64_t heights = 0;

        [[nodiscard]] bool fits(const RecordedSignals& signals) const;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(initialised, start_time, begin, first, samples, fixes, body_velocities, headings,
                    heights);
        }
    };

    void check() const;
    // A time of the recording by the simulation's clock [s].
    [[nodiscard]] double simulated(double time) const { return time - state_.begin + state_.start_time; }

    // The samples until a time of the recording, as one; how many.
    std::size_t sample_until(double time);
    // What has come of all aids with the samples so far.
    void play_aids();
    template <class Row, class Output>
    void play(const std::vector<Row>& rows, std::uint64_t& come, Output& output);
    // Where an aid begins, after a time of the recording; its first measurement stands in until it comes.
    template <class Row>
    std::uint64_t begin_at(const std::vector<Row>& rows, double time);

    [[nodiscard]] bool withheld(const recorded::Fix& fix) const;
    template <class Row>
    [[nodiscard]] bool withheld(const Row& /*row*/) const {
        return false;
    }

    void put_out(const recorded::Fix& fix);
    void put_out(const recorded::BodyVelocity& measured);
    void put_out(const recorded::HeadingAid& measured);
    void put_out(const recorded::HeightAid& measured);
    void put_out_truth();

    Log* log_;
    std::shared_ptr<const RecordedSignals> signals_;
    State state_;
};

}  // namespace truenorth
