#include "estimation/standard.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

constexpr int kStates = 6;
constexpr int kMeasurements = 2;

struct Case {
    explicit Case(RandomCovariance& random)
        : P(random.covariance<kStates>(0.05, 5.0)),
          H(random.normal<kMeasurements, kStates>()),
          R(random.covariance<kMeasurements>(0.05, 5.0)),
          residual(random.normal<kMeasurements, 1>()),
          correction(Standard().correct(P, innovation_of<kStates, kMeasurements>(P, H, R, residual))) {}

    Matrix<kStates> P;
    Matrix<kMeasurements, kStates> H;
    Matrix<kMeasurements> R;
    Vector<kMeasurements> residual;
    Correction<kStates, kMeasurements> correction;
};

class StandardCorrector : public testing::TestWithParam<unsigned> {
  protected:
    template <class Check>
    void for_random_cases(const Check& check) {
        RandomCovariance random(GetParam());
        for (int i = 0; i < 100; ++i) {
            check(Case(random));
        }
    }
};

TEST_P(StandardCorrector, AddsTheInformationOfTheMeasurement) {
    for_random_cases([](const Case& c) {
        const Matrix<kStates> information = c.P.inverse() + c.H.transpose() * c.R.inverse() * c.H;
        const Matrix<kStates> posterior = information.inverse();
        EXPECT_LT(relative_difference(c.correction.covariance, posterior), 1e-11);
        const Vector<kStates> deviation = posterior * c.H.transpose() * c.R.inverse() * c.residual;
        EXPECT_LT(relative_difference(c.correction.deviation, deviation), 1e-11);
    });
}

TEST_P(StandardCorrector, HasTheCovarianceOfJosephsForm) {
    for_random_cases([](const Case& c) {
        const Matrix<kStates, kMeasurements> K =
            c.P * c.H.transpose() * Matrix<kMeasurements>(c.H * c.P * c.H.transpose() + c.R).inverse();
        const Matrix<kStates> A = Matrix<kStates>::Identity() - K * c.H;
        const Matrix<kStates> joseph = A * c.P * A.transpose() + K * c.R * K.transpose();
        EXPECT_LT(relative_difference(c.correction.covariance, joseph), 1e-12);
    });
}

TEST_P(StandardCorrector, GivesASymmetricPositiveDefiniteCovarianceBelowThePrior) {
    for_random_cases([](const Case& c) {
        const Matrix<kStates>& posterior = c.correction.covariance;
        EXPECT_EQ(posterior, posterior.transpose());
        EXPECT_GT(smallest_eigenvalue(posterior), 0.0);
        EXPECT_GT(smallest_eigenvalue(c.P - posterior), -1e-13);
    });
}

INSTANTIATE_TEST_SUITE_P(Seeds, StandardCorrector, testing::Values(31U, 3141U));

TEST(StandardCorrectorByHand, WeighsPriorAndMeasurementOfAScalar) {
    // Prior variance 4, measurement variance 1, residual 10: gain 0.8.
    const auto correction = Standard().correct(
        Matrix<1>(4.0), innovation_of<1, 1>(Matrix<1>(4.0), Matrix<1>(1.0), Matrix<1>(1.0), Vector<1>(10.0)));
    EXPECT_NEAR(correction.deviation(0), 8.0, 1e-14);
    EXPECT_NEAR(correction.covariance(0), 0.8, 1e-15);
}

}  // namespace
}  // namespace truenorth
