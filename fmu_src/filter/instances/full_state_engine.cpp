#include "filter/full_state_adapter.hpp"

namespace truenorth {

template class Engine<FullState>;
template class StateEngine<FullState>;

}  // namespace truenorth
