#include "components/alignment_filter.hpp"

#include "components/inertial_filter_fix.hpp"
#include "components/inertial_filter_run.hpp"

namespace truenorth {

template class InertialFilter<alignment_filter::Interface, NavigationEngine<LargeAzimuth>,
                              NavigationEngine<EulerPlatform>>;

void AlignmentFilter::initialise(double start_time) {
    prepare(start_time);
    const auto& initial = parameters.initial;
    set_out({.state = {.q_bn = Eigen::Quaterniond(
                           dcm({.roll = initial.roll, .pitch = initial.pitch, .heading = initial.heading})),
                       .velocity = initial.velocity,
                       .position = {.latitude = initial.latitude,
                                    .longitude = wrap_angle(initial.longitude),
                                    .height = initial.height}}});
    publish();
}

}  // namespace truenorth
