// The scaled unscented transformation on deviations; what the unscented predictors share.
//
// Sigma points are deviations 0, +-sqrt((n + lambda) P) of the state, lambda = alpha^2 (n + kappa) - n.
// With d_i the propagated deviation of point i from the propagated centre and w = 1 / (2 (n + lambda)),
//
//     mean       m = w sum d_i
//     covariance   = w sum d_i d_i^T + (beta - alpha^2) m m^T,
//
// which is the transformation of Zhou 2011, section 1, with the terms of the huge weight of the centre summed
// by hand: for alpha = 1e-3 they are -1e6 and would cost six digits.
#pragma once

#include <cmath>

#include "estimation/model.hpp"
#include "estimation/prediction.hpp"
#include "estimation/square_root.hpp"
#include "settings/prediction.hpp"

namespace truenorth {

using UnscentedParameters = settings::Unscented;

class SigmaPoints {
  public:
    // `dimension`: n, that of the state with whatever is appended to it.
    SigmaPoints(const UnscentedParameters& parameters, int dimension)
        : distance_(parameters.alpha * std::sqrt(dimension + parameters.kappa)),
          weight_(0.5 / (distance_ * distance_)),
          weight_of_mean_(parameters.beta - parameters.alpha * parameters.alpha) {}

    // All points but the centre, for the square root of a covariance.
    template <int N>
    [[nodiscard]] Points<N, 2 * N> around(const Matrix<N>& root) const {
        Points<N, 2 * N> points;
        points.template leftCols<N>() = distance_ * root;
        points.template rightCols<N>() = -points.template leftCols<N>();
        return points;
    }

    template <int N, class Set>
    [[nodiscard]] Vector<N> mean(const Set& deviations) const {
        return weight_ * deviations.rowwise().sum();
    }

    // Added to `added`: the covariance of what is not among the points.
    template <int N, class Set>
    [[nodiscard]] Matrix<N> covariance(const Matrix<N>& added, const Set& deviations,
                                       const Vector<N>& mean) const {
        return rank_update<N>(rank_update<N>(added, deviations, weight_), mean, weight_of_mean_);
    }

    // Of states, whose points have the mean zero, and their images.
    template <int N, int M, int Count>
    [[nodiscard]] Matrix<N, M> cross(const Points<N, Count>& states, const Points<M, Count>& images) const {
        return weight_ * states.lazyProduct(images.transpose());
    }

    // Of the noise that a set of points stands for, the sum of their squares.
    template <int N>
    [[nodiscard]] Matrix<N> recovered(const Points<N, 2 * N>& noise) const {
        return rank_update<N>(Matrix<N>::Zero(), noise, weight_);
    }

    // First phase of the filter step; Q is added.
    template <ErrorModel M>
    Prediction predict(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                       const typename M::Interval& interval, const Matrix<M::kStates>& Q) const {
        constexpr int n = M::kStates;
        const auto root = square_root<n>(covariance);
        if (!root.valid) {
            return Prediction::failed;
        }
        Points<n, 2 * n + 1> points;
        points.col(0).setZero();
        points.template rightCols<2 * n>() = around<n>(root.factor);
        model.propagate(state, points, interval);

        return concluded<M>(model, state, covariance, points.template rightCols<2 * n>(), Q, root.repaired);
    }

    // The same, of points of which half are moved by the noise alone, inside the interval.
    template <NoiseInside M>
    Prediction predict_with_noise(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                                  const typename M::Interval& interval) const {
        constexpr int n = M::kStates;
        const auto root = square_root<n>(covariance);
        const auto root_of_noise = square_root<n>(model.process_noise(state, interval));
        if (!root.valid || !root_of_noise.valid) {
            return Prediction::failed;
        }
        using Set = Points<n, 4 * n + 1>;
        Set points = Set::Zero();
        Set noise = Set::Zero();
        points.template middleCols<2 * n>(1) = around<n>(root.factor);
        noise.template rightCols<2 * n>() = around<n>(root_of_noise.factor);
        model.propagate(state, points, noise, interval);
        return concluded<M>(model, state, covariance, points.template rightCols<4 * n>(), Matrix<n>::Zero(),
                            root.repaired);
    }

    // Second phase, for a measurement that is not linear. The points are drawn anew from the covariance, so
    // that they know of Q.
    template <NonlinearMeasurement M>
    [[nodiscard]] Innovation<M::kStates, M::kMeasurements> innovate(const M& model,
                                                                    const typename M::State& state,
                                                                    const Matrix<M::kStates>& covariance,
                                                                    const typename M::Fix& fix,
                                                                    const Matrix<M::kMeasurements>& R) const {
        constexpr int n = M::kStates;
        constexpr int m = M::kMeasurements;
        const Points<n, 2 * n> states = around<n>(square_root<n>(covariance).factor);
        const Points<m, 2 * n> images = model.predicted(state, states, fix);
        const Vector<m> shift = mean<m>(images);
        Innovation<n, m> innovation{model.residual(state, fix) - shift,
                                    this->covariance<m>(Matrix<m>::Zero(), images, shift), R,
                                    cross<n, m>(states, images)};
        remove_absent(model, fix, innovation);
        return innovation;
    }

  private:
    // State and covariance from where the points have come to, relative to their centre, which is in `state`.
    template <ErrorModel M, class Set>
    Prediction concluded(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                         const Set& deviations, const Matrix<M::kStates>& Q, bool repaired) const {
        constexpr int n = M::kStates;
        const Vector<n> m = mean<n>(deviations);
        covariance = this->covariance<n>(Q, deviations, m);
        state = model.retract(state, m);
        if (!covariance.allFinite()) {
            return Prediction::failed;
        }
        return repaired ? Prediction::repaired : Prediction::sound;
    }

    double distance_;
    double weight_;
    double weight_of_mean_;
};

}  // namespace truenorth
