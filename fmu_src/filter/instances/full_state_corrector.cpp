#include "filter/full_state_adapter.hpp"

namespace truenorth {

template class Corrector<FullState::kStates, FullState::kMeasurements>;

}  // namespace truenorth
