#include "components/alignment_filter.hpp"
#include "filter/inertial_filter_fix.hpp"

namespace truenorth {

template GnssFix AlignmentFilterBase::fix_at(const Port& port);
template bool AlignmentFilterBase::take_fix();
template bool AlignmentFilterBase::read_fix();
template void AlignmentFilterBase::use(const Port& port, double valid_at);
template void AlignmentFilterBase::question_place(const GnssFix& fix, const AntennaState& then);
template bool AlignmentFilterBase::is_within_reach(const GnssFix& fix, const AntennaState& then);
template void AlignmentFilterBase::reject_fix(Refusal refusal, const Port& port);
template void AlignmentFilterBase::give_up_waiting();
template void AlignmentFilterBase::note_use(const GnssFix::Mask& measured);
template void AlignmentFilterBase::follow(const Change& change);
template void AlignmentFilterBase::turn(const Eigen::Matrix3d& rotation);
template void AlignmentFilterBase::report_infeasible();

}  // namespace truenorth
