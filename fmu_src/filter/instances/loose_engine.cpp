#include "filter/loose_adapter.hpp"

namespace truenorth {

template class Engine<Loose>;
template class NavigationEngine<Loose>;

}  // namespace truenorth
