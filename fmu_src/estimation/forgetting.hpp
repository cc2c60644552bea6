// How an H-infinity update forgets, for models of any number of states. Compiled once: the eigenvalues of a
// matrix cost a compiler more than all the rest of a corrector.
#pragma once

#include <Eigen/Core>

namespace truenorth::forgetting {

inline constexpr int kMostStates = 24;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;

// An eigenvalue of L P_post L / gamma^2 beyond this counts as infeasible: it would grow a thousandfold.
inline constexpr double kLargestRatio = 0.999;

// With L = diag(scale) and L P_post L = U diag(lambda) U^T,
//     P_k = P_post + P_post L U diag(1 / (gamma^2 - lambda_i)) U^T L P_post,
// feasible while every lambda_i < gamma^2. Returns false, and changes nothing, if it is not.
bool forget(Matrix& posterior, const Vector& scale, double gamma);

// The information matrix in units of sigma, J = S (P_post^-1 - gamma^-2 L^T L) S, keeps every eigenvalue
// above 1 / limit: feasible for any gamma. Clipping turns the axes a little and would shrink some
// directions below P_post; of the change only what adds variance is kept, because an update may forget
// but not learn here, at the price of passing the limit a little. Returns false, and changes nothing, if
// P_post has no inverse.
bool forget_below(Matrix& posterior, const Vector& scale, double gamma, const Vector& sigma, double limit);

}  // namespace truenorth::forgetting
