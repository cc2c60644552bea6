// How a prediction went.
#pragma once

namespace truenorth {

enum class Prediction {
    sound,
    repaired,  // the covariance was not positive definite; negative directions were set to zero
    failed,    // a value was not finite; state and covariance cannot be used any more
};

}  // namespace truenorth
