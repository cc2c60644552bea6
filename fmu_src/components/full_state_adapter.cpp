#include "components/full_state_adapter.hpp"

namespace truenorth {

template class Engine<FullState>;
template class StateEngine<FullState>;
template struct AidUpdate<StateEngine<FullState>>;
template class Estimator<FullState>;
template class Corrector<FullState::kStates, FullState::kMeasurements>;

}  // namespace truenorth
