// Robust corrector of Chen 2019, section 3: a channel whose innovation is too large loses weight. The paper
// calls the weight function IGG II; in the literature its three pieces are known as IGG III.
//
//     w = 1                                     u <= k0
//         k0 / u ((k1 - u) / (k1 - k0))^2       k0 < u <= k1      u_i = |v_i| / sqrt(S_ii)
//         0                                     k1 < u
//
// R_i becomes R_i / w_i, and a channel with w = 0 is removed as if it had not been measured.
//
// Misprints of Chen 2019: eq. 28 has the factor k0 / |v| twice; eq. 29 inflates by 0 above k1, which makes a
// gross error a perfect measurement; eq. 27 standardises a channel by the mean of the others, metres by
// metres per second; eq. 30 applies the factor to the whole covariance of the innovation, whose other part, H
// P H^T, an outlier does not make less certain. The form `printed` is all of that, for comparison: with
//
//     D_i = |v_i| / mean of |v_j|, j != i                                                     (eq. 27)
//     lambda_i = 1                                        D_i <= k0
//                D_i / k0 ((k1 - k0) / (k1 - D_i))^2      k0 < D_i <= k1                      (eq. 29)
//                0                                        k1 < D_i
//
// (eq. 29 prints its conditions with |v_i|, the factor with the standardised innovation; read here as D_i in
// both) the diagonal of S becomes lambda_i S_ii (eq. 30), in epochs in which some v_i^2 > 3^2 S_ii (eq. 26,
// whose factor is 2.3 to 4.3), else nothing happens. Where lambda_i S_ii is less than (H P H^T)_ii, as it is
// for 0, no noise is left: the update takes the error at its word. No guard stands behind it.
//
// The paper then draws the sigma points anew (eq. 31); with additive noise a new R changes S alone, so
// nothing is drawn here. Its k0 is 1.0-1.5 and its k1 2.5-8: k0 = 1.5 takes weight from one sound channel in
// seven, so that of six channels one is suspect in more than half of the fixes, which the guard would count
// as bad. For the default of 2.5 it is one channel in eighty; k1 = 8 is the upper end.
#pragma once

#include <algorithm>
#include <cmath>

#include "estimation/adaptive_factor.hpp"
#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"
#include "settings/correction.hpp"

namespace truenorth {

template <int N>
class Igg : public settings::Igg {
  public:
    using Form = settings::IggForm;
    using settings::Igg::operator=;

    // Guard against lock-out: a prediction that has gone astray makes every good measurement look like an
    // outlier, for ever. An epoch is bad if any of its channels loses weight; outliers make one or two in
    // succession. After `patience` consecutive bad ones the adaptive factor, which blames the prediction,
    // takes over until an epoch that is not bad.
    AdaptiveFactor<N> guard;

    [[nodiscard]] double weight(double u) const {
        if (u <= k0) {
            return 1.0;
        }
        const double slope = (k1 - u) / (k1 - k0);
        return u < k1 ? k0 / u * slope * slope : 0.0;
    }

    // lambda of eq. 29 for D of eq. 27.
    [[nodiscard]] double printed_factor(double d) const {
        if (d <= k0) {
            return 1.0;
        }
        const double slope = (k1 - k0) / (k1 - d);
        return d < k1 ? d / k0 * slope * slope : 0.0;
    }

    template <int M>
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) {
        if (form == Form::printed) {
            return correct_as_printed(prior, innovation);
        }
        const Vector<M> weights = innovation.standardised().unaryExpr([this](double u) { return weight(u); });
        const bool bad = (weights.array() < 1.0).any();
        if (!bad) {
            bad_epochs_ = 0;
        } else if (bad_epochs_ == patience) {
            return guard.correct(prior, innovation);
        } else {
            ++bad_epochs_;
        }

        Innovation<N, M> used = innovation;
        for (int i = 0; i < M; ++i) {
            if (weights(i) == 0.0) {
                used.remove(i);
            } else {
                used.inflate(i, 1.0 / std::sqrt(weights(i)));
            }
        }
        Correction<N, M> correction = Standard().correct(prior, used);
        correction.weight = correction.weight.cwiseProduct(weights);
        return correction;
    }

    void restart() { bad_epochs_ = 0; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(bad_epochs_);
    }

  private:
    static constexpr double kDetection = 3.0;  // sigma_m of eq. 26
    static constexpr double kExact = 1e-6;     // of the noise, left of it where eq. 30 leaves none or less

    template <int M>
    [[nodiscard]] Correction<N, M> correct_as_printed(const Matrix<N>& prior,
                                                      const Innovation<N, M>& innovation) const {
        Innovation<N, M> used = innovation;
        Vector<M> weights = Vector<M>::Ones();
        if ((innovation.standardised().array() > kDetection).any()) {
            const double sum = innovation.residual.cwiseAbs().sum();
            const int others = innovation.channels() - 1;
            for (int i = 0; i < M; ++i) {
                const double size = std::abs(innovation.residual(i));
                const double R = innovation.noise(i, i);
                const double spread = innovation.spread(i, i);
                // Alone, a channel has no mean of the others to stand out from; an absent one has no error.
                const double lambda =
                    others > 0 && size > 0.0 ? printed_factor(size * others / (sum - size)) : 1.0;
                const double factor = (lambda * (spread + R) - spread) / R;
                used.inflate(i, std::sqrt(std::max(factor, kExact)));
                weights(i) = 1.0 / std::max(factor, 1.0);
            }
        }
        Correction<N, M> correction = Standard().correct(prior, used);
        correction.weight = correction.weight.cwiseProduct(weights);
        return correction;
    }

    int bad_epochs_ = 0;  // consecutive ones, counted up to patience
};

}  // namespace truenorth
