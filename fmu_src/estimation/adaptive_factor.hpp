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
// What Li does not print: alpha has a floor, and of the posterior no state's sigma is left larger than
// `widest`, by scaling it with its correlations. Every large innovation would otherwise divide again what no
// measurement sees, a heading at rest or the bias of a sensor, until nothing is left of P- / alpha - K S K^T
// but rounding, or the next measurement moves it anywhere.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"
#include "settings/correction.hpp"

namespace truenorth {

// It fires, in the form
//
//   unit_free  when sum u_i^2 > threshold x channels, with the standardised innovation u, whose mean square
//              is 1 in a consistent filter;
//   printed    by eq. 18, tr(v v^T) > tr(S), a statistic against its own mean: in two clean epochs of five;
//              it adds squared metres to squared metres per second, so that the unit decides.
template <int N>
class AdaptiveFactor : public settings::Adaptive {
  public:
    using Form = settings::AdaptiveForm;
    using settings::Adaptive::operator=;

    Vector<N> widest = Vector<N>::Constant(std::numeric_limits<double>::infinity());

    template <int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        const double factor = alpha(innovation);
        Innovation<N, M> used = innovation;
        used.spread /= factor;
        used.cross /= factor;
        Correction<N, M> correction = Standard().correct(Matrix<N>(prior / factor), used);
        correction.alpha = factor;
        if (factor < 1.0) {
            narrow(correction.covariance);
        }
        return correction;
    }

    // At most 1; 1: the innovation is what its covariance explains.
    template <int M>
    [[nodiscard]] double alpha(const Innovation<N, M>& innovation) const {
        return std::max(explained(innovation), kSmallest);
    }

  private:
    // Leaves ten digits of a prediction that is divided by it.
    static constexpr double kSmallest = 1e-6;

    void narrow(Matrix<N>& covariance) const {
        const Vector<N> sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
        const Vector<N> scale = (sigma.array() > widest.array()).select(widest.cwiseQuotient(sigma), 1.0);
        covariance.array() *= (scale * scale.transpose()).array();  // stays symmetric to the last digit
    }

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
