#include "filter/invariant_adapter.hpp"

namespace truenorth {

template class Estimator<Invariant<true>>;

}  // namespace truenorth
