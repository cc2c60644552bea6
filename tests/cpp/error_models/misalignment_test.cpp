#include "error_models/misalignment.hpp"

#include <gtest/gtest.h>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"

namespace truenorth {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<Misalignment, 3> kForms{Misalignment::large, Misalignment::large_azimuth,
                                             Misalignment::small};

// Rotations of coordinates are the transposes of the rotations of vectors.
Matrix3d exact(const Vector3d& alpha) {
    return (AngleAxisd(-alpha.y(), Vector3d::UnitY()) * AngleAxisd(-alpha.x(), Vector3d::UnitX()) *
            AngleAxisd(-alpha.z(), Vector3d::UnitZ()))
        .toRotationMatrix();
}

TEST(MisalignmentMatrix, IsTheProductOfTheThreeRotationsOfZhao2012) {
    RandomValues random(1);
    for (int n = 0; n < 50; ++n) {
        const Vector3d alpha = random.vector(3.0);
        EXPECT_LT((misalignment_matrix(Misalignment::large, alpha) - exact(alpha)).norm(), 2e-15);
    }
}

TEST(MisalignmentMatrix, BecomesEquation3ForSmallTiltAndEquation4ForSmallAngles) {
    // Quadratic terms in the tilt; of all three angles.
    const Vector3d small_tilt(1e-5, -2e-5, 2.0);
    EXPECT_LT((misalignment_matrix(Misalignment::large_azimuth, small_tilt) - exact(small_tilt)).norm(),
              1e-9);
    const Vector3d small(1e-5, -2e-5, 3e-5);
    EXPECT_LT((misalignment_matrix(Misalignment::small, small) - exact(small)).norm(), 3e-9);
    EXPECT_GT((misalignment_matrix(Misalignment::small, small_tilt) - exact(small_tilt)).norm(), 1.0);
}

TEST(MisalignmentMatrix, OfLargeAzimuthIsEquation3) {
    const double x = 0.02;
    const double y = -0.03;
    const double c = std::cos(2.1);
    const double s = std::sin(2.1);
    Matrix3d expected;
    expected << c, s, -y, -s, c, x, y * c + x * s, y * s - x * c, 1.0;
    EXPECT_LT((misalignment_matrix(Misalignment::large_azimuth, {x, y, 2.1}) - expected).norm(), 1e-16);
}

TEST(MisalignmentMatrix, DerivativesOfItsProductsAreThoseOfDifferences) {
    RandomValues random(2);
    for (int n = 0; n < 50; ++n) {
        const Vector3d alpha = random.vector(1.4);
        const Vector3d g = random.vector(10.0);
        for (const Misalignment form : kForms) {
            const auto product = [&](const Vector3d& a) -> Vector3d {
                return misalignment_matrix(form, a) * g;
            };
            const auto transposed = [&](const Vector3d& a) -> Vector3d {
                return misalignment_matrix(form, a).transpose() * g;
            };
            EXPECT_LT((derivative_of_product(form, alpha, g) - central_difference<3, 3>(product, alpha, 1e-5))
                          .norm(),
                      1e-8)
                << static_cast<int>(form);
            EXPECT_LT((derivative_of_transposed_product(form, alpha, g) -
                       central_difference<3, 3>(transposed, alpha, 1e-5))
                          .norm(),
                      1e-8)
                << static_cast<int>(form);
        }
    }
}

TEST(MisalignmentMatrix, TurnsAtTheRateOfEquation6) {
    // dC/dt = -(C_w alpha') x C.
    RandomValues random(3);
    for (int n = 0; n < 20; ++n) {
        const Vector3d alpha = random.vector(1.4);
        const Vector3d rate = random.vector(1.0);
        const double h = 1e-5;
        const Matrix3d change = (exact(alpha + h * rate) - exact(alpha - h * rate)) / (2.0 * h);
        EXPECT_LT((change + skew(euler_rate_matrix(alpha) * rate) * exact(alpha)).norm(), 1e-9);
    }
}

}  // namespace
}  // namespace truenorth
