#include "filter/invariant_engine.hpp"

namespace truenorth {

template class Estimator<Invariant<false>>;
template class Engine<Invariant<false>>;  // beside it, the compilation of the other would be too large

}  // namespace truenorth
