#include "filter/euler_platform_adapter.hpp"

namespace truenorth {

template class Corrector<EulerPlatform::kStates, EulerPlatform::kMeasurements>;

}  // namespace truenorth
