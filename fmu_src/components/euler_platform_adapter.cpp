#include "components/euler_platform_adapter.hpp"

namespace truenorth {

template class Engine<EulerPlatform>;
template class NavigationEngine<EulerPlatform>;
template struct AidUpdate<NavigationEngine<EulerPlatform>>;
template class Estimator<EulerPlatform>;
template class Corrector<EulerPlatform::kStates, EulerPlatform::kMeasurements>;

}  // namespace truenorth
