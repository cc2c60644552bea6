// Error of a navigation state, 9 components: misalignment phi [rad], velocity [m/s], position [m], all east,
// north, up, all computed minus true. One error equation for the loose, the tight and the full-state model.
//
// phi is the rotation vector of the computed frame n' relative to the true one, C_b^{n'} = exp(-phi x) C_b^n,
// so that it agrees for small angles with the Euler platform error angles of alignment. With w_in = w_ie +
// w_en and T the matrix of the transport rate (navigation_interval.hpp),
//
//     phi' = -w_in x phi + dw_in - C_b^{n'} eps
//     dv'  = f' x phi + C_b^{n'} nabla - (2 w_ie + w_en) x dv - (2 dw_ie + dw_en) x v + (2 g / R) dp_u up
//     dp'  = dv - w_en x dp + (T dp) x v
//     dw_ie = w_ie x (T dp),    dw_en = T dv + dT v
//
// dT: the change of T with height and latitude, save that of the radii with latitude; gravity changes with
// height alone. The third equation is exact on the ellipsoid.
#pragma once

#include "error_models/navigation_interval.hpp"
#include "estimation/gaussian.hpp"

namespace truenorth::navigation_error {

enum Block : int { kPhi = 0, kVelocity = 3, kPosition = 6, kCount = 9 };  // each three components
using Error = Vector<kCount>;

// The navigation state that is wrong by `error` when x is true, and the error of `computed` when x is true.
// A computed state is corrected by retract(computed, -error).
NavigationState retract(const NavigationState& x, const Error& error);
Error local(const NavigationState& x, const NavigationState& computed);

// Matrix F of the error equations; sensor errors stand apart.
Matrix<kCount> jacobian(const NavigationInterval& interval);

// Variance that the white noise of gyros [rad/s^0.5] and accelerometers [m/s^1.5] adds in dt.
Error random_walk_variance(double angle_random_walk, double velocity_random_walk, double dt);

// Jacobian of the error that remains after retract(computed, -error) with respect to the true one, at
// `error`. It turns and may shrink attitude errors, to 2 / pi at most, however large phi.
Matrix<kCount> correction_jacobian(const Error& error);

}  // namespace truenorth::navigation_error
