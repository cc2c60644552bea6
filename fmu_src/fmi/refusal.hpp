// A call that cannot be honoured; the text says why, in words for the user of the FMU.
#pragma once

#include <stdexcept>

namespace truenorth::fmi {

class Refusal : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

}  // namespace truenorth::fmi
