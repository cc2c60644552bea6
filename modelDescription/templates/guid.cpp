// Generated from all that makes {{ component.name }}; do not edit.
#include "fmi/fmu.hpp"

namespace truenorth::fmi {

const char* guid() { return "{{ guid }}"; }

}  // namespace truenorth::fmi
