#include "filter/invariant_engine.hpp"

namespace truenorth {

template class InvariantEngine<true>;

}  // namespace truenorth
