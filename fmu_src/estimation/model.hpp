// What an error model offers to predictors; the only thing that estimation knows of it.
#pragma once

#include <concepts>

#include "estimation/gaussian.hpp"

namespace truenorth {

// A model has N states and M measured quantities, and a State of its own to which deviations are applied.
// `Interval` carries what drives the model over a filter interval, `Fix` what a measurement brings.
//
//   retract(x, d)              the state x moved by the deviation d
//   propagate(x, D, interval)  moves x over the interval; replaces each column d of D (N x K) by the
//                              deviation, from the moved x, of the moved retract(x, d)
//   transition(x, interval)    Jacobian of the moved deviation with respect to the deviation, at zero (N x N)
//   process_noise(x, interval) covariance that the interval adds (N x N)
//   residual(x, fix)           measurement minus prediction (M)
//   measurement_matrix(x, fix) Jacobian of the prediction with respect to the deviation (M x N)
//   measurement_noise(x, fix)  R (M x M)
template <class M>
concept ErrorModel = requires(const M& model, typename M::State& state, const typename M::State& x,
                              const typename M::Interval& interval, const typename M::Fix& fix,
                              Points<M::kStates, 2 * M::kStates + 1>& points) {
    { model.retract(x, Vector<M::kStates>()) } -> std::same_as<typename M::State>;
    { model.propagate(state, points, interval) };
    { model.transition(x, interval) } -> std::convertible_to<Matrix<M::kStates>>;
    { model.process_noise(x, interval) } -> std::convertible_to<Matrix<M::kStates>>;
    { model.residual(x, fix) } -> std::convertible_to<Vector<M::kMeasurements>>;
    { model.measurement_matrix(x, fix) } -> std::convertible_to<Matrix<M::kMeasurements, M::kStates>>;
    { model.measurement_noise(x, fix) } -> std::convertible_to<Matrix<M::kMeasurements>>;
};

// A model may offer besides, where its structure spares work:
//
//   moved(x, interval)         the state x at the end of the interval
//   local(x, y)                the deviation that makes y of x, for a bank of filters (gaussian_sum.hpp)
//   carried_covariance(P, F, interval)  F P F^T + process_noise, with its transition F
//
template <ErrorModel M>
void move(const M& model, typename M::State& state, const typename M::Interval& interval) {
    if constexpr (requires { model.moved(state, interval); }) {
        state = model.moved(state, interval);
    } else {
        Points<M::kStates, 1> no_deviation = Points<M::kStates, 1>::Zero();
        model.propagate(state, no_deviation, interval);
    }
}

// A model whose deviations are read differently from another state offers this besides:
//
//   transport(x, y)            of the deviations from y, the state that a correction has made of x, with
//                              respect to those from x (N x N)
//
// A model that was linearised at what a correction then changes may offer besides:
//
//   hindsight(P, d)            what the correction d of the prior P makes of the deviations that the linear
//                              filter is left with: a Shear
//
// Third phase of the filter step: moves the state by a correction; `carry` does with all that is known of the
// deviations what is to be done.
template <ErrorModel M, class Carry>
void correct(const M& model, typename M::State& state, const Vector<M::kStates>& deviation,
             [[maybe_unused]] const Carry& carry) {
    if constexpr (requires { model.transport(state, state); }) {
        const typename M::State before = state;
        state = model.retract(before, deviation);
        carry(model.transport(before, state));
    } else {
        state = model.retract(state, deviation);
    }
}

// A model whose noise does not simply add to the moved state offers this besides, for the noise points of the
// augmented filter:
//
//   propagate(x, D, W, interval)  as propagate(x, D, interval), with the noise w, of the covariance that
//                              process_noise has, acting inside the interval on each column (W: N x K)
template <class M>
concept NoiseInside =
    ErrorModel<M> && requires(const M& model, typename M::State& state, const typename M::Interval& interval,
                              Points<M::kStates, 4 * M::kStates + 1>& points,
                              const Points<M::kStates, 4 * M::kStates + 1>& noise) {
        { model.propagate(state, points, noise, interval) };
    };

// A model whose measurement is not linear in the deviation offers this besides, for sigma points:
//
//   predicted(x, D, fix)       the deviation of the predicted measurement of retract(x, d) from that of x,
//                              for each column d of D (N x K): M x K
template <class M>
concept NonlinearMeasurement =
    ErrorModel<M> && requires(const M& model, const typename M::State& x,
                              const Points<M::kStates, 2 * M::kStates>& points, const typename M::Fix& fix) {
        { model.predicted(x, points, fix) } -> std::convertible_to<Points<M::kMeasurements, 2 * M::kStates>>;
    };

// A model whose channels come and go says which of them a fix has; what it computes for the others does not
// matter.
template <class M>
concept IntermittentMeasurement = ErrorModel<M> && requires(const M& model, const typename M::Fix& fix) {
    { model.present(fix) } -> std::convertible_to<Eigen::Array<bool, M::kMeasurements, 1>>;
};

// A model of the errors of a navigation state that can be corrected by them offers this besides:
//
//   reset_jacobian(x)          of the errors that remain when x has been taken out, with respect to those
//                              before (N x N)
//   remaining(x)               optional, what of x is not taken out; else nothing remains
template <class M>
concept Resettable = ErrorModel<M> && requires(const M& model, const typename M::State& x) {
    { model.reset_jacobian(x) } -> std::convertible_to<Matrix<M::kStates>>;
};

template <ErrorModel M>
void remove_absent(const M& model, const typename M::Fix& fix,
                   Innovation<M::kStates, M::kMeasurements>& innovation) {
    if constexpr (IntermittentMeasurement<M>) {
        const Eigen::Array<bool, M::kMeasurements, 1> present = model.present(fix);
        for (int i = 0; i < M::kMeasurements; ++i) {
            if (!present(i)) {
                innovation.remove(i);
            }
        }
    }
}

// Second phase of the filter step: the innovation of a fix that is seen from `state`. H relates its
// prediction to the deviation of which `covariance` is.
template <ErrorModel M>
Innovation<M::kStates, M::kMeasurements> innovate(const M& model, const typename M::State& state,
                                                  const Matrix<M::kStates>& covariance,
                                                  const typename M::Fix& fix,
                                                  const Matrix<M::kMeasurements, M::kStates>& H) {
    // Eigen's lazy products: its blocked ones are made for larger matrices.
    const Matrix<M::kStates, M::kMeasurements> cross = covariance.lazyProduct(H.transpose());
    Innovation<M::kStates, M::kMeasurements> innovation{model.residual(state, fix), H.lazyProduct(cross),
                                                        model.measurement_noise(state, fix), cross};
    remove_absent(model, fix, innovation);
    return innovation;
}

template <ErrorModel M>
Innovation<M::kStates, M::kMeasurements> innovate(const M& model, const typename M::State& state,
                                                  const Matrix<M::kStates>& covariance,
                                                  const typename M::Fix& fix) {
    return innovate(model, state, covariance, fix, model.measurement_matrix(state, fix));
}

}  // namespace truenorth
