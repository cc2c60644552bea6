#include "components/loose_adapter.hpp"

namespace truenorth {

template class Engine<Loose>;
template class NavigationEngine<Loose>;
template struct AidUpdate<NavigationEngine<Loose>>;
template class Estimator<Loose>;
template class Corrector<Loose::kStates, Loose::kMeasurements>;

}  // namespace truenorth
