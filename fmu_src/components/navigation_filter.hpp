// NavigationFilter: integrated navigation with GNSS, from a start that is given or handed over by an
// alignment.
#pragma once

#include "NavigationFilter/variables.hpp"
#include "filter/full_state_adapter.hpp"
#include "filter/inertial_filter.hpp"
#include "filter/invariant_engine.hpp"
#include "filter/loose_adapter.hpp"
#include "filter/state_engine.hpp"
#include "filter/tight_adapter.hpp"

namespace truenorth {

using NavigationFilterBase =
    InertialFilter<navigation_filter::Interface, NavigationEngine<Loose>, StateEngine<FullState>,
                   NavigationEngine<Tight>, InvariantEngine<false>>;
extern template class InertialFilter<navigation_filter::Interface, NavigationEngine<Loose>,
                                     StateEngine<FullState>, NavigationEngine<Tight>, InvariantEngine<false>>;

class NavigationFilter : public NavigationFilterBase {
  public:
    using NavigationFilterBase::NavigationFilterBase;

    // Starts at start_time [s] from the inputs initial.*, or waits until initial.valid is true. Throws
    // InvalidParameter.
    void initialise(double start_time);

    void step(double time, double step);

    template <class Archive>
    void serialize(Archive& archive) {
        NavigationFilterBase::serialize(archive);
        archive(refused_);
    }

  private:
    void set_out_from_inputs();  // throws InvalidParameter
    void hand_over();

    bool refused_ = false;  // what is handed over now has been refused
};

}  // namespace truenorth
