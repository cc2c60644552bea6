// Predictor of the augmented unscented Kalman filter, Chen 2019, eqs. 8-25, and Jing 2023, eqs. 8-11,
// 13, 14: the noise is part of the state and has sigma points of its own.
//
// A noise point is the propagated centre plus its noise, because the noise of our models is additive in the
// deviation; so it need not pass through the model. Its plus and minus leave the mean alone, and their
// squares recover the covariance. The result differs from the simplified filter only by the distance of the
// points, alpha sqrt(n + q + kappa) for alpha sqrt(n + kappa): it is the same number for kappa less by q.
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
        const auto root = square_root<n>(model.process_noise(state, interval));
        if (!root.valid) {
            return Prediction::failed;
        }
        return points.predict(model, state, covariance, interval,
                              points.recovered<n>(points.around<n>(root.factor)));
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
