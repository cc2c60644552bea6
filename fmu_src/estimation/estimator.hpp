// State and covariance of a model, and the predictor that was chosen for it at run time.
#pragma once

#include <utility>
#include <variant>

#include "estimation/augmented.hpp"
#include "estimation/linearised.hpp"
#include "estimation/model.hpp"
#include "estimation/unscented.hpp"

namespace truenorth {

using Predictor = std::variant<Linearised, Unscented, Augmented>;

// The state that a model has before it is told another: of a vector, zero.
template <ErrorModel M>
typename M::State origin() {
    if constexpr (requires { M::State::Zero(); }) {
        return M::State::Zero();
    } else {
        return {};
    }
}

template <ErrorModel M>
class Estimator {
  public:
    static constexpr int kStates = M::kStates;

    M model;
    Predictor predictor;
    typename M::State state = origin<M>();
    Matrix<kStates> covariance = Matrix<kStates>::Zero();

    // First phase: state and covariance at the end of the interval.
    Prediction predict(const typename M::Interval& interval) {
        return std::visit(
            [&](const auto& chosen) { return chosen.predict(model, state, covariance, interval); },
            predictor);
    }

    // Second phase.
    [[nodiscard]] auto innovate(const typename M::Fix& fix) const {
        return std::visit([&](const auto& chosen) { return chosen.innovate(model, state, covariance, fix); },
                          predictor);
    }

    // Third phase, once a corrector has spoken.
    template <int Measurements>
    void apply(const Correction<kStates, Measurements>& correction) {
        state = model.retract(state, correction.deviation);
        covariance = correction.covariance;
    }

    // The estimate has been fed back to what it is an error of; what remains of it is what the model says, or
    // zero.
    void reset() {
        covariance = covariance_of_remaining();
        if constexpr (requires { model.remaining(state); }) {
            state = model.remaining(state);
        } else {
            state = M::State::Zero();
        }
    }

    // Of the errors that remain when the estimate is taken out.
    [[nodiscard]] Matrix<kStates> covariance_of_remaining() const {
        const Matrix<kStates> G = model.reset_jacobian(state);
        Matrix<kStates> remaining = G * covariance * G.transpose();
        symmetrise(remaining);
        return remaining;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(state, covariance);
    }
};

}  // namespace truenorth
