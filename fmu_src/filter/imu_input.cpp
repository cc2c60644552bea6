#include "filter/imu_input.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contract/count_up.hpp"
#include "contract/time_tolerance.hpp"

namespace truenorth {

namespace {

// An interval of so many periods and more has a gap, and a clock that shows less than such a part of an
// interval denies it.
constexpr double kGap = 1.5;
constexpr double kDenied = 0.5;

constexpr int kConfirmations = 3;  // samples in a row that show the same before it is believed

constexpr double kGravity = 9.8;  // about, anywhere on Earth [m/s2]

// From one count to another, whatever overflow lies between.
std::int64_t advance(int from, int to) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - static_cast<std::uint32_t>(from));
}

}  // namespace

ImuInput::Verdict ImuInput::read(int sample, double time, const Eigen::Vector3d& delta_angle,
                                 const Eigen::Vector3d& delta_velocity, double clock) {
    clock_ = std::max(clock_, clock);
    sample = arrival_.number(sample, time);
    if (sample == seen_) {
        return Verdict::stale;
    }
    const std::int64_t since_seen = advance(seen_, sample);
    seen_ = sample;
    if (!std::isfinite(time) || !delta_angle.allFinite() || !delta_velocity.allFinite()) {
        return reject(Finding::not_finite);
    }
    if (delta_angle.isZero(0.0) && delta_velocity.isZero(0.0)) {
        return reject(Finding::dead);
    }
    const double before = any_ || std::isnan(refused_stamp_) ? stamp() : refused_stamp_;
    const Reading reading{
        .count = any_ ? advance(accepted_, sample) : 1, .dt = time - before, .elapsed = clock_ - heard_};
    refused_stamp_ = time;
    if (any_ && !follows(reading, since_seen)) {
        return reject(Finding::old);
    }
    const double force = delta_velocity.norm();
    const Interval interval = any_ ? between(reading, force) : first(reading, force);
    if (interval.covered <= kTimeTolerance) {
        return reject(Finding::old);
    }
    Rates rates;
    rates << delta_angle / interval.covered, delta_velocity / interval.covered;
    const Finding wrong = judge(rates, interval.covered);
    if (wrong != Finding::none) {
        return reject(wrong);
    }
    increment_ = {.dt = interval.covered, .delta_angle = delta_angle, .delta_velocity = delta_velocity};
    learn(interval, rates);
    tell_time(time, reading, interval);
    learn_stride(reading.count, reading.dt);
    period_ = interval.covered;
    accepted_ = sample;
    any_ = true;
    return interval.resumes ? Verdict::resumed : Verdict::accepted;
}

// What no vehicle does, and what is no increment.
ImuInput::Finding ImuInput::judge(const Rates& rates, double covered) {
    if (rates.head<3>().matrix().norm() > kLargestRate || rates.tail<3>().matrix().norm() > kLargestForce) {
        return Finding::impossible;
    }
    const Rates& usual = activity_.knows() ? activity_.mean() : rates;
    if (usual.tail<3>().matrix().norm() <= kLargestMeanForce ||
        rates.tail<3>().matrix().norm() <= kLargestMeanForce) {
        return Finding::none;
    }
    if (activity_.knows()) {
        activity_.add(rates, covered);
    }
    return Finding::no_increment;
}

// Takes the increment to what is known of the sensor; fills in what was lost before it.
void ImuInput::learn(const Interval& interval, Rates rates) {
    finding_ = interval.finding;
    doubtful_angle_.setZero();
    doubtful_velocity_.setZero();
    const double lost = interval.resumes ? 0.0 : interval.lost;
    bridged_ = lost;
    blind_ = interval.resumes ? interval.lost : 0.0;
    if (lost > 0.0) {
        fill(lost, rates);
        activity_.add(rates, interval.covered);
    } else {
        if (!interval.resumes && interval.covered <= kGap * period_) {
            hold_jumps(rates);
        }
        if (finding_ != Finding::jump) {
            activity_.add(rates, interval.covered);
        }
        doubt_what_is_stuck(interval.covered);
    }
    const auto parts = static_cast<int>(std::lround(lost / interval.covered));
    gap_ = period_ > 0.0 ? std::max(parts - refused_, 0) : 0;
    count_up(missed_, gap_);
    refused_ = 0;
}

// The filter's time goes on with what was covered or bridged; a clock that was set is another offset.
void ImuInput::tell_time(double time, const Reading& reading, const Interval& interval) {
    if (interval.finding == Finding::clock_set) {
        time_ += interval.resumes ? std::max(reading.elapsed, interval.covered) : increment_.dt;
        offset_ = time - time_;
    } else {
        time_ = time - offset_;
    }
    if (interval.finding != Finding::none) {
        count_up(disagreements_);
    }
    if (finding_ != Finding::none) {
        suspected_ = clock_;
    }
    heard_ = clock_;
    old_ = 0;
}

ImuInput::Verdict ImuInput::reject(Finding finding) {
    finding_ = finding;
    count_up(rejected_);
    count_up(refused_);
    return Verdict::rejected;
}

// A time that goes back with a count that goes on is that of a clock that was set. With the count, both show
// an old sample, unless they go on from there: a sensor that was switched off and on.
bool ImuInput::follows(const Reading& reading, std::int64_t since_seen) {
    if (reading.dt > kTimeTolerance) {
        return true;
    }
    if (reading.dt >= -kTimeTolerance) {
        return false;
    }
    old_ = since_seen > 0 ? old_ + 1 : 1;
    return reading.count > 0 || old_ >= kConfirmations;
}

// Of the first sample of all, whose stamp may have nothing to do with the start time: then the force tells,
// and the master's clock how long it was waited for.
ImuInput::Interval ImuInput::first(const Reading& reading, double delta_velocity) {
    const double dt = reading.dt;
    const bool plausible = dt > 0.0 && dt <= kLongestInterval && delta_velocity > 0.2 * kGravity * dt &&
                           delta_velocity < kLargestForce * dt;
    if (plausible || delta_velocity == 0.0) {
        return {.covered = dt};
    }
    return {.covered = delta_velocity / kGravity,
            .lost = reading.elapsed > kLongestInterval ? reading.elapsed : 0.0,
            .resumes = true};
}

ImuInput::Interval ImuInput::between(const Reading& reading, double delta_velocity) const {
    const auto& [count, dt, elapsed] = reading;
    const double parts = static_cast<double>(count) / stride_;
    const bool leaps = dt > kGap * period_;
    const bool counted = std::abs(parts * period_ - dt) <= kDenied * period_;
    const bool set = dt <= 0.0 || (leaps && !counted && elapsed < kDenied * dt);
    const bool even = elapsed < kGap * period_;  // neither the clock nor the rate of the samples has a gap
    const double shown = even ? period_ : elapsed;
    const double passed = set ? shown : dt;

    Interval interval{.covered = passed};
    if (passed > kLongestInterval) {
        interval.covered = period_;
        interval.lost = passed - period_;
        interval.resumes = true;
    } else if (passed > kGap * period_ && !spans(passed, delta_velocity, parts)) {
        interval.covered = period_;
        interval.lost = passed - period_;
    }
    if (set) {
        interval.finding = Finding::clock_set;
    } else if (parts > kGap && !leaps) {
        interval.finding = Finding::count_leapt;
    }
    return interval;
}

// An increment covers all of a longer interval, as under a master that takes longer steps, or a period of it,
// after samples that were lost: by the force that it shows, or else by its count.
bool ImuInput::spans(double passed, double delta_velocity, double parts) const {
    if (!activity_.knows()) {
        return parts < kGap;
    }
    if (finding_ == Finding::no_increment) {
        return false;  // of rates, too, the force of a longer interval would be plausible
    }
    double force = activity_.mean().tail<3>().matrix().norm();
    if (parts > kGap && gap_ == 0) {  // in a turn or a pull-up; a late stamp alone shows no more force
        force = std::max(force, activity_.last().tail<3>().matrix().norm());
    }
    return delta_velocity > force * std::sqrt(passed * period_);
}

// A count that has advanced by much the same a few times advances so: of raw samples by 2 and 3 in turn, if
// two and a half make a sample. Where the stamps show a gap, it tells of that.
void ImuInput::learn_stride(std::int64_t count, double dt) {
    const auto advanced = static_cast<double>(count);
    const bool gap = dt > kGap * period_;
    if (gap || count <= 0 || std::abs(advanced - new_stride_) > std::max(0.5 * new_stride_, 1.0)) {
        new_strides_ = 0;
        new_count_ = 0.0;
    }
    new_stride_ = advanced;
    if (gap) {
        return;
    }
    new_count_ += advanced;
    new_strides_ += 1;
    if (new_strides_ >= kConfirmations) {
        stride_ = new_count_ / new_strides_;
        new_strides_ = 0;
        new_count_ = 0.0;
    }
}

// Adds what was lost before the increment.
void ImuInput::fill(double lost, const Rates& rates) {
    const double count = lost / increment_.dt;
    const Rates guess = lost * activity_.guess(rates, count);
    const Rates doubt = activity_.doubt(rates, count, lost);
    increment_.dt += lost;
    increment_.delta_angle += guess.head<3>().matrix();
    increment_.delta_velocity += guess.tail<3>().matrix();
    doubtful_angle_ = doubt.head<3>();
    doubtful_velocity_ = doubt.tail<3>();
}

// On an axis that is out of line the value before is held, until it stays so.
void ImuInput::hold_jumps(Rates& rates) {
    const Eigen::Array<bool, 6, 1> out = activity_.jumps(rates);
    const bool held = activity_.knows() && out.any() && jumps_ < kConfirmations;
    jumps_ = held ? jumps_ + 1 : 0;
    if (!held) {
        return;
    }
    const double dt = increment_.dt;
    const Rates doubt = out.select(dt * (rates - activity_.last()).abs(), 0.0);
    rates = out.select(activity_.last(), rates);
    increment_.delta_angle = dt * rates.head<3>().matrix();
    increment_.delta_velocity = dt * rates.tail<3>().matrix();
    doubtful_angle_ = doubt.head<3>();
    doubtful_velocity_ = doubt.tail<3>();
    finding_ = Finding::jump;
}

// What an axis that stands still leaves out adds up: after T seconds to T times what is usual on it, and how
// far from that it stands. It is found out late, and is doubted from its first repetition on.
void ImuInput::doubt_what_is_stuck(double covered) {
    const Eigen::Array<bool, 6, 1> stuck = activity_.stuck();
    if (!stuck.any()) {
        stuck_for_.setZero();
        return;
    }
    const Rates before = stuck_for_;
    stuck_for_ = stuck.select(covered * activity_.run(), 0.0);
    const Rates usual =
        (activity_.deviation().square() + (activity_.last() - activity_.mean()).square()).sqrt();
    const Rates doubt = stuck.select(usual * (stuck_for_.square() - before.square()).max(0.0).sqrt(), 0.0);
    doubtful_angle_ += doubt.head<3>().matrix();
    doubtful_velocity_ += doubt.tail<3>().matrix();
    finding_ = Finding::stuck;
}

}  // namespace truenorth
