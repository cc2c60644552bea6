#include "filter/invariant_engine.hpp"

namespace truenorth {

template class Engine<Invariant<true>>;
template class InvariantEngine<true>;

}  // namespace truenorth
