#include "filter/invariant_engine.hpp"

namespace truenorth {

template class Estimator<Invariant<true>>;
template class Engine<Invariant<true>>;  // beside it, the compilation of the other would be too large

}  // namespace truenorth
