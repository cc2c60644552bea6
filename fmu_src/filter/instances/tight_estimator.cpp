#include "filter/tight_adapter.hpp"

namespace truenorth {

template class Estimator<Tight>;

}  // namespace truenorth
