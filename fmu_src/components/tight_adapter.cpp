#include "components/tight_adapter.hpp"

namespace truenorth {

template class Engine<Tight>;
template class NavigationEngine<Tight>;
template struct AidUpdate<NavigationEngine<Tight>>;
template class Estimator<Tight>;
template class Corrector<Tight::kStates, Tight::kMeasurements>;

}  // namespace truenorth
