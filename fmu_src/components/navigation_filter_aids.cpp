#include "components/inertial_filter_aid.hpp"
#include "components/navigation_filter.hpp"

namespace truenorth {

template bool NavigationFilterBase::take_aids();

}  // namespace truenorth
