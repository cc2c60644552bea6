// AlignmentFilter: mechanisation, error model, predictor and corrector behind one interface.
//
// Every IMU sample is mechanised. Every fix, and at the latest every filter.interval, the error model is
// predicted with the averages of the mechanisation; a fix then corrects it. With feedback the estimate
// corrects the mechanisation and starts again from zero; without, the mechanisation runs open loop and the
// outputs alone are corrected. Position and vertical velocity, which the 10-state model does not have, are
// taken from the fixes.
#pragma once

#include "AlignmentFilter/variables.hpp"
#include "components/antenna_history.hpp"
#include "components/gnss_input.hpp"
#include "components/imu_input.hpp"
#include "components/log.hpp"
#include "components/serialisation.hpp"
#include "error_models/large_azimuth.hpp"
#include "estimation/estimator.hpp"
#include "estimation/h_infinity.hpp"
#include "estimation/innovation_gate.hpp"

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
        archive(parameters, inputs, outputs, imu_, gnss_, mechanisation_, average_, history_, estimator_,
                gyro_bias_, accelerometer_bias_, fed_back_, last_use_, below_since_, faulted_);
        if constexpr (Archive::is_loading::value) {
            configure();
        }
    }

  private:
    using Model = LargeAzimuth;

    void configure();
    void take_sample();
    void take_fix();
    void predict();
    void correct(const GnssFix& fix, const AntennaState& antenna);
    [[nodiscard]] Correction<Model::kStates, Model::kMeasurements> corrected(
        const Innovation<Model::kStates, Model::kMeasurements>& innovation);
    void feed_back();
    void reject_fix(const char* reason);
    void remember_antenna();
    void fault(const char* reason);
    void publish();
    void publish_status();

    Log* log_;
    ImuInput imu_;
    GnssInput gnss_;
    Mechanisation mechanisation_;
    IntervalAverage average_;
    AntennaHistory history_;
    Estimator<Model> estimator_;
    Vector<Model::kStates> prior_sigma_ = Vector<Model::kStates>::Ones();  // follows from the parameters
    InnovationGate gate_;                                                  // likewise
    Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();                  // fed back so far [rad/s]
    Eigen::Vector3d accelerometer_bias_ = Eigen::Vector3d::Zero();         // fed back so far [m/s2]
    Eigen::Vector3d fed_back_ = Eigen::Vector3d::Zero();  // misalignment that the last fix found [rad]
    double last_use_ = 0.0;                               // time of the last fix used, or the start [s]
    double below_since_ = 0.0;  // since when heading_sigma is below the limit [s]; NaN: it is not
    bool faulted_ = false;
};

}  // namespace truenorth
