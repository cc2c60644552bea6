#include "filter/full_state_adapter.hpp"

namespace truenorth {

template class Estimator<FullState>;

}  // namespace truenorth
