#include "filter/large_azimuth_adapter.hpp"

namespace truenorth {

template class Engine<LargeAzimuth>;
template class NavigationEngine<LargeAzimuth>;

}  // namespace truenorth
