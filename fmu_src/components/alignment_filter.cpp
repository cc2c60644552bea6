#include "components/alignment_filter.hpp"

#include "filter/inertial_filter_run.hpp"

namespace truenorth {

template class InertialFilter<alignment_filter::Interface, NavigationEngine<LargeAzimuth>,
                              NavigationEngine<EulerPlatform>, InvariantEngine<false>, InvariantEngine<true>>;

void AlignmentFilter::initialise(double start_time) {
    prepare(start_time);
    set_out({.state = state_of(parameters.initial)});
    publish();
}

}  // namespace truenorth
