#include "filter/invariant_engine.hpp"

namespace truenorth {

template class Engine<Invariant<false>>;
template class InvariantEngine<false>;

}  // namespace truenorth
