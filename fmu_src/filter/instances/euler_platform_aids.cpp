#include "filter/euler_platform_adapter.hpp"

namespace truenorth {

template struct AidUpdate<NavigationEngine<EulerPlatform>>;

}  // namespace truenorth
