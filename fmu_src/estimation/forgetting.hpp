// How an H-infinity update forgets, for models of any number of states.
#pragma once

#include "estimation/bounded.hpp"

namespace truenorth::forgetting {

// An eigenvalue of L P_post L / gamma^2 beyond this counts as infeasible: it would grow a thousandfold.
inline constexpr double kLargestRatio = 0.999;

// With L = diag(scale) and L P_post L = U diag(lambda) U^T,
//     P_k = P_post + P_post L U diag(1 / (gamma^2 - lambda_i)) U^T L P_post,
// feasible while every lambda_i < gamma^2. Returns false, and changes nothing, if it is not.
bool forget(BoundedMatrix& posterior, const BoundedVector& scale, double gamma);

// The information matrix in units of sigma, J = S (P_post^-1 - gamma^-2 L^T L) S, keeps every eigenvalue
// above 1 / limit: feasible for any gamma. Clipping turns the axes a little and would shrink some
// directions below P_post; of the change only what adds variance is kept, because an update may forget
// but not learn here, at the price of passing the limit a little. Returns false, and changes nothing, if
// P_post has no inverse.
bool forget_below(BoundedMatrix& posterior, const BoundedVector& scale, double gamma,
                  const BoundedVector& sigma, double limit);

}  // namespace truenorth::forgetting
