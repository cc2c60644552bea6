#include "filter/invariant_engine.hpp"

namespace truenorth {

template struct AidUpdate<InvariantEngine<false>>;

}  // namespace truenorth
