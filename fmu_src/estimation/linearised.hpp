// Predictor of the extended Kalman filter: the state moves through the model, the covariance through its
// Jacobian.
#pragma once

#include "estimation/model.hpp"
#include "estimation/prediction.hpp"

namespace truenorth {

class Linearised {
  public:
    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval) const {
        constexpr int n = M::kStates;
        const Matrix<n> F = model.transition(state, interval);
        const Matrix<n> Q = model.process_noise(state, interval);
        Points<n, 1> no_deviation = Points<n, 1>::Zero();
        model.propagate(state, no_deviation, interval);
        covariance = F * covariance * F.transpose() + Q;
        symmetrise(covariance);
        return covariance.allFinite() ? Prediction::sound : Prediction::failed;
    }

    template <ErrorModel M>
    [[nodiscard]] Innovation<M::kStates, M::kMeasurements> innovate(const M& model,
                                                                    const typename M::State& state,
                                                                    const Matrix<M::kStates>& covariance,
                                                                    const typename M::Fix& fix) const {
        return truenorth::innovate(model, state, covariance, fix);
    }
};

}  // namespace truenorth
