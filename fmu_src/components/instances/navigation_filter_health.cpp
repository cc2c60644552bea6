#include "components/navigation_filter.hpp"
#include "filter/inertial_filter_health.hpp"

namespace truenorth {

template void NavigationFilterBase::publish();
template void NavigationFilterBase::publish_if_possible();
template void NavigationFilterBase::publish_health();
template Contradiction NavigationFilterBase::contradiction(const AttitudeLedger::Gyros& gyros) const;
template AttitudeLedger::Gyros NavigationFilterBase::gyros() const;
template void NavigationFilterBase::publish_status();

}  // namespace truenorth
