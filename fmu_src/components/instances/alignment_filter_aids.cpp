#include "components/alignment_filter.hpp"
#include "filter/inertial_filter_aid.hpp"

namespace truenorth {

template bool AlignmentFilterBase::take_aids(bool sampled);
template void AlignmentFilterBase::watch_for_standstill();
template bool AlignmentFilterBase::may_stand() const;

}  // namespace truenorth
