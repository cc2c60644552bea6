#include "filter/loose_adapter.hpp"

namespace truenorth {

template class Estimator<Loose>;

}  // namespace truenorth
