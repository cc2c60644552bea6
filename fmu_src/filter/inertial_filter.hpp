// An inertial filter: mechanisation, error model, predictor and corrector behind one interface. What the
// filters of this project have in common, which is all but their models and the way they are started.
//
// Every IMU sample is mechanised. Every fix, and at the latest every filter.interval, the error model is
// predicted with the averages of the mechanisation; a fix then corrects it. A position, or a vertical
// velocity, that the model lacks is taken from the fixes.
//
// A model may begin with a coarse stage, in which fixes are collected rather than filtered.
//
// What the filter says of its health runs on the master's clock. A fix waits for the IMU sample that covers
// it; a filter whose gate refuses one fix after another is on a way back that does not end (recovery.hpp).
//
// `Interface` names the generated variables of a component, `Engines` the models that it offers (engine.hpp).
// The definitions stand in inertial_filter_run.hpp, _fix.hpp, _aid.hpp and _health.hpp, for the files of each
// component that instantiate them, one each, so that none takes long to compile.
#pragma once

#include <optional>
#include <variant>

#include "contract/log.hpp"
#include "contract/repetition.hpp"
#include "contract/serialisation.hpp"
#include "estimation/nis_window.hpp"
#include "filter/aid_memory.hpp"
#include "filter/aids.hpp"
#include "filter/antenna_history.hpp"
#include "filter/attitude_ledger.hpp"
#include "filter/filter_events.hpp"
#include "filter/filter_status.hpp"
#include "filter/gnss_input.hpp"
#include "filter/heading_finder.hpp"
#include "filter/imu_input.hpp"
#include "filter/navigation_engine.hpp"
#include "filter/recovery.hpp"
#include "filter/standstill.hpp"
#include "filter/waiting_fixes.hpp"

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
        archive(parameters, inputs, outputs, imu_, gnss_, waiting_, history_, travelled_, status_,
                nis_window_, recovery_, finder_, ledger_, opened_, clock_, forgetting_, last_fix_, under_way_,
                learned_, was_sure_, told_long_interval_, told_samples_, told_fixes_, told_notices_,
                gnss_used_, gnss_every_, gnss_heard_, leveller_, astray_, astray_at_, leaned_, aids_,
                standstill_, far_place_, far_since_, placed_);
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

    // Processes what is new at the inputs in a step of the master that begins at `time` [s]. Their time
    // stamps count; the master's clock tells what does not come, and with imu.each_step when a sample ends.
    void advance(double time, double step);

    void publish();

    [[nodiscard]] bool under_way() const { return under_way_; }  // it has set out
    [[nodiscard]] double now() const {
        return imu_.stamp();
    }  // to which the IMU data reach, by its clock [s]
    [[nodiscard]] Log& log() const { return *log_; }

  private:
    using Port = decltype(Interface::Inputs::gnss);
    using ImuPort = decltype(Interface::Inputs::imu);

    void check() const;
    void choose_model();      // engine_ becomes that of error_model
    void configure_engine();  // its settings, as they follow from the parameters
    void tell_what_has_no_effect() const;
    [[nodiscard]] ImuPort imu_port(double time) const;
    bool watch(const ImuPort& port);  // and the other inputs, while there is no estimate
    void start_over();
    bool take_sample(const ImuPort& port);
    void tell_of(ImuInput::Verdict verdict, const ImuPort& port);
    void tell_what_is_missing();
    [[nodiscard]] bool uncounted() { return parameters.imu.each_step || imu_.arrival().by_stamps(); }
    void warn_of_long_interval();
    bool take_aids(bool sampled);
    void watch_for_standstill();
    [[nodiscard]] bool may_stand() const;
    template <class Aid>
    bool take_aid(const Aid& aid, AidMemory& memory);
    template <class Aid>
    bool take_own(const Aid& aid, const OwnMotion& motion, AidMemory& memory);
    template <class Subject>
    bool refuse_aid(AidMemory& memory, Refusal refusal, const Subject& subject);
    template <class Aid>
    std::optional<Refusal> use_aid(const Aid& aid, const Eigen::Vector3d& measured,
                                   const Eigen::Vector3d& sigma, const AntennaState& then, AidMemory& memory);
    template <class E, class Aid>
    std::optional<Refusal> correct_by(E& engine, const Aid& aid, const Eigen::Vector3d& measured,
                                      const Eigen::Vector3d& sigma, const AntennaState& then,
                                      AidMemory& memory);
    template <class E>
    std::optional<Refusal> correct_with(E& engine, const aiding::Sight<E::kStates>& sight, AidMemory& memory,
                                        bool binds_velocity);
    template <class E>
    void turned_far(E& engine, const Eigen::Matrix3d& rotation);
    template <class E>
    void recover_by(E& engine, const AidDoubt& doubt, AidMemory& memory);
    template <class E, class Aid>
    void take_as_it_is(E& engine, const Eigen::Quaterniond& q_bn, const Eigen::Vector3d& difference);
    template <class Aid>
    void note_use_of(AidMemory& memory, const Eigen::Vector3d& measured);
    bool take_fix();
    bool read_fix();
    void use(const Port& port, double valid_at);
    [[nodiscard]] static GnssFix fix_at(const Port& port);
    [[nodiscard]] GnssFix filled(const GnssFix& fix) const;
    void predict();
    void report(Prediction prediction);
    template <class E>
    void correct(E& engine, const Port& port, const GnssFix& fix, const GnssFix::Mask& measured,
                 const AntennaState& then);
    template <class E>
    void take(E& engine, const typename E::Correction& correction, const GnssFix& fix,
              const GnssFix::Mask& measured, const AntennaState& then);
    template <class E, class Fix>
    void correct_coarsely(E& engine, const Fix& fix, const Port& port);  // of position and velocity
    void turn(const Eigen::Matrix3d& rotation);
    void follow(const Change& change);
    template <class E, class Residual>
    void recover(E& engine, const Sighting& seen, const Residual& residual);
    template <class E>
    [[nodiscard]] Change proposed(double angle, bool directed, const Discrepancy& off) const;
    template <class E>
    void start_again_at_fix(E& engine, bool another, bool directed, const Discrepancy& off);
    template <class E>
    void blame(E& engine, Cause cause, const Discrepancy& off, double mean_square);
    void note_use(const GnssFix::Mask& measured);
    template <class E>
    void open_ledger(const E& engine);
    template <class E>
    void scale(E& engine);
    void report_infeasible();
    void question_place(const GnssFix& fix, const AntennaState& then);
    bool is_within_reach(const GnssFix& fix, const AntennaState& then);
    void reject_fix(Refusal refusal, const Port& port);
    void give_up_waiting();
    [[nodiscard]] AntennaState antenna() const;
    [[nodiscard]] StampClock::Moment moment(double slack) const;
    void fault(const char* reason);
    [[nodiscard]] bool alone() const;
    [[nodiscard]] double wait_for_fix() const;
    template <class E>
    void start_again_level(E& engine, double angle);
    template <class E>
    void doubt_sensors(E& engine);
    template <class E>
    void doubt_attitude(E& engine);
    template <class E>
    void go_astray(E& engine);
    void publish_if_possible();
    template <class E>
    void publish(const E& engine, const NavigationState& best);
    void publish_health();
    [[nodiscard]] AttitudeLedger::Gyros gyros() const;
    [[nodiscard]] Contradiction contradiction(const AttitudeLedger::Gyros& gyros) const;
    void publish_status();

    Log* log_;
    ImuInput imu_;
    GnssInput gnss_;
    WaitingFixes<Port> waiting_;
    AntennaHistory history_;
    IntervalAverage travelled_;  // running sum since the start
    FilterStatus status_;
    NisWindow nis_window_;
    Recovery recovery_;
    HeadingFinder finder_;
    HeadingFinder leveller_;  // of a log, which turns with the computed attitude: it tells the tilt alone
    AttitudeLedger ledger_;
    double opened_ = 0.0;        // when it was, by the filter's clock [s]
    double clock_ = 0.0;         // the master's [s]
    double forgetting_ = 0.0;    // for how long the H-infinity term has acted [s]
    double last_fix_ = 0.0;      // by the filter's clock, when a fix was used last, or the start [s]
    double gnss_used_ = 0.0;     // likewise, by the master's clock [s]
    double gnss_every_ = 0.0;    // between the last two that were used [s]
    double gnss_heard_ = 0.0;    // by the master's clock, when one came that could be compared [s]
    double astray_ = 0.0;        // by how much the position may have gone, on the way back without fixes [m]
    double astray_at_ = 0.0;     // when that was reckoned last [s]
    double leaned_ = 0.0;        // by the filter's clock, when the ledger was told last how it may lean [s]
    earth::Position far_place_;  // of fixes that are out of reach
    double far_since_ = 0.0;     // when they began to be there, by the master's clock [s]
    double placed_ = 0.0;        // when the first fix told where it is, likewise; infinite: none has [s]
    bool under_way_ = false;
    bool learned_ = true;    // what is not told yet
    bool was_sure_ = false;  // of its attitude, since it set out or that was in doubt
    bool told_long_interval_ = false;
    Repetition<kFindings> told_samples_;
    Repetition<kRefusals> told_fixes_;
    Repetition<kNotices> told_notices_;
    Aids aids_;
    Standstill standstill_;
    std::variant<Engines...> engine_;
};

}  // namespace truenorth
