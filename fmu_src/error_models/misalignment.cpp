#include "error_models/misalignment.hpp"

namespace truenorth {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Matrix3d azimuth_matrix(const Vector3d& alpha) {
    return misalignment_matrix(Misalignment::large_azimuth, {0.0, 0.0, alpha.z()});
}

}  // namespace

Matrix3d misalignment_matrix(Misalignment form, const Vector3d& alpha) {
    const MisalignmentMatrix<double> C(form, alpha.x(), alpha.y(), alpha.z());
    Matrix3d matrix;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            matrix(i, j) = C.times(i, Vector3d::Unit(j));
        }
    }
    return matrix;
}

// dC = -(C_w dalpha) x C for a rotation; the approximations are products of a skew matrix and C_z.
Matrix3d derivative_of_product(Misalignment form, const Vector3d& alpha, const Vector3d& g) {
    switch (form) {
        case Misalignment::large:
            return skew(misalignment_matrix(form, alpha) * g) * euler_rate_matrix(alpha);
        case Misalignment::large_azimuth: {
            const Vector3d turned = azimuth_matrix(alpha) * g;
            const Vector3d tilt(alpha.x(), alpha.y(), 0.0);
            Matrix3d derivative = skew(turned);
            derivative.col(2) -= tilt.cross(derivative.col(2));
            return derivative;
        }
        case Misalignment::small:
            break;
    }
    return skew(g);
}

Matrix3d derivative_of_transposed_product(Misalignment form, const Vector3d& alpha, const Vector3d& g) {
    switch (form) {
        case Misalignment::large:
            return -misalignment_matrix(form, alpha).transpose() * skew(g) * euler_rate_matrix(alpha);
        case Misalignment::large_azimuth: {
            const Vector3d tilt(alpha.x(), alpha.y(), 0.0);
            Matrix3d derivative = -skew(g);
            derivative.col(2) = Vector3d::UnitZ().cross(g + tilt.cross(g));
            return azimuth_matrix(alpha).transpose() * derivative;
        }
        case Misalignment::small:
            break;
    }
    return -skew(g);
}

Matrix3d euler_rate_matrix(const Vector3d& alpha) {
    const auto [sx, cx] = sincos(alpha.x());
    const auto [sy, cy] = sincos(alpha.y());
    Matrix3d C_w;
    C_w << cy, 0.0, -sy * cx,  //
        0.0, 1.0, sx,          //
        sy, 0.0, cy * cx;
    return C_w;
}

NavigationState realigned(const NavigationState& computed, const Vector3d& alpha) {
    NavigationState state = computed;
    const Matrix3d C = misalignment_matrix(Misalignment::large, alpha);
    state.q_bn = Eigen::Quaterniond(C.transpose()) * computed.q_bn;
    state.q_bn.normalize();
    return state;
}

// A change d of the angles turns n' by C_w d, which C^T resolves in the realigned frame.
Matrix3d realignment_jacobian(const Vector3d& alpha) {
    return misalignment_matrix(Misalignment::large, alpha).transpose() * euler_rate_matrix(alpha);
}

}  // namespace truenorth
