// Reads an IMU port: decides whether its increments are new, stale, incomplete or impossible.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "inertial/mechanisation.hpp"

namespace truenorth {

class ImuInput {
  public:
    // `resumed`: accepted, but what happened before it since the sample before is unknown.
    enum class Verdict { stale, accepted, resumed, rejected };

    // Beyond these no vehicle that carries people or instruments goes; a value beyond them is a fault of the
    // data.
    static constexpr double kLargestRate = 50.0;     // [rad/s]
    static constexpr double kLargestForce = 2000.0;  // [m/s2]
    // Over a longer interval no increment and no mean rate describes the motion of a vehicle.
    static constexpr double kLongestInterval = 10.0;  // [s]

    void start(double time) {
        *this = ImuInput{};
        time_ = time;
    }

    // `sample` counts the increments that the sensor put out. A count that has advanced by more than one
    // means that increments were missed: the new ones are then taken as the mean of the whole gap. A time
    // that leaps by more than kLongestInterval is believed only when the next sample confirms it.
    Verdict read(int sample, double time, const Eigen::Vector3d& delta_angle,
                 const Eigen::Vector3d& delta_velocity);

    [[nodiscard]] const ImuIncrement& increment() const { return increment_; }  // the last one accepted
    [[nodiscard]] double time() const { return time_; }  // end of the last accepted increment, or the start
    [[nodiscard]] bool any() const { return any_; }      // a sample has been accepted
    [[nodiscard]] int gap() const { return gap_; }  // increments missed just before the last accepted one
    // Of the part of the last accepted increment that was filled in: by how much it would differ had the gap
    // been filled with the rates before it; angle [rad] and velocity [m/s]. Zero when nothing was.
    [[nodiscard]] double doubtful_angle() const { return doubtful_angle_; }
    [[nodiscard]] double doubtful_velocity() const { return doubtful_velocity_; }
    [[nodiscard]] int rejected() const { return rejected_; }
    [[nodiscard]] int missed() const { return missed_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(increment_, time_, any_, gap_, seen_, accepted_, rejected_, rejected_since_, missed_,
                leap_sample_, leap_time_, doubtful_angle_, doubtful_velocity_);
    }

  private:
    ImuIncrement increment_;
    double time_ = 0.0;
    bool any_ = false;
    int gap_ = 0;
    int seen_ = 0;      // sample count last looked at
    int accepted_ = 0;  // sample count last accepted
    int rejected_ = 0;
    int rejected_since_ = 0;  // since the last accepted one
    int missed_ = 0;
    double doubtful_angle_ = 0.0;
    double doubtful_velocity_ = 0.0;
    int leap_sample_ = 0;  // of the last sample, if it was rejected because its time leapt
    double leap_time_ = std::numeric_limits<double>::quiet_NaN();  // likewise [s]; NaN: it did not
};

}  // namespace truenorth
