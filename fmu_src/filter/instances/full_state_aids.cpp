#include "filter/full_state_adapter.hpp"

namespace truenorth {

template struct AidUpdate<StateEngine<FullState>>;

}  // namespace truenorth
