// Rules that tie parameters of the plant to one another, which the declaration of a single variable cannot
// state.
#pragma once

#include "TruthPlant/variables.hpp"

namespace truenorth::truth_plant {

// Each parameter has passed validate() already. Throws InvalidParameter with a sentence such as
// "gnss.rate = 3: must be imu.rate (100) divided by a whole number".
void check_together(const Parameters& parameters);

}  // namespace truenorth::truth_plant
