#include "filter/euler_platform_adapter.hpp"

namespace truenorth {

template class Estimator<EulerPlatform>;

}  // namespace truenorth
