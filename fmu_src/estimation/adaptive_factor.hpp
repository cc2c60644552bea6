// Adaptive factor alpha of Li, section III: when the innovation is larger than its covariance explains, the
// prediction is blamed.
//
// H P H^T and P H^T are divided by alpha (eqs. 15, 16), R is not, and
//
//     P+ = P- / alpha - K S K^T;
//
// eq. 17 prints P_k, the posterior of eq. 14, for the predicted P_k^-. An outlier of the measurement is
// thereby taken at its word: against outliers this corrector is the wrong one.
//
// alpha has a floor, which Li does not print: no state's sigma is made larger than `widest`. Every gross
// error would otherwise divide again what no measurement sees (a heading at rest), until nothing is left of
// P- / alpha - K S K^T but rounding.
#pragma once

#include <algorithm>
#include <limits>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

template <int N>
class AdaptiveFactor {
  public:
    enum class Form {
        unit_free,  // sum u_i^2 > threshold x channels, with the standardised innovation u
        printed,  // eq. 18, tr(v v^T) > tr(S), a statistic against its own mean: fires in two clean epochs of
                  // five; adds squared metres to squared metres per second, so that the unit decides
    };

    Form form = Form::unit_free;
    double threshold = 2.1;  // unit_free only; a mean of u^2, 1 in a consistent filter
    Vector<N> widest = Vector<N>::Constant(std::numeric_limits<double>::infinity());

    template <int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        const double factor = alpha(prior, innovation);
        Innovation<N, M> used = innovation;
        used.spread /= factor;
        used.cross /= factor;
        Correction<N, M> correction = Standard().correct(Matrix<N>(prior / factor), used);
        correction.alpha = factor;
        return correction;
    }

    // At most 1; 1: the innovation is what its covariance explains.
    template <int M>
    [[nodiscard]] double alpha(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        return std::min(std::max(explained(innovation), smallest(prior)), 1.0);
    }

    // By which no sigma of the prior grows beyond the widest; more than 1 if one of them is beyond it
    // already.
    [[nodiscard]] double smallest(const Matrix<N>& prior) const {
        return prior.diagonal().cwiseQuotient(widest.cwiseAbs2()).maxCoeff();
    }

  private:
    // The share of the innovation that its covariance explains; 1 where the test does not fire.
    template <int M>
    [[nodiscard]] double explained(const Innovation<N, M>& innovation) const {
        if (form == Form::printed) {
            const auto S = (innovation.spread + innovation.noise).diagonal().array();
            return limited(innovation.residual.squaredNorm(), innovation.present.select(S, 0.0).sum());
        }
        return limited(innovation.standardised().squaredNorm(), threshold * innovation.channels());
    }

    static double limited(double statistic, double limit) {
        return statistic > limit ? limit / statistic : 1.0;
    }
};

}  // namespace truenorth
