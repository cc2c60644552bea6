// Huber's M-estimate: a measurement whose residual is beyond `k` sigmas counts by its size, no longer by its
// square, so that what a gross error can move is bounded, and nothing is refused (Huber 1964; for Kalman
// filters Karlgaard and Schaub 2007, whose residuals of the prediction are left as they are here).
//
//     minimise  d^T P^-1 d / 2 + sum rho(r_i / sigma_i),   r = v - H d,  R = diag(sigma_i^2)
//     rho(u) = u^2 / 2              |u| <= k
//              k |u| - k^2 / 2      k < |u|
//
// by weights that are found anew `iterations` times: R_i becomes R_i / w_i with w_i = min(1, k / |u_i|) of
// the residual r that the last weights left, r = R S^-1 v. Noise that is Gaussian leaves an estimate with k
// = 1.345 95 % of its information. An outlier that the state can follow, of a channel that is alone to
// measure it, leaves little of itself behind; more iterations find it by and by.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"
#include "settings/correction.hpp"

namespace truenorth {

class Huber : public settings::Huber {
  public:
    using settings::Huber::operator=;

    template <int N, int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        const Vector<M> limit = k * innovation.noise.diagonal().cwiseSqrt();
        Innovation<N, M> used = innovation;
        Vector<M> weights = Vector<M>::Ones();
        for (int i = 0; i < iterations; ++i) {
            const Eigen::LLT<Matrix<M>> S(used.spread + used.noise);
            const Vector<M> residual = used.noise.lazyProduct(S.solve(innovation.residual));
            weights = limit.cwiseQuotient(residual.cwiseAbs()).cwiseMin(1.0);
            used.noise = innovation.noise;
            for (int channel = 0; channel < M; ++channel) {
                used.inflate(channel, 1.0 / std::sqrt(weights(channel)));
            }
        }
        Correction<N, M> correction = Standard().correct(prior, used);
        correction.weight = correction.weight.cwiseProduct(weights);
        return correction;
    }
};

}  // namespace truenorth
