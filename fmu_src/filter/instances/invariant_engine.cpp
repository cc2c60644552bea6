#include "filter/invariant_engine.hpp"

namespace truenorth {

template class InvariantEngine<false>;

}  // namespace truenorth
