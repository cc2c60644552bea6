#include "components/invariant_engine.hpp"

namespace truenorth {

template class Estimator<Invariant<true>>;
template class Corrector<Invariant<true>::kStates, Invariant<true>::kMeasurements>;
template class Engine<Invariant<true>>;
template class InvariantEngine<true>;
template struct AidUpdate<InvariantEngine<true>>;

}  // namespace truenorth
