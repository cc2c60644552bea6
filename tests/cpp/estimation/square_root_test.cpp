#include "estimation/square_root.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

TEST(SquareRootOf, TimesItsTransposeIsTheCovariance) {
    for (const unsigned seed : {7U, 70U}) {
        RandomCovariance random(seed);
        for (int i = 0; i < 100; ++i) {
            const Matrix<10> P = random.covariance<10>(1e-12, 1.0);
            const auto root = square_root<10>(P);
            EXPECT_TRUE(root.valid);
            EXPECT_FALSE(root.repaired);
            EXPECT_LT(relative_difference(Matrix<10>(root.factor * root.factor.transpose()), P), 1e-14);
        }
    }
}

template <int N>
void expect_the_root_of_eigen() {
    RandomCovariance random(3);
    for (int i = 0; i < 20; ++i) {
        const Matrix<N> P = random.covariance<N>(1e-6, 1.0);
        const Matrix<N> L = Eigen::LLT<Matrix<N>>(P).matrixL();
        const auto found = cholesky<N>(P);
        ASSERT_TRUE(found);
        EXPECT_LT((*found - L).norm(), 1e-13 * L.norm());
        EXPECT_TRUE(Matrix<N>(found->template triangularView<Eigen::StrictlyUpper>()).isZero(0.0));
    }
}

TEST(Cholesky, FindsTheLowerTriangleThatEigenFinds) {
    expect_the_root_of_eigen<1>();
    expect_the_root_of_eigen<6>();
    expect_the_root_of_eigen<9>();
    expect_the_root_of_eigen<15>();
}

TEST(Cholesky, FindsNoneOfWhatIsNotPositiveDefinite) {
    Matrix<2> indefinite = Matrix<2>::Ones();
    indefinite(0, 1) = indefinite(1, 0) = 1.5;
    EXPECT_FALSE(cholesky<2>(indefinite));
    EXPECT_FALSE(cholesky<2>(Matrix<2>::Zero()));
    EXPECT_FALSE(cholesky<2>(Matrix<2>::Constant(std::numeric_limits<double>::quiet_NaN())));
}

TEST(SquareRootOf, SetsNegativeEigenvaluesOfTheCorrelationToZero) {
    // Correlation 1.5 has the eigenvalues 2.5 and -0.5: (1, 1) / sqrt(2) with 2.5 remains.
    const Vector<3> sigma(1e-6, 1.0, 1e3);
    Matrix<3> correlation = Matrix<3>::Identity();
    correlation(0, 1) = correlation(1, 0) = 1.5;
    const auto root = square_root<3>(sigma.asDiagonal() * correlation * sigma.asDiagonal());
    EXPECT_TRUE(root.valid);
    EXPECT_TRUE(root.repaired);

    Matrix<3> nearest = Matrix<3>::Identity();
    nearest.topLeftCorner<2, 2>().setConstant(1.25);
    const Vector<3> inverse = sigma.cwiseInverse();
    const Matrix<3> found =
        inverse.asDiagonal() * root.factor * root.factor.transpose() * inverse.asDiagonal();
    EXPECT_LT(relative_difference(found, nearest), 1e-14);
}

TEST(SquareRootOf, RepairsRoundingNoiseWithinRounding) {
    for (const unsigned seed : {8U, 80U}) {
        RandomCovariance random(seed);
        const Vector<5> v = random.normal<5, 1>();
        Matrix<5> P = v * v.transpose();  // rank one
        P(4, 4) -= 1e-12;
        const auto root = square_root<5>(P);
        EXPECT_TRUE(root.repaired);
        EXPECT_TRUE(root.valid);
        EXPECT_LT(relative_difference(Matrix<5>(root.factor * root.factor.transpose()), P), 1e-10);
    }
}

TEST(SquareRootOf, TakesAStateWithoutVariance) {
    Matrix<2> P = Matrix<2>::Zero();
    P(1, 1) = 4.0;
    const auto root = square_root<2>(P);
    EXPECT_TRUE(root.valid);
    EXPECT_LT((root.factor * root.factor.transpose() - P).norm(), 1e-15);
}

TEST(SquareRootOf, TakesANegativeVarianceAsNone) {
    const Matrix<2> P = Eigen::Vector2d(-1e-3, 4.0).asDiagonal();
    const auto root = square_root<2>(P);
    EXPECT_TRUE(root.repaired);
    EXPECT_TRUE(root.valid);
    EXPECT_LT(
        (root.factor * root.factor.transpose() - Matrix<2>(Eigen::Vector2d(0.0, 4.0).asDiagonal())).norm(),
        1e-15);
}

TEST(SquareRootOf, WhatIsNotFiniteIsInvalid) {
    for (const double value :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (const auto& [row, column] : {std::pair{0, 0}, {2, 1}, {0, 2}}) {
            Matrix<3> P = Matrix<3>::Identity();
            P(row, column) = P(column, row) = value;
            EXPECT_FALSE(square_root<3>(P).valid);
        }
    }
}

}  // namespace
}  // namespace truenorth
