// Predictor of the augmented unscented Kalman filter, Chen 2019, eqs. 8-25, and Jing 2023, eqs. 8-11,
// 13, 14: the noise is part of the state and has sigma points of its own.
//
// A noise point is moved by the model with its noise inside the interval, X = f(X, W) (Chen 2019, eq. 16,
// Jing 2023, eq. 13): a noisy gyro tilts the platform while it goes on integrating, so that the velocity has
// a share of it by the end of the interval. The simplified filter adds Q when the interval is over.
//
// Where the noise adds to the moved state, as in a linear model, a noise point is the moved centre plus its
// noise and need not be moved: its plus and minus leave the mean alone, and their squares recover Q. The
// result then differs from the simplified filter only by the distance of the points, alpha sqrt(n + q +
// kappa) for alpha sqrt(n + kappa): it is the same number for kappa less by q.
//
// The points are drawn anew between the phases, as process noise cannot act on a measurement otherwise than
// through the state: n + q in the first phase and n + m in the second, where Chen 2019 keeps n + q + m in
// both. Misprints of Chen 2019: the spread and the weights of eqs. 4, 5 and 13 do not belong together
// (variance 0.05-7.8 times P), eq. 15 divides by what it should add to, h stands for f in eq. 16, x for z in
// eqs. 21 and 22, and eq. 25 lacks P.
#pragma once

#include "estimation/sigma_points.hpp"

namespace truenorth {

class Augmented {
  public:
    explicit Augmented(const UnscentedParameters& parameters = {}) : parameters_(parameters) {}

    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval) const {
        constexpr int n = M::kStates;
        const SigmaPoints points(parameters_, 2 * n);
        if constexpr (NoiseInside<M>) {
            return points.predict_with_noise(model, state, covariance, interval);
        } else {
            const auto root = square_root<n>(model.process_noise(state, interval));
            if (!root.valid) {
                return Prediction::failed;
            }
            return points.predict(model, state, covariance, interval,
                                  points.recovered<n>(points.around<n>(root.factor)));
        }
    }

    // Linear measurements need no points.
    template <ErrorModel M>
    [[nodiscard]] Innovation<M::kStates, M::kMeasurements> innovate(const M& model,
                                                                    const typename M::State& state,
                                                                    const Matrix<M::kStates>& covariance,
                                                                    const typename M::Fix& fix) const {
        if constexpr (NonlinearMeasurement<M>) {
            constexpr int m = M::kMeasurements;
            const SigmaPoints points(parameters_, M::kStates + m);
            const auto root = square_root<m>(model.measurement_noise(state, fix));
            return points.innovate(model, state, covariance, fix,
                                   points.recovered<m>(points.around<m>(root.factor)));
        } else {
            return truenorth::innovate(model, state, covariance, fix);
        }
    }

  private:
    UnscentedParameters parameters_;
};

}  // namespace truenorth
