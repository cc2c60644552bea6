#include "filter/loose_adapter.hpp"

namespace truenorth {

template struct AidUpdate<NavigationEngine<Loose>>;

}  // namespace truenorth
