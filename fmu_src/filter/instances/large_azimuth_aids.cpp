#include "filter/large_azimuth_adapter.hpp"

namespace truenorth {

template struct AidUpdate<NavigationEngine<LargeAzimuth>>;

}  // namespace truenorth
