#include "components/alignment_filter.hpp"
#include "filter/inertial_filter_aid.hpp"

namespace truenorth {

template bool AlignmentFilterBase::take_aids(bool sampled);

}  // namespace truenorth
