// A whole series of fixes, linearised at one trajectory.
//
// A recursive filter linearises every epoch at the estimate it has by then. With a wide prior the first fixes
// throw that estimate far about, and what was linearised there stays in the covariance. Where a trajectory
// near the truth is known from elsewhere, the series is filtered again as deviations from it: one
// Gauss-Newton step on all of its fixes together, right for a prior of any width.
#pragma once

#include "estimation/linearised.hpp"

namespace truenorth {

// What drives a model up to a fix, and the fix.
template <ErrorModel M>
struct Epoch {
    typename M::Interval interval;
    typename M::Fix fix;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(interval, fix);
    }
};

// Carries state and covariance through the epochs, everything linearised at the trajectory that starts at
// `state`, from which the prior deviates by `deviation`. `correct` is the third phase of the filter step: of
// prior covariance and innovation.
template <ErrorModel M, class Epochs, class Correct>
void filter_along_trajectory(const M& model, typename M::State& state, Matrix<M::kStates>& covariance,
                             Vector<M::kStates> deviation, const Epochs& epochs, const Correct& correct) {
    for (const Epoch<M>& epoch : epochs) {
        const Matrix<M::kStates> F = carry(model, state, covariance, epoch.interval);
        deviation = (F * deviation).eval();

        auto innovation = innovate(model, state, covariance, epoch.fix);
        innovation.residual -= model.measurement_matrix(state, epoch.fix) * deviation;
        const auto correction = correct(covariance, innovation);
        deviation += correction.deviation;
        covariance = correction.covariance;
    }
    truenorth::correct(model, state, deviation, [&covariance](const Matrix<M::kStates>& F) {
        covariance = transformed<M::kStates>(F, covariance);
    });
}

}  // namespace truenorth
