#include "components/invariant_engine.hpp"

namespace truenorth {

template class Estimator<Invariant<false>>;
template class Engine<Invariant<false>>;
template class InvariantEngine<false>;
template struct AidUpdate<InvariantEngine<false>>;

}  // namespace truenorth
