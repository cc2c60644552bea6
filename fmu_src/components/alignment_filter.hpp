// AlignmentFilter: mechanisation, error model, predictor and corrector behind one interface.
//
// Every IMU sample is mechanised. Every fix, and at the latest every filter.interval, the error model is
// predicted with the averages of the mechanisation; a fix then corrects it. Position, and the vertical
// velocity where the model lacks it, are taken from the fixes.
#pragma once

#include <variant>

#include "AlignmentFilter/variables.hpp"
#include "components/antenna_history.hpp"
#include "components/gnss_input.hpp"
#include "components/imu_input.hpp"
#include "components/log.hpp"
#include "components/navigation_engine.hpp"
#include "components/serialisation.hpp"

namespace truenorth {

class AlignmentFilter {
  public:
    alignment_filter::Parameters parameters;
    alignment_filter::Inputs inputs;
    alignment_filter::Outputs outputs;

    explicit AlignmentFilter(Log& log) : log_(&log) {}

    // Starts at start_time [s]. Throws InvalidParameter.
    void initialise(double start_time);

    // Takes over tunable parameters that have changed. Throws InvalidParameter.
    void retune();

    // Processes what is new at the inputs. Their time stamps count, not the master's steps.
    void step(double time, double step);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, inputs, outputs, imu_, gnss_, history_, travelled_, last_use_, below_since_,
                faulted_);
        if constexpr (Archive::is_loading::value) {
            choose_model();
            configure();
        }
        std::visit([&](auto& engine) { archive(engine); }, engine_);
    }

  private:
    using Engines = std::variant<NavigationEngine<LargeAzimuth>, NavigationEngine<EulerPlatform>>;

    void check() const;   // rules between parameters
    void choose_model();  // engine_ becomes that of error_model
    void configure();     // settings of the engine that follow from the parameters
    void take_sample();
    void take_fix();
    void predict();
    template <class Engine>
    void correct(Engine& engine, const GnssFix& fix, const AntennaState& antenna);
    template <class Engine>
    void publish(const Engine& engine);
    void publish();
    void publish_status();
    void reject_fix(const char* reason);
    void remember_antenna();
    void fault(const char* reason);

    Log* log_;
    ImuInput imu_;
    GnssInput gnss_;
    AntennaHistory history_;
    IntervalAverage travelled_;  // running sum since the start
    Engines engine_;
    double last_use_ = 0.0;     // time of the last fix used, or the start [s]
    double below_since_ = 0.0;  // since when heading_sigma is below the limit [s]; NaN: it is not
    bool faulted_ = false;
};

}  // namespace truenorth
