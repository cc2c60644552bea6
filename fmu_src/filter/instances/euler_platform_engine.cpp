#include "filter/euler_platform_adapter.hpp"

namespace truenorth {

template class Engine<EulerPlatform>;
template class NavigationEngine<EulerPlatform>;

}  // namespace truenorth
