#include "components/alignment_filter.hpp"
#include "filter/inertial_filter_health.hpp"

namespace truenorth {

template void AlignmentFilterBase::publish();
template void AlignmentFilterBase::publish_if_possible();
template void AlignmentFilterBase::publish_health();
template Contradiction AlignmentFilterBase::contradiction(const AttitudeLedger::Gyros& gyros) const;
template AttitudeLedger::Gyros AlignmentFilterBase::gyros() const;
template void AlignmentFilterBase::publish_status();

}  // namespace truenorth
