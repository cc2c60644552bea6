// Predictor of the simplified (Rao-Blackwellised additive) unscented Kalman filter, Zhou 2011, section 1.
//
// Sigma points are deviations 0, +-sqrt((n + lambda) P) of the state, lambda = alpha^2 (n + kappa) - n.
// With d_i the propagated deviation of point i from the propagated centre and w = 1 / (2 (n + lambda)),
//
//     mean       m = w sum d_i
//     covariance   = w sum d_i d_i^T + (beta - alpha^2) m m^T + Q,
//
// which is Zhou 2011's time update with the terms of the huge weight of the centre summed by hand: for
// alpha = 1e-3 they are -1e6 and would cost six digits.
#pragma once

#include "estimation/model.hpp"
#include "estimation/prediction.hpp"
#include "estimation/square_root.hpp"

namespace truenorth {

struct UnscentedParameters {
    double alpha = 1e-3;
    double beta = 2.0;
    double kappa = 0.0;
};

class Unscented {
  public:
    explicit Unscented(const UnscentedParameters& parameters = {}) : parameters_(parameters) {}

    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval) const {
        constexpr int n = M::kStates;
        const auto root = square_root<n>(covariance);
        if (!root.valid) {
            return Prediction::failed;
        }
        const double spread = parameters_.alpha * std::sqrt(n + parameters_.kappa);  // sqrt(n + lambda)
        Points<n, 2 * n + 1> points;
        points.col(0).setZero();
        points.template middleCols<n>(1) = spread * root.factor;
        points.template rightCols<n>() = -points.template middleCols<n>(1);

        const Matrix<n> Q = model.process_noise(state, interval);
        model.propagate(state, points, interval);

        const double weight = 0.5 / (spread * spread);
        const auto deviations = points.template rightCols<2 * n>();
        const Vector<n> mean = weight * deviations.rowwise().sum();
        covariance = rank_update<n>(Q, deviations, weight);
        covariance =
            rank_update<n>(covariance, mean, parameters_.beta - parameters_.alpha * parameters_.alpha);
        state = model.retract(state, mean);
        if (!covariance.allFinite()) {
            return Prediction::failed;
        }
        return root.repaired ? Prediction::repaired : Prediction::sound;
    }

  private:
    UnscentedParameters parameters_;
};

}  // namespace truenorth
