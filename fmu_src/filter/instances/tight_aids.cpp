#include "filter/tight_adapter.hpp"

namespace truenorth {

template struct AidUpdate<NavigationEngine<Tight>>;

}  // namespace truenorth
