// State and covariance of a model, and the predictor that was chosen for it at run time.
#pragma once

#include <utility>
#include <variant>

#include "estimation/appended.hpp"
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
    Appended appended;  // constants of sensors

    // First phase: state and covariance at the end of the interval.
    Prediction predict(const typename M::Interval& interval);

    // Second phase.
    [[nodiscard]] Innovation<kStates, M::kMeasurements> innovate(const typename M::Fix& fix) const;

    // Third phase, once a corrector has spoken. A measurement that is one of the constants too says what they
    // are after it.
    void apply(const Correction<kStates, M::kMeasurements>& correction, const Appended* constants = nullptr) {
        if (constants != nullptr) {
            appended = *constants;
        } else {
            // What a corrector blames the prediction for, it takes for noise that the constants do not know.
            appended.learn<kStates>(covariance / correction.alpha, correction.covariance,
                                    correction.deviation);
        }
        if constexpr (requires { model.hindsight(covariance, correction.deviation); }) {
            const auto shear = model.hindsight(covariance, correction.deviation);
            covariance = shear.covariance(correction.covariance);
            if (appended.related()) {
                appended.carry<kStates>(shear.matrix());
            }
        } else {
            covariance = correction.covariance;
        }
        correct(model, state, correction.deviation, [this](const Matrix<kStates>& F) {
            covariance = transformed<kStates>(F, covariance);
            appended.carry<kStates>(F);
        });
    }

    // The estimate has been fed back to what it is an error of; what remains of it is what the model says, or
    // zero. Nothing happens to a model that is not Resettable: it estimates no error.
    void reset();

    // Of the errors that remain when the estimate is taken out; of a model that is not Resettable nothing is.
    [[nodiscard]] Matrix<kStates> covariance_of_remaining() const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(state, covariance, appended);
    }
};

// Not in the class, so that a model's estimator can be compiled once, in a file of its own. Nor are members
// constrained: clang before 16 instantiates them all, whatever their constraints say.

template <ErrorModel M>
Prediction Estimator<M>::predict(const typename M::Interval& interval) {
    if (appended.related()) {
        appended.carry<kStates>(model.transition(state, interval));
    }
    return std::visit([&](const auto& chosen) { return chosen.predict(model, state, covariance, interval); },
                      predictor);
}

template <ErrorModel M>
auto Estimator<M>::innovate(const typename M::Fix& fix) const -> Innovation<kStates, M::kMeasurements> {
    return std::visit([&](const auto& chosen) { return chosen.innovate(model, state, covariance, fix); },
                      predictor);
}

template <ErrorModel M>
void Estimator<M>::reset() {
    if constexpr (Resettable<M>) {
        if (appended.related()) {
            appended.carry<kStates>(model.reset_jacobian(state));
        }
        covariance = covariance_of_remaining();
        if constexpr (requires { model.remaining(state); }) {
            state = model.remaining(state);
        } else {
            state = M::State::Zero();
        }
    }
}

template <ErrorModel M>
auto Estimator<M>::covariance_of_remaining() const -> Matrix<kStates> {
    if constexpr (Resettable<M>) {
        return transformed<kStates>(model.reset_jacobian(state), covariance);
    } else {
        return covariance;
    }
}

}  // namespace truenorth
