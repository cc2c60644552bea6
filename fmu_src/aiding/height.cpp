#include "aiding/height.hpp"

namespace truenorth::aiding {

Observation height(const Moment& moment, double measured) {
    const double predicted = moment.state.position.height + moment.sensors(kHeightBias);
    Observation observation{.difference = Observation::single(predicted - measured)};
    observation.sensitivity(0, kPosition + 2) = 1.0;
    observation.own(0, kHeightBias) = -1.0;
    return observation;
}

}  // namespace truenorth::aiding
