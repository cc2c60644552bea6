// Reads an IMU port: decides which samples are new and sound, how much time each covers, and what is known of
// the time in between.
//
// The time stamps say how much time an increment covers. The sample count says only that a sample is new
// (without one a new stamp does, arrival.hpp), and the master's clock, on which silence is measured, how much
// time can have passed at all. Where the three do not agree, two of them are right:
//
//   the count leaps, the stamps do not        samples were numbered, not lost
//   the stamps leap, the clock does not       the sensor's clock was set: what follows goes on from there
//   stamps and count leap, and so does the clock   samples were lost: the gap is bridged
//
// Times of the filter are those of the stamps until they are first set; from then on the filter's time goes
// on evenly, and `stamp` translates.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>

#include "filter/arrival.hpp"
#include "filter/imu_activity.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

class ImuInput {
  public:
    // `resumed`: accepted, but what happened before it since the sample before is unknown.
    enum class Verdict { stale, accepted, resumed, rejected };

    // What a sample shows besides; Doubt::none of a sound one.
    enum class Finding {
        none,
        not_finite,    // a value is not finite
        impossible,    // beyond what any vehicle does
        dead,          // no rate and no force at all, to the bit
        old,           // its time does not follow
        no_increment,  // forces as of rates put out in place of increments
        jump,          // an axis leapt out of line; its value before was held
        stuck,         // an axis stands still
        count_leapt,   // the count leapt, the stamps did not
        clock_set,     // the stamps leapt, and neither the master's clock nor the rate of the samples did
    };

    // Beyond these no vehicle that carries people or instruments goes; a value beyond them is a fault of the
    // data.
    static constexpr double kLargestRate = 50.0;     // [rad/s]
    static constexpr double kLargestForce = 2000.0;  // [m/s2]
    // Of the mean of twenty seconds, and of the first samples. Rates put out in place of increments are
    // beyond.
    static constexpr double kLargestMeanForce = 80.0;  // [m/s2]
    // Over a longer interval no increment and no mean rate describes the motion of a vehicle.
    static constexpr double kLongestInterval = 10.0;  // [s]

    void start(double time) {
        *this = ImuInput{};
        time_ = time;
        clock_ = time;
        heard_ = time;
    }

    // `clock` is the master's time [s], which does not go back.
    Verdict read(int sample, double time, const Eigen::Vector3d& delta_angle,
                 const Eigen::Vector3d& delta_velocity, double clock);

    [[nodiscard]] const ImuIncrement& increment() const { return increment_; }  // the last one accepted
    [[nodiscard]] double time() const { return time_; }  // end of the last accepted increment, or the start
    [[nodiscard]] double stamp() const { return time_ + offset_; }  // likewise, as the sensor's clock has it
    [[nodiscard]] double offset() const { return offset_; }         // of the sensor's clock [s]
    [[nodiscard]] bool any() const { return any_; }                 // a sample has been accepted
    [[nodiscard]] Arrival& arrival() { return arrival_; }           // how samples come
    [[nodiscard]] int gap() const { return gap_; }  // increments missed just before the last accepted one
    // What the last accepted increment made up, for samples that did not come or were refused [s].
    [[nodiscard]] double bridged() const { return bridged_; }
    [[nodiscard]] double blind_for() const { return blind_; }   // before it, of a gap that is not bridged [s]
    [[nodiscard]] Finding finding() const { return finding_; }  // of the last sample that was not stale
    // By how much the last accepted increment may be off beyond what the sensors' noise explains, body axes
    // [rad], [m/s]; zero when nothing was made up.
    [[nodiscard]] const Eigen::Vector3d& doubtful_angle() const { return doubtful_angle_; }
    [[nodiscard]] const Eigen::Vector3d& doubtful_velocity() const { return doubtful_velocity_; }
    [[nodiscard]] int rejected() const { return rejected_; }
    [[nodiscard]] int missed() const { return missed_; }
    [[nodiscard]] int disagreements() const { return disagreements_; }  // of stamps, count and clock

    // Since the last accepted sample, by the master's clock [s].
    [[nodiscard]] double silent_for() const { return clock_ - heard_; }
    // For longer than this the IMU is silent rather than slow [s].
    [[nodiscard]] double patience() const { return std::max(10.0 * period_, 0.5); }
    // When the last sample came that was accepted with a finding, by the master's clock [s].
    [[nodiscard]] double suspected() const { return suspected_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(increment_, time_, offset_, clock_, heard_, suspected_, any_, gap_, bridged_, blind_, seen_,
                accepted_, refused_, refused_stamp_, rejected_, missed_, disagreements_, period_, stride_,
                new_stride_, new_count_, new_strides_, jumps_, old_, doubtful_angle_, doubtful_velocity_,
                stuck_for_, finding_, activity_, arrival_);
        new_strides_ = std::clamp(new_strides_, 0, 2);  // whatever a damaged state says
    }

  private:
    using Rates = ImuActivity::Rates;

    struct Reading {
        std::int64_t count;  // of the sample, since the last accepted one
        double dt;           // by the stamps [s]
        double elapsed;      // by the master's clock [s]
    };
    // How much time a sample covers, and what of it was lost.
    struct Interval {
        double covered = 0.0;  // by the increments [s]
        double lost = 0.0;     // before [s]
        bool resumes = false;
        Finding finding = Finding::none;
    };

    [[nodiscard]] static Interval first(const Reading& reading, double delta_velocity);
    [[nodiscard]] Interval between(const Reading& reading, double delta_velocity) const;
    [[nodiscard]] bool spans(double passed, double delta_velocity, double parts) const;
    [[nodiscard]] bool follows(const Reading& reading, std::int64_t since_seen);
    Finding judge(const Rates& rates, double covered);
    void learn(const Interval& interval, Rates rates);
    void tell_time(double time, const Reading& reading, const Interval& interval);
    void learn_stride(std::int64_t count, double dt);
    void fill(double lost, const Rates& rates);
    void hold_jumps(Rates& rates);
    void doubt_what_is_stuck(double covered);
    Verdict reject(Finding finding);

    ImuIncrement increment_;
    double time_ = 0.0;
    double offset_ = 0.0;
    double clock_ = 0.0;
    double heard_ = 0.0;
    double suspected_ = -1e300;
    bool any_ = false;
    int gap_ = 0;
    double bridged_ = 0.0;
    double blind_ = 0.0;
    int seen_ = 0;      // sample count last looked at
    int accepted_ = 0;  // sample count last accepted
    int refused_ = 0;   // since the last accepted one
    double refused_stamp_ =
        std::numeric_limits<double>::quiet_NaN();  // of the last one, before any was accepted
    int rejected_ = 0;
    int missed_ = 0;
    int disagreements_ = 0;
    double period_ = 0.0;      // that a sample covered last [s]; 0: none so far
    double stride_ = 1.0;      // by which the count advances from sample to sample, on average
    double new_stride_ = 1.0;  // by which it advanced at the last sample
    double new_count_ = 0.0;   // and at the last new_strides_ ones, all much alike
    int new_strides_ = 0;
    int jumps_ = 0;  // samples in a row with an axis out of line
    int old_ = 0;    // samples in a row whose time does not follow that of the last accepted one
    Eigen::Vector3d doubtful_angle_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d doubtful_velocity_ = Eigen::Vector3d::Zero();
    Rates stuck_for_ = Rates::Zero();  // [s]
    Finding finding_ = Finding::none;
    ImuActivity activity_;
    Arrival arrival_;
};

}  // namespace truenorth
