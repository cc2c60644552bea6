// A parameter that breaks a rule; the text names the variable, its value and the rule.
#pragma once

#include <stdexcept>

namespace truenorth {

class InvalidParameter : public std::invalid_argument {
  public:
    using std::invalid_argument::invalid_argument;
};

}  // namespace truenorth
