#include "filter/tight_adapter.hpp"

namespace truenorth {

template class Corrector<Tight::kStates, Tight::kMeasurements>;

}  // namespace truenorth
