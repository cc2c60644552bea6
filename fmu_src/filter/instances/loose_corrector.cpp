#include "filter/loose_adapter.hpp"

namespace truenorth {

template class Corrector<Loose::kStates, Loose::kMeasurements>;

}  // namespace truenorth
