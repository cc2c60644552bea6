#include "components/large_azimuth_adapter.hpp"

namespace truenorth {

template class Engine<LargeAzimuth>;
template class NavigationEngine<LargeAzimuth>;
template struct AidUpdate<NavigationEngine<LargeAzimuth>>;
template class Estimator<LargeAzimuth>;
template class Corrector<LargeAzimuth::kStates, LargeAzimuth::kMeasurements>;

}  // namespace truenorth
