// AlignmentFilter: finds the attitude of an inertial system, the heading above all, from a coarse start.
#pragma once

#include "AlignmentFilter/variables.hpp"
#include "filter/euler_platform_adapter.hpp"
#include "filter/inertial_filter.hpp"
#include "filter/invariant_engine.hpp"
#include "filter/large_azimuth_adapter.hpp"

namespace truenorth {

using AlignmentFilterBase =
    InertialFilter<alignment_filter::Interface, NavigationEngine<LargeAzimuth>,
                   NavigationEngine<EulerPlatform>, InvariantEngine<false>, InvariantEngine<true>>;
extern template class InertialFilter<alignment_filter::Interface, NavigationEngine<LargeAzimuth>,
                                     NavigationEngine<EulerPlatform>, InvariantEngine<false>,
                                     InvariantEngine<true>>;

class AlignmentFilter : public AlignmentFilterBase {
  public:
    using AlignmentFilterBase::AlignmentFilterBase;

    // Starts at start_time [s] from the parameters initial.*. Throws InvalidParameter.
    void initialise(double start_time);

    void step(double time, double step) { advance(time, step); }
};

}  // namespace truenorth
