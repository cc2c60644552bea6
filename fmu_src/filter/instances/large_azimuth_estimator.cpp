#include "filter/large_azimuth_adapter.hpp"

namespace truenorth {

template class Estimator<LargeAzimuth>;

}  // namespace truenorth
