#include "filter/invariant_adapter.hpp"

namespace truenorth {

template class Corrector<Invariant<true>::kStates, Invariant<true>::kMeasurements>;

}  // namespace truenorth
