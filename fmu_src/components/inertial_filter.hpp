// An inertial filter: mechanisation, error model, predictor and corrector behind one interface. What the
// filters of this project have in common, which is all but their models and the way they are started.
//
// Every IMU sample is mechanised. Every fix, and at the latest every filter.interval, the error model is
// predicted with the averages of the mechanisation; a fix then corrects it. A position, or a vertical
// velocity, that the model lacks is taken from the fixes.
//
// A model may begin with a coarse stage, in which fixes are collected rather than filtered.
//
// `Interface` names the generated variables of a component, `Engines` the models that it offers (engine.hpp).
// The definitions stand in inertial_filter_run.hpp and inertial_filter_fix.hpp, for the file of each
// component that instantiates them.
#pragma once

#include <variant>

#include "components/antenna_history.hpp"
#include "components/filter_status.hpp"
#include "components/gnss_input.hpp"
#include "components/imu_input.hpp"
#include "components/log.hpp"
#include "components/navigation_engine.hpp"
#include "components/serialisation.hpp"
#include "estimation/nis_window.hpp"

namespace truenorth {

template <class Interface, class... Engines>
class InertialFilter {
  public:
    typename Interface::Parameters parameters;
    typename Interface::Inputs inputs;
    typename Interface::Outputs outputs;

    explicit InertialFilter(Log& log) : log_(&log) {}

    // Takes over tunable parameters that have changed. Throws InvalidParameter.
    void retune();

    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, inputs, outputs, imu_, gnss_, history_, travelled_, status_, nis_window_,
                under_way_, told_long_interval_);
        if constexpr (Archive::is_loading::value) {
            choose_model();
            configure_engine();
        }
        std::visit([&](auto& engine) { archive(engine); }, engine_);
    }

  protected:
    // Checks the parameters, sets the model up and empties the memory. Throws InvalidParameter.
    void prepare(double start_time);

    // Sets out from here, at the time to which the IMU data reach.
    void set_out(const Start& start);

    // Processes what is new at the inputs. Their time stamps count, not the master's steps.
    void advance();

    void publish();

    [[nodiscard]] bool under_way() const { return under_way_; }  // it has set out
    [[nodiscard]] double now() const { return imu_.time(); }     // to which the IMU data reach [s]
    [[nodiscard]] Log& log() const { return *log_; }

  private:
    void check() const;
    void choose_model();      // engine_ becomes that of error_model
    void configure_engine();  // its settings, as they follow from the parameters
    void watch();             // the inputs, before it has set out
    void take_sample();
    void warn_of_long_interval();
    void take_fix();
    [[nodiscard]] GnssFix fix_at_port() const;
    void predict();
    void report(Prediction prediction);
    template <class E>
    void correct(E& engine, const GnssFix& fix, const AntennaState& then);
    template <class E, class Fix>
    void correct_coarsely(E& engine, const Fix& fix);
    template <class E, class Fix>
    double reconcile(E& engine, const Sighting& seen, const Fix& fix);
    void report_infeasible();
    void question_place(const GnssFix& fix, const AntennaState& then);
    void reject_fix(const char* reason);
    [[nodiscard]] AntennaState antenna() const;
    void fault(const char* reason);
    void publish_status();

    Log* log_;
    ImuInput imu_;
    GnssInput gnss_;
    AntennaHistory history_;
    IntervalAverage travelled_;  // running sum since the start
    FilterStatus status_;
    NisWindow nis_window_;
    bool under_way_ = false;
    bool told_long_interval_ = false;
    std::variant<Engines...> engine_;
};

}  // namespace truenorth
