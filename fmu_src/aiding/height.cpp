#include "aiding/height.hpp"

namespace truenorth::aiding {

Observation<1> height(const Moment& moment, double measured) {
    Observation<1> observation{.difference = Vector<1>(moment.state.position.height - measured),
                               .sensitivity = Matrix<1, kErrors>::Zero()};
    observation.sensitivity(kPosition + 2) = 1.0;
    return observation;
}

}  // namespace truenorth::aiding
