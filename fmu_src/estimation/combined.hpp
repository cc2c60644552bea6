// Corrector that tells, with a delay, why innovations are too large, and blames what is to be blamed alone.
//
// A measurement that its covariance does not explain is held back. `patience` of them in a row are no
// outliers, and what is left is told apart by how innovations follow one another. With r_k the residual that
// the last measurement left behind (of one that was held back, its innovation), the innovation
// v_k = z_k - H x_k grows in an interval by
//
//     d_k = v_k - r_(k-1) = e_k - e_(k-1) + what the prediction is off by in this interval,
//
// and of the noise e alone d_k - d_(k-1) has the variance R_k + 4 R_(k-1) + R_(k-2): an error of the
// prediction that goes on as it began (a bias, a tilt, an acceleration that is not measured) cancels.
//
//   noise   The noise that the second differences show explains the innovation: R is scaled.
//   lie     Positions are off and velocities are not, or velocities by what would have led to another place:
//           no prediction goes wrong like that, and the measurement is held back further.
//   motion  The mean of the last d_k is beyond what noise and covariance explain in an interval, and beyond
//           the scatter of the d_k: something moves the vehicle that the sensors do not measure, or they
//           measure what does not.
//   start   The d_k are as they should be: the error is older, or has grown slowly, and the prediction was
//           wrong from the start.
//   noise   Anything else that the limit allows: larger than the last differences showed.
//
// Differences of two measurements of one quantity tell R whatever the filter believes ("redundant
// measurement", Remote Sensing 12(21), 3500, 2020); here the second measurement is the prediction.
//
// The scale of R is estimated all the time, for positions and velocities apart, with a memory of so many
// measurements; it acts from kActs on and never below 1. Nothing is believed beyond `limit` times the
// nominal sigma.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimation/gaussian.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/standard.hpp"
#include "settings/correction.hpp"

namespace truenorth {

// Why the last innovation was too large; from `start` on the prediction is blamed.
enum class Cause : std::uint8_t {
    none,     // it was not
    unknown,  // the measurement is held back
    noise,    // of the measurements: it was used, with a noise that has grown
    start,    // a prediction that was wrong from the start, or
    motion,   // a motion that was not measured: to be used when the prediction has been made uncertain in it
};

template <int M>
class Combined : public settings::Combined {
  public:
    using settings::Combined::operator=;

    int positions = M / 2;  // channels that come first; the others are velocities, of these if as many
    double interval = 0.0;  // since the last measurement that was used, for the next one [s]
    bool may_blame = true;  // the prediction, at the next one
    bool sure = true;       // of the attitude, which otherwise explains any motion

    // `open`: the measurement is used whatever its innovation.
    template <int N>
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation,
                             const InnovationGate& gate, bool open);

    [[nodiscard]] Cause cause() const { return cause_; }

    // What is known of a channel belongs to another source (satellite) from now on.
    void restart(int channel) { seen_(channel) = 0.0; }
    void restart() {
        seen_.setZero();
        steps_.setZero();
        ratios_.setOnes();
        stepped_ = 0;
        compared_ = 0;
        weight_.setZero();
        sum_.setZero();
        refused_ = 0;
        explained_ = 0;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(residual_, left_, gained_, before_, noise_, steps_, ratios_, seen_, stepped_, compared_,
                weight_, sum_, refused_, explained_);
        for (int* count : {&stepped_, &compared_, &explained_}) {
            *count = std::clamp(*count, 0, kRecent);  // whatever a damaged state says
        }
        refused_ = std::clamp(refused_, 0, patience + 2);
    }

  private:
    using Array = Eigen::Array<double, M, 1>;
    using PerGroup = Eigen::Array2d;  // positions, velocities

    static constexpr int kRecent = 3;        // measurements from which a change is told
    static constexpr double kActs = 1.6;     // scale of R below which nothing is scaled
    static constexpr double kNominal = 5.0;  // measurements' worth of trust in the nominal R
    static constexpr double kLasting = 4.0;  // by how much the newest difference may be smaller than the mean

    static constexpr double kFar = 4.0;  // sigmas of a position that nothing explains

    // Mean squares of steps, in terms of what explains them.
    static constexpr double kSlow = 3.0;     // they are as they should be
    static constexpr double kAbrupt = 12.0;  // a trend that neither noise nor a wrong attitude makes,
    static constexpr double kPlain = 8.0;    // in terms of the scatter of the steps: plainly,
    static constexpr double kTrend = 4.0;    // and when there has been time enough. Less is none

    // What an innovation says together with those before it.
    struct Look {
        Array step = Array::Zero();    // d_k
        Array gained = Array::Zero();  // variance of the prediction, in the interval
        PerGroup ratio = PerGroup::Ones();
        PerGroup channels = PerGroup::Zero();  // of which the ratio is
        bool stepped = false;                  // the step is known
        bool compared = false;                 // and its difference from the one before
    };

    [[nodiscard]] int group(int channel) const { return channel < positions ? 0 : 1; }

    template <int N>
    [[nodiscard]] Look look(const Innovation<N, M>& innovation) const;

    // Keeps what was seen, and what is left of the innovation: of its residual and of its variance.
    template <int N>
    void remember(const Look& look, const Innovation<N, M>& innovation, const Array& residual,
                  const Array& left);

    [[nodiscard]] PerGroup scale() const {
        const PerGroup estimate = (sum_ + kNominal) / (weight_ + kNominal);
        return (estimate > kActs).select(estimate, 1.0).min(limit * limit);
    }

    // The mean over the last measurements, this one included.
    [[nodiscard]] PerGroup recent_scale(const Look& look) const {
        const PerGroup sum = ratios_.template rightCols<kRecent - 1>().rowwise().sum().array() + look.ratio;
        return (sum / kRecent).min(limit * limit);
    }

    template <int N>
    [[nodiscard]] Innovation<N, M> scaled(Innovation<N, M> innovation, const PerGroup& scale) const {
        for (int i = 0; i < M; ++i) {
            if (innovation.present(i)) {
                const double growth = std::sqrt(scale(group(i)));
                innovation.noise.row(i) *= growth;
                innovation.noise.col(i) *= growth;
            }
        }
        return innovation;
    }

    template <int N>
    [[nodiscard]] bool velocity_explained(Innovation<N, M> innovation, const InnovationGate& gate) const {
        for (int i = 0; i < positions; ++i) {
            innovation.remove(i);
        }
        return gate.explains(nis(innovation), innovation.channels());
    }

    // Whether positions are off as far as velocities lead that have been off for half of the interval.
    template <int N>
    [[nodiscard]] bool place_follows(const Innovation<N, M>& innovation) const;

    // Mean square of the mean of the last steps of velocities, in terms of what explains it.
    template <int N>
    [[nodiscard]] double trend(const Look& look, const Innovation<N, M>& innovation) const;

    // The mean square of the last steps is what it should be.
    template <int N>
    [[nodiscard]] bool slow(const Look& look, const Innovation<N, M>& innovation) const;

    // Mean square of an innovation in terms of its noise.
    template <int N>
    [[nodiscard]] PerGroup square_of(const Innovation<N, M>& innovation) const {
        const Array ratio = innovation.residual.array().square() / innovation.noise.diagonal().array();
        const auto mean = [&](int first, int count) {
            const auto present = innovation.present.segment(first, count);
            return present.select(ratio.segment(first, count), 0.0).sum() /
                   std::max<double>(1.0, present.count());
        };
        return {mean(0, positions), mean(positions, M - positions)};
    }

    Cause led_away(double plainly, double scattered);
    void take(const PerGroup& grown);

    // What explains an innovation that is no outlier; R is scaled if it is the noise.
    template <int N>
    Cause told_apart(const Look& look, const Innovation<N, M>& innovation, const InnovationGate& gate);

    Cause blamed(Cause cause) {
        if (!may_blame) {
            return Cause::unknown;
        }
        refused_ = 0;
        return cause;
    }

    // Two of them more than it takes, if it is not clear by then.
    [[nodiscard]] bool may_wait() const { return refused_ < patience + 2; }

    Array residual_ = Array::Zero();                          // r
    Array left_ = Array::Zero();                              // variance that goes with it, of the prediction
    Array gained_ = Array::Zero();                            // in the interval before
    Array before_ = Array::Zero();                            // R, of the measurement before the last one
    Array noise_ = Array::Zero();                             // and of that
    Matrix<M, kRecent> steps_ = Matrix<M, kRecent>::Zero();   // d, the newest last
    Matrix<2, kRecent> ratios_ = Matrix<2, kRecent>::Ones();  // of the squares of the second differences
    Array seen_ = Array::Zero();                              // times in a row, up to 2
    int stepped_ = 0;                                         // steps that are known, up to kRecent
    int compared_ = 0;                                        // ratios that are known, up to kRecent
    PerGroup weight_ = PerGroup::Zero();                      // of the ratios that were learned,
    PerGroup sum_ = PerGroup::Zero();                         // and they, summed
    int refused_ = 0;                                         // in a row
    int explained_ = 0;                                       // in a row, up to kRecent
    Cause cause_ = Cause::none;
};

template <int M>
template <int N>
Correction<N, M> Combined<M>::correct(const Matrix<N>& prior, const Innovation<N, M>& innovation,
                                      const InnovationGate& gate, bool open) {
    const Look seen = look(innovation);
    const auto explains = [&gate](const Innovation<N, M>& one) {
        return gate.explains(nis(one), one.channels());
    };
    cause_ = Cause::none;
    Innovation<N, M> used = scaled(innovation, scale());
    if (open || explains(used)) {
        explained_ = open ? 0 : std::min(explained_ + 1, kRecent);
        refused_ = 0;
        if (explained_ == kRecent && seen.compared) {
            const double keep = 1.0 - 1.0 / memory;
            weight_ = keep * weight_ + 1.0;
            sum_ = keep * sum_ + seen.ratio;
        }
    } else {
        explained_ = 0;
        refused_ = std::min(refused_ + 1, patience + 2);
        cause_ = refused_ < patience ? Cause::unknown : told_apart(seen, innovation, gate);
        if (cause_ == Cause::unknown) {
            remember(seen, innovation, innovation.residual, innovation.spread.diagonal());
        }
        if (cause_ != Cause::noise) {
            return {Vector<N>::Zero(), prior, Vector<M>::Zero(), innovation.noise};
        }
        used = scaled(innovation, scale());
    }
    const Correction<N, M> correction = Standard().correct(prior, used);
    const Eigen::LLT<Matrix<M>> S(used.spread + used.noise);
    const Vector<M> residual = used.noise.lazyProduct(S.solve(used.residual));
    Matrix<M> whitened = used.noise;
    S.matrixL().solveInPlace(whitened);
    remember(seen, innovation, residual,
             used.noise.diagonal() - whitened.colwise().squaredNorm().transpose());
    return correction;
}

template <int M>
template <int N>
auto Combined<M>::look(const Innovation<N, M>& innovation) const -> Look {
    Look seen;
    seen.ratio.setZero();
    for (int i = 0; i < M; ++i) {
        if (!innovation.present(i) || seen_(i) < 1.0) {
            continue;
        }
        seen.stepped = true;
        seen.step(i) = innovation.residual(i) - residual_(i);
        seen.gained(i) = std::max(innovation.spread(i, i) - left_(i), 0.0);
        if (seen_(i) > 1.0) {
            const double difference = seen.step(i) - steps_(i, kRecent - 1);
            const double variance =
                innovation.noise(i, i) + 4.0 * noise_(i) + before_(i) + 2.0 * (seen.gained(i) + gained_(i));
            seen.ratio(group(i)) += difference * difference / variance;
            seen.channels(group(i)) += 1.0;
        }
    }
    seen.compared = (seen.channels > 0.0).any();
    seen.ratio = (seen.channels > 0.0).select(seen.ratio / seen.channels.max(1.0), 1.0);
    return seen;
}

template <int M>
template <int N>
void Combined<M>::remember(const Look& look, const Innovation<N, M>& innovation, const Array& residual,
                           const Array& left) {
    const auto push = [](auto& columns, const auto& newest) {
        columns.leftCols(kRecent - 1) = columns.rightCols(kRecent - 1).eval();
        columns.col(kRecent - 1) = newest;
    };
    if (look.stepped) {
        push(steps_, look.step.matrix());
        gained_ = look.gained;
        stepped_ = std::min(stepped_ + 1, kRecent);
    }
    if (look.compared) {
        push(ratios_, look.ratio.matrix());
        compared_ = std::min(compared_ + 1, kRecent);
    }
    residual_ = residual;
    left_ = left;
    before_ = noise_;
    noise_ = innovation.noise.diagonal();
    for (int i = 0; i < M; ++i) {
        seen_(i) = innovation.present(i) ? std::min(seen_(i) + 1.0, 2.0) : 0.0;
    }
}

template <int M>
template <int N>
bool Combined<M>::place_follows(const Innovation<N, M>& innovation) const {
    for (int i = 0; i < std::min(positions, M - positions); ++i) {
        const int rate = positions + i;
        if (innovation.present(i) && innovation.present(rate)) {
            const double sigma = std::sqrt(innovation.spread(i, i) + innovation.noise(i, i));
            const double led = 0.5 * interval * std::abs(innovation.residual(rate));
            if (led > std::abs(innovation.residual(i)) + kFar * sigma) {
                return false;
            }
        }
    }
    return true;
}

template <int M>
template <int N>
double Combined<M>::trend(const Look& look, const Innovation<N, M>& innovation) const {
    const int known = std::min(stepped_ + (look.stepped ? 1 : 0), kRecent);
    const Array sum = steps_.template rightCols<kRecent - 1>().rowwise().sum().array() + look.step;
    double square = 0.0;
    int count = 0;
    for (int i = positions; i < M; ++i) {
        if (innovation.present(i) && known > 0) {
            const double mean = sum(i) / known;
            square += mean * mean / (2.0 * innovation.noise(i, i) / (known * known) + look.gained(i));
            ++count;
        }
    }
    return count > 0 ? square / count : 0.0;
}

template <int M>
template <int N>
bool Combined<M>::slow(const Look& look, const Innovation<N, M>& innovation) const {
    double square = 0.0;
    int count = 0;
    const auto add = [&](const auto& step) {
        for (int i = 0; i < M; ++i) {
            if (innovation.present(i)) {
                square += step(i) * step(i) / (2.0 * innovation.noise(i, i) + look.gained(i));
                ++count;
            }
        }
    };
    add(look.step);
    add(steps_.col(kRecent - 1));
    add(steps_.col(kRecent - 2));
    return square <= kSlow * count;
}

template <int M>
template <int N>
Cause Combined<M>::told_apart(const Look& look, const Innovation<N, M>& innovation,
                              const InnovationGate& gate) {
    const auto explains = [&](const PerGroup& scale) {
        const Innovation<N, M> one = scaled(innovation, scale);
        return gate.explains(nis(one), one.channels());
    };
    const PerGroup now = scale();
    const bool known = look.compared && compared_ + 1 >= kRecent;
    const PerGroup recent = known ? recent_scale(look) : now;
    const PerGroup grown = recent.max(now);
    if (known && explains(grown)) {
        // A jump is large in the differences that contain it alone; noise in the newest too.
        if (!explains(recent.min(kLasting * look.ratio).max(now)) && may_wait()) {
            return Cause::unknown;
        }
        take(grown);
        return Cause::noise;
    }
    const Innovation<N, M> used = scaled(innovation, now);
    if (positions > 0 && (velocity_explained(used, gate) || !place_follows(used))) {
        return Cause::unknown;
    }
    const Cause led = led_away(trend(look, used), trend(look, scaled(innovation, grown)));
    if (led != Cause::none && led != Cause::noise) {
        return led;
    }
    if (led == Cause::none && slow(look, used)) {
        return blamed(Cause::start);
    }
    const PerGroup larger = grown.max(square_of(innovation)).min(limit * limit);
    if (!explains(larger)) {
        return Cause::unknown;
    }
    take(larger);
    return Cause::noise;
}

// What a trend tells that is so large, and so large in terms of the scatter; `none`: there is none.
template <int M>
Cause Combined<M>::led_away(double plainly, double scattered) {
    if (plainly <= kTrend) {
        return Cause::none;
    }
    if (plainly <= kAbrupt) {
        return may_wait() ? Cause::unknown : blamed(sure ? Cause::motion : Cause::start);
    }
    if (scattered <= kPlain && may_wait()) {
        return Cause::unknown;
    }
    if (scattered <= kTrend) {
        return Cause::noise;
    }
    return sure ? blamed(Cause::motion) : Cause::unknown;
}

// As if it had been learned from as many measurements.
template <int M>
void Combined<M>::take(const PerGroup& grown) {
    const Eigen::Array<bool, 2, 1> more = grown > scale();
    weight_ = more.select(double{kRecent}, weight_);
    sum_ = more.select(kRecent * grown + kNominal * (grown - 1.0), sum_);
    refused_ = 0;
}

}  // namespace truenorth
