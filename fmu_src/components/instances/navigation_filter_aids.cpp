#include "components/navigation_filter.hpp"
#include "filter/inertial_filter_aid.hpp"

namespace truenorth {

template bool NavigationFilterBase::take_aids(bool sampled);
template void NavigationFilterBase::watch_for_standstill();
template bool NavigationFilterBase::may_stand() const;

}  // namespace truenorth
