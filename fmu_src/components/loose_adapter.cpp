#include "components/loose_adapter.hpp"

namespace truenorth {

template class Estimator<Loose>;
template class Corrector<Loose::kStates, Loose::kMeasurements>;

}  // namespace truenorth
