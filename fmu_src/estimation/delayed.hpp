// The innovation of a fix that was valid a while ago.
#pragma once

#include "estimation/model.hpp"

namespace truenorth {

// `since` is the interval from the fix to the present, to which x and P belong. The model is followed back
// over it: the fix is compared with the state as it was, and H refers to the deviation as it is. The process
// noise of the interval is neglected; it is that of a fraction of the time between fixes.
template <ErrorModel M>
Innovation<M::kStates, M::kMeasurements> innovate_delayed(const M& model, typename M::State x,
                                                          const Matrix<M::kStates>& P,
                                                          const typename M::Fix& fix,
                                                          typename M::Interval since) {
    since.dt = -since.dt;
    const Matrix<M::kStates> back = model.transition(x, since);
    move(model, x, since);
    return innovate(model, x, P, fix, model.measurement_matrix(x, fix) * back);
}

}  // namespace truenorth
