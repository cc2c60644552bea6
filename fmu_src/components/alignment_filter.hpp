// AlignmentFilter: finds the attitude of an inertial system, the heading above all, from a coarse start.
#pragma once

#include "AlignmentFilter/variables.hpp"
#include "components/euler_platform_adapter.hpp"
#include "components/inertial_filter.hpp"
#include "components/invariant_engine.hpp"
#include "components/large_azimuth_adapter.hpp"

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

    void step(double time, double step) { advance(time + step); }
};

}  // namespace truenorth
