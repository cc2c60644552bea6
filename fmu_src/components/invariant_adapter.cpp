#include "components/invariant_adapter.hpp"

namespace truenorth {

template class Estimator<Invariant<false>>;
template class Estimator<Invariant<true>>;
template class Corrector<Invariant<true>::kStates, Invariant<true>::kMeasurements>;

}  // namespace truenorth
