// Misalignment of the computed navigation frame n' as Euler platform error angles alpha = (alpha_x, alpha_y,
// alpha_z): rotations up, east and north in turn lead from n to n' (Zhao 2012, section 1.1).
//
//     large           C = C_n^{n'} = C_y C_x C_z                                   (Zhao 2012 eq. 2)
//     large azimuth   C = (I - (alpha_x, alpha_y, 0) x) C_z                        (eq. 3 = Zhou 2011 eq. 13)
//     small           C = I - alpha x                                              (eqs. 4, 5)
#pragma once

#include <array>

#include "elementary/sincos.hpp"
#include "estimation/gaussian.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

enum class Misalignment { large, large_azimuth, small };

// C for every point of a set: Row is an array with an element a point, or a number.
template <class Row>
class MisalignmentMatrix {
  public:
    MisalignmentMatrix(Misalignment form, const Row& x, const Row& y, const Row& z) {
        if (form == Misalignment::small) {
            const Row one = 1.0 + 0.0 * z;
            C_ = {{{one, z, -y}, {-z, one, x}, {y, -x, one}}};
            return;
        }
        const auto [sz, cz] = sincos(z);
        if (form == Misalignment::large_azimuth) {
            C_ = {{{cz, sz, -y}, {-sz, cz, x}, {y * cz + x * sz, y * sz - x * cz, 1.0 + 0.0 * z}}};
            return;
        }
        const auto [sx, cx] = sincos(x);
        const auto [sy, cy] = sincos(y);
        C_ = {{{cy * cz - sy * sx * sz, cy * sz + sy * sx * cz, -sy * cx},
               {-cx * sz, cx * cz, sx},
               {sy * cz + cy * sx * sz, sy * sz - cy * sx * cz, cy * cx}}};
    }

    // Components of C g and of C^T g; g is one vector, or the Components of one a point.
    template <class G>
    [[nodiscard]] Row times(int i, const G& g) const {
        return C_[i][0] * g[0] + C_[i][1] * g[1] + C_[i][2] * g[2];
    }
    template <class G>
    [[nodiscard]] Row transposed_times(int i, const G& g) const {
        return C_[0][i] * g[0] + C_[1][i] * g[1] + C_[2][i] * g[2];
    }

  private:
    std::array<Components<Row>, 3> C_;
};

// C of one set of angles, and the derivatives of C g and C^T g with respect to them.
Eigen::Matrix3d misalignment_matrix(Misalignment form, const Eigen::Vector3d& alpha);
Eigen::Matrix3d derivative_of_product(Misalignment form, const Eigen::Vector3d& alpha,
                                      const Eigen::Vector3d& g);
Eigen::Matrix3d derivative_of_transposed_product(Misalignment form, const Eigen::Vector3d& alpha,
                                                 const Eigen::Vector3d& g);

// C_w: the angles' rates -> angular rate of n' relative to n, in n' (Zhao 2012 eq. 6). Singular where alpha_x
// is a quarter turn.
Eigen::Matrix3d euler_rate_matrix(const Eigen::Vector3d& alpha);

// The navigation state with its misalignment removed, as a rotation without approximation.
NavigationState realigned(const NavigationState& computed, const Eigen::Vector3d& alpha);

// Jacobian of the misalignment that remains after that with respect to the true one, at alpha.
Eigen::Matrix3d realignment_jacobian(const Eigen::Vector3d& alpha);

}  // namespace truenorth
