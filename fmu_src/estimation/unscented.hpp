// Predictor of the simplified (Rao-Blackwellised additive) unscented Kalman filter, Zhou 2011, section 1, and
// Li, eqs. 3-14: the state alone has sigma points, the noise is added.
#pragma once

#include "estimation/sigma_points.hpp"

namespace truenorth {

class Unscented {
  public:
    explicit Unscented(const UnscentedParameters& parameters = {}) : parameters_(parameters) {}

    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval) const {
        const Matrix<M::kStates> Q = model.process_noise(state, interval);
        return SigmaPoints(parameters_, M::kStates).predict(model, state, covariance, interval, Q);
    }

    // Linear measurements need no points.
    template <ErrorModel M>
    [[nodiscard]] Innovation<M::kStates, M::kMeasurements> innovate(const M& model,
                                                                    const typename M::State& state,
                                                                    const Matrix<M::kStates>& covariance,
                                                                    const typename M::Fix& fix) const {
        if constexpr (NonlinearMeasurement<M>) {
            return SigmaPoints(parameters_, M::kStates)
                .innovate(model, state, covariance, fix, model.measurement_noise(state, fix));
        } else {
            return truenorth::innovate(model, state, covariance, fix);
        }
    }

  private:
    UnscentedParameters parameters_;
};

}  // namespace truenorth
