// Predictor of the extended Kalman filter: the state moves through the model, the covariance through its
// Jacobian.
#pragma once

#include "estimation/model.hpp"
#include "estimation/prediction.hpp"

namespace truenorth {

// Moves state and covariance over an interval; returns the transition between deviations.
template <ErrorModel M>
Matrix<M::kStates> carry(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                         const typename M::Interval& interval) {
    const Matrix<M::kStates> F = model.transition(state, interval);
    if constexpr (requires { model.carried_covariance(covariance, F, interval); }) {
        covariance = model.carried_covariance(covariance, F, interval);
    } else {
        covariance = transformed<M::kStates>(F, covariance) + model.process_noise(state, interval);
    }
    move(model, state, interval);
    return F;
}

class Linearised {
  public:
    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval) const {
        carry(model, state, covariance, interval);
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
