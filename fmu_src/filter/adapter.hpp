// How an error model is joined to the interface of a filter: one specialisation of Adapter a model, in a file
// of its own. Parameters are those of any filter that offers the model, hence templates.
//
//   attitude, velocity, position, gyro, accelerometer    where its states are, as Blocks
//   markov                   optional: where the Gauss-Markov parts of its sensor errors are, a Block
//   is_chosen(p)             the parameters ask for this model
//   check(p)                 throws InvalidParameter for what the model cannot do
//   configure(model, p)      form and noise of the model
//   set_prior(sigma, p)      optional: prior sigmas of the states that are no Block
//   fix_of(sighting, port)   the model's Fix; `port` is the filter's input `gnss`
//   component(i)             optional: which component of a GnssFix measurement i is
//   slot(i, output)          optional: the element of an output such as `innovation` that is measurement i
//   publish(outputs, x, sigma)  optional: outputs of the states that are no Block
//   blame(P, more)           optional: the variance that an Uncertainty gives to states that are no Block
//   discrepancy(residual)    optional: how far off a fix is; else as its position and velocity say
//   small_angles             optional: its equations hold for small misalignments alone
//   renewed(port, restart)   optional: calls restart(i) when measurement i comes from another source
//
// Estimator and correctors of a model are compiled in the adapter's own source file, once for every
// component.
#pragma once

#include "estimation/corrector.hpp"
#include "estimation/estimator.hpp"
#include "filter/sighting.hpp"
#include "filter/uncertainty.hpp"

namespace truenorth {

// Consecutive states: the first of them and how many; none where the model lacks the quantity.
struct Block {
    int first = 0;
    int count = 0;
};

template <class Model>
struct Adapter;

// The three components of a block; those that the model lacks are `absent`.
template <int N>
Eigen::Vector3d components(const Vector<N>& x, Block block, double absent = 0.0) {
    Eigen::Vector3d v = Eigen::Vector3d::Constant(absent);
    v.head(block.count) = x.segment(block.first, block.count);
    return v;
}

}  // namespace truenorth
