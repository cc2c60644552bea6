// How an IMU's signals have gone of late, axis by axis: what is usual, and so what is not, and how far off a
// guess at lost data may be.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace truenorth {

class ImuActivity {
  public:
    using Rates =
        Eigen::Array<double, 6, 1>;  // body rate [rad/s], then specific force [m/s2]; right, forward, up

    // Sooner the statistics say nothing.
    static constexpr int kFewest = 50;

    // A jump from one sample to the next beyond so many times the usual one, and beyond the floor, is no
    // motion: Gaussian noise does not reach it, and what shakes a vehicle shakes it more than once.
    static constexpr double kJump = 20.0;
    static constexpr double kRateFloor = 0.2;   // [rad/s]
    static constexpr double kForceFloor = 5.0;  // [m/s2]

    // An axis that repeats its rate or its increment but for rounding (of intervals, too), for longer than
    // kRuns times its longest run so far and kShortestRun, is stuck; one that has never changed says nothing.
    // What is usual is learned by and by: of one run at most twice as much as before, or a fault would be;
    // but at once where all axes stood still together, as those of a vehicle do. Nor is one judged that
    // seldom changes, as without noise.
    static constexpr int kShortestRun = 10;
    static constexpr int kRuns = 5;
    static constexpr int kLearns = 2;
    static constexpr int kMostRun = 100'000'000;
    static constexpr double kSeldom = 0.1;      // of the samples
    static constexpr double kRounding = 1e-12;  // of the value

    // An axis whose usual step is smaller has no noise of a sensor, but rounding.
    static constexpr double kSmallestRate = 1e-9;   // [rad/s]
    static constexpr double kSmallestForce = 1e-8;  // [m/s2]

    // Means of a sound sample that lasted dt [s].
    void add(const Rates& rates, double dt) {
        const Rates step = samples_ > 0 ? Rates(rates - last_) : Rates::Zero();
        const double share_of_step = 1.0 / std::clamp(samples_, 1, kStepSamples);
        known_ = std::min(known_ + dt, kMemory);
        const double share = dt / known_;
        const Rates limit = kRounding * rates.abs();
        const Eigen::Array<bool, 6, 1> repeats =
            step.abs() <= limit || (rates * dt - last_ * last_dt_).abs() <= limit * dt;
        const int together = *std::ranges::min_element(run_);
        // What stands still tells nothing of how it moves.
        Rates moves;
        for (int axis = 0; axis < 6; ++axis) {
            if (!repeats(axis) || run_[axis] < kShortestRun) {
                restless_(axis) += share_of_step * ((repeats(axis) ? 0.0 : 1.0) - restless_(axis));
            }
            const bool stands = repeats(axis) && squared_step_(axis) > 0.0;
            moves(axis) = stands ? 0.0 : 1.0;
            if (!stands && run_[axis] > 0) {
                const int learned = kShortestRun + kLearns * std::max(longest_run_[axis], together);
                longest_run_[axis] = std::max(longest_run_[axis], std::min(run_[axis], learned));
            }
            run_[axis] = stands ? std::min(run_[axis] + 1, kMostRun) : 0;
        }
        const Rates gain = share * moves;
        const Rates off = moves * (rates - mean_);
        squared_step_ += share_of_step * moves * (step.square() - squared_step_);
        mean_ += share * off;
        variance_ = (1.0 - gain) * (variance_ + gain * off * off);
        strayed_ = (1.0 - dt / kMemory * moves) * strayed_ + off * dt;
        squared_stray_ += gain * (strayed_.square() - squared_stray_);
        last_ = rates;
        last_dt_ = dt;
        samples_ = std::min(samples_ + 1, kStepSamples);
    }

    [[nodiscard]] bool knows() const { return samples_ >= kFewest; }

    // Axes on which `rates` is out of line with what came before.
    [[nodiscard]] Eigen::Array<bool, 6, 1> jumps(const Rates& rates) const {
        Rates floor;
        floor << Eigen::Array3d::Constant(kRateFloor), Eigen::Array3d::Constant(kForceFloor);
        return (rates - last_).abs() > (kJump * usual_step()).max(floor);
    }

    // Axes that stand still although they used to move.
    [[nodiscard]] Eigen::Array<bool, 6, 1> stuck() const {
        Eigen::Array<bool, 6, 1> still;
        for (int axis = 0; axis < 6; ++axis) {
            const double smallest = axis < 3 ? kSmallestRate : kSmallestForce;
            still(axis) = squared_step_(axis) > smallest * smallest && restless_(axis) > kSeldom &&
                          run_[axis] > kShortestRun + kRuns * longest_run_[axis];
        }
        return still;
    }

    // For how many samples each axis has stood still.
    [[nodiscard]] Rates run() const {
        return Eigen::Map<const Eigen::Array<int, 6, 1>>(run_.data()).cast<double>();
    }

    [[nodiscard]] const Rates& last() const { return last_; }
    [[nodiscard]] const Rates& mean() const { return mean_; }  // of the last kMemory
    [[nodiscard]] Rates deviation() const { return variance_.sqrt(); }

    // Rates over `count` lost samples before one of `next`: of a gap that is short beside the motion the
    // middle between the samples on its sides, whose errors do not add up from gap to gap; of a longer one
    // the usual ones.
    [[nodiscard]] Rates guess(const Rates& next, double count) const {
        if (!knows()) {
            return next;
        }
        return (count * usual_step() < deviation()).select(0.5 * (last_ + next), mean_);
    }

    // By how much such a guess may be off over the `lost` seconds of these samples [rad], [m/s]. What swings
    // strays no farther than it usually does, in one direction before the gap and in the other after it.
    [[nodiscard]] Rates doubt(const Rates& next, double count, double lost) const {
        if (!knows()) {
            return lost * (next - last_).abs();
        }
        const Rates rate = (count * usual_step()).min(deviation()).max((next - last_).abs().min(deviation()));
        if (known_ < kMemory) {
            return lost * rate;
        }
        return (lost * rate).min(2.0 * squared_stray_.sqrt());
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(last_, last_dt_, mean_, variance_, strayed_, squared_stray_, squared_step_, restless_, known_,
                samples_, run_, longest_run_);
        for (std::array<int, 6>* runs : {&run_, &longest_run_}) {
            for (int& run : *runs) {
                run = std::clamp(run, 0, kMostRun);  // whatever a damaged state says
            }
        }
    }

  private:
    static constexpr double kMemory = 20.0;  // [s]: some periods of a ship's motion
    static constexpr int kStepSamples = 200;

    [[nodiscard]] Rates usual_step() const { return squared_step_.sqrt(); }

    Rates last_ = Rates::Zero();
    double last_dt_ = 0.0;  // [s]
    Rates mean_ = Rates::Zero();
    Rates variance_ = Rates::Zero();
    Rates strayed_ = Rates::Zero();        // what rates beyond the mean have added up to of late [rad], [m/s]
    Rates squared_stray_ = Rates::Zero();  // mean square of it
    Rates squared_step_ = Rates::Zero();   // mean square of the change from sample to sample
    Rates restless_ = Rates::Zero();       // share of the samples that changed, runs left out
    double known_ = 0.0;                   // time that mean and variance stand for [s]
    int samples_ = 0;                      // counted up to kStepSamples
    std::array<int, 6> run_{};             // samples in which the axis has not changed
    std::array<int, 6> longest_run_{};
};

}  // namespace truenorth
