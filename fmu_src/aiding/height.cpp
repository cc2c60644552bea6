#include "aiding/height.hpp"

namespace truenorth::aiding {

Observation<1> height(const Moment& moment, double measured) {
    const double predicted = moment.state.position.height + moment.sensors(kHeightBias);
    Observation<1> observation{.difference = Vector<1>(predicted - measured),
                               .sensitivity = Matrix<1, kErrors>::Zero()};
    observation.own(kHeightBias) = -1.0;
    observation.sensitivity(kPosition + 2) = 1.0;
    return observation;
}

}  // namespace truenorth::aiding
