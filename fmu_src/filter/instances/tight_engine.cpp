#include "filter/tight_adapter.hpp"

namespace truenorth {

template class Engine<Tight>;
template class NavigationEngine<Tight>;

}  // namespace truenorth
