// Robust corrector of Chen 2019, section 3: a channel whose innovation is too large loses weight. The paper
// calls the weight function IGG II; in the literature its three pieces are known as IGG III.
//
//     w = 1                                     u <= k0
//         k0 / u ((k1 - u) / (k1 - k0))^2       k0 < u <= k1      u_i = |v_i| / sqrt(S_ii)
//         0                                     k1 < u
//
// R_i becomes R_i / w_i, and a channel with w = 0 is removed as if it had not been measured. Misprints of
// Chen 2019: eq. 28 has the factor k0 / |v| twice; eq. 29 inflates by 0 above k1, which makes a gross error a
// perfect measurement; eq. 27 standardises a channel by the mean of the others, metres by metres per second,
// and so rejects in most clean epochs; eq. 30 applies the factor to the whole covariance of the innovation,
// whose other part, H P H^T, an outlier does not make less certain. There is no form `printed`: with eq. 29 a
// gross error would do the more harm the larger it is.
//
// The paper then draws the sigma points anew (eq. 31); with additive noise a new R changes S alone, so
// nothing is drawn here. Its k0 is 1.0-1.5 and its k1 2.5-8: k0 = 1.5 takes weight from one sound channel in
// seven, so that of six channels one is suspect in more than half of the fixes, which the guard would count
// as bad. For the default of 2.5 it is one channel in eighty; k1 = 8 is the upper end.
#pragma once

#include <cmath>

#include "estimation/adaptive_factor.hpp"
#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

template <int N>
class Igg {
  public:
    double k0 = 2.5;
    double k1 = 8.0;

    // Guard against lock-out: a prediction that has gone astray makes every good measurement look like an
    // outlier, for ever. An epoch is bad if any of its channels loses weight; outliers make one or two in
    // succession. After `patience` consecutive bad ones the adaptive factor, which blames the prediction,
    // takes over until an epoch that is not bad.
    int patience = 5;
    AdaptiveFactor<N> guard;

    [[nodiscard]] double weight(double u) const {
        if (u <= k0) {
            return 1.0;
        }
        const double slope = (k1 - u) / (k1 - k0);
        return u < k1 ? k0 / u * slope * slope : 0.0;
    }

    template <int M>
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) {
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
                // Covariances of the noise grow with its standard deviations; correlations stay what they
                // are.
                const double growth = 1.0 / std::sqrt(weights(i));
                used.noise.row(i) *= growth;
                used.noise.col(i) *= growth;
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
    int bad_epochs_ = 0;  // consecutive ones, counted up to patience
};

}  // namespace truenorth
