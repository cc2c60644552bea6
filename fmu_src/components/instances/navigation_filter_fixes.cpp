#include "components/navigation_filter.hpp"
#include "filter/inertial_filter_fix.hpp"

namespace truenorth {

template GnssFix NavigationFilterBase::fix_at(const Port& port);
template bool NavigationFilterBase::take_fix();
template bool NavigationFilterBase::read_fix();
template void NavigationFilterBase::use(const Port& port, double valid_at);
template void NavigationFilterBase::question_place(const GnssFix& fix, const AntennaState& then);
template bool NavigationFilterBase::is_within_reach(const GnssFix& fix, const AntennaState& then);
template void NavigationFilterBase::reject_fix(Refusal refusal, const Port& port);
template void NavigationFilterBase::give_up_waiting();
template void NavigationFilterBase::note_use(const GnssFix::Mask& measured);
template void NavigationFilterBase::follow(const Change& change);
template void NavigationFilterBase::turn(const Eigen::Matrix3d& rotation);
template void NavigationFilterBase::report_infeasible();

}  // namespace truenorth
