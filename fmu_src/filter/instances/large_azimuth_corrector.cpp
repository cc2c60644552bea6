#include "filter/large_azimuth_adapter.hpp"

namespace truenorth {

template class Corrector<LargeAzimuth::kStates, LargeAzimuth::kMeasurements>;

}  // namespace truenorth
