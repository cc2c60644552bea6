// Robust corrector of Zhou 2011: H-infinity filtering as a Kalman filter in Krein space.
//
// The linear combination L x is to be estimated with an error energy below gamma^2 times the energy of the
// disturbances. The gain is the standard one; the posterior loses information at every update,
//
//     P_k = (P_post^-1 - gamma^-2 L^T L)^-1,   P_post the standard posterior,
//
// which is Zhou 2011 eq. 11 (with eqs. 8-9 inserted) by the matrix inversion lemma; in the paper R = I and
// the process noise is Gamma Gamma^T because its system is noise-normalised, here R and Q keep their units.
// Misprint of Zhou 2011: the L_k at the end of eq. 10 is one too many, M_k of eq. 11 being K_Z L_k.
#pragma once

#include <limits>
#include <optional>

#include "estimation/forgetting.hpp"
#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

template <int N>
class HInfinity {
    static_assert(N <= kMostStates);

  public:
    // Bounds what an update may forget: in units of `sigma`, no eigenvalue of the posterior grows beyond
    // about `limit` (1.2 times it at worst, see forgetting.hpp).
    struct Ceiling {
        Vector<N> sigma;
        double limit;
    };

    double gamma = 2.0;
    Vector<N> scale = Vector<N>::Ones();  // the diagonal of L; 0 leaves a state out
    std::optional<Ceiling> ceiling = std::nullopt;

    template <int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        Correction<N, M> result = Standard().correct(prior, innovation);
        if (scale.isZero(0.0)) {
            return result;
        }
        BoundedMatrix posterior = result.covariance;
        result.feasible =
            ceiling ? forgetting::forget_below(posterior, scale, gamma, ceiling->sigma, ceiling->limit)
                    : forgetting::forget(posterior, scale, gamma);
        result.covariance = posterior;
        // Backing off means to forget nothing at this update. A gamma that is just feasible would instead let
        // what the measurement does not see grow without bound from update to update.
        result.gamma_effective = result.feasible ? gamma : std::numeric_limits<double>::infinity();
        symmetrise(result.covariance);
        return result;
    }
};

}  // namespace truenorth
