// Matrices of a size that is known at run time alone, up to a limit and without allocation: for what is
// compiled once for the models of any number of states. The eigenvalues of a matrix of fixed size cost a
// compiler more than all the rest of a filter.
#pragma once

#include <Eigen/Core>

namespace truenorth {

inline constexpr int kMostStates = 24;  // or channels

using BoundedMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;
using BoundedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;

}  // namespace truenorth
