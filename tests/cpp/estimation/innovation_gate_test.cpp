#include "estimation/innovation_gate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

TEST(Nis, IsTheSquaredResidualInUnitsOfItsCovariance) {
    RandomCovariance random(2);
    const Matrix<4> P = random.covariance<4>(0.1, 1.0);
    const Matrix<2, 4> H = random.normal<2, 4>();
    const Matrix<2> R = random.covariance<2>(0.1, 1.0);
    const Vector<2> r(0.7, -1.1);
    const Matrix<2> S = H * P * H.transpose() + R;
    const double expected = r.dot(Matrix<2>(inverse(S)) * r);
    EXPECT_NEAR((nis(innovation_of<4, 2>(P, H, R, r))), expected, 1e-13);
}

TEST(Nis, IsChiSquareWithOneDegreeAChannelForAConsistentFilter) {
    // Mean 2, variance 4 for two channels; the mean of 20000 within 3.9 sigma: confidence 99.99 %.
    for (const unsigned seed : {40U, 41U}) {
        RandomCovariance random(seed);
        const Matrix<2> P = random.covariance<2>(0.1, 1.0);
        const Matrix<2> R = random.covariance<2>(0.1, 1.0);
        const Matrix<2> root = Matrix<2>(P + R).llt().matrixL();
        constexpr int draws = 20000;
        double sum = 0.0;
        for (int i = 0; i < draws; ++i) {
            const Vector<2> residual = root * random.normal<2, 1>();
            sum += nis(innovation_of<2, 2>(P, Matrix<2>::Identity(), R, residual));
        }
        EXPECT_NEAR(sum / draws, 2.0, 3.9 * 2.0 / std::sqrt(draws));
    }
}

// Two channels, the first of which causes all of the NIS.
Innovation<2, 2> of_nis(double nis) {
    const Matrix<2> I = Matrix<2>::Identity();
    return innovation_of<2, 2>(I, I, I, Vector<2>(std::sqrt(2.0 * nis), 0.0));
}

TEST(InnovationGate, AdmitsUpToItsThreshold) {
    const InnovationGate gate{{.enabled = true, .threshold = 16.0}};
    EXPECT_TRUE(gate.admits(nis(of_nis(0.0)), 2));
    EXPECT_TRUE(gate.admits(nis(of_nis(15.9999)), 2));
    EXPECT_FALSE(gate.admits(nis(of_nis(16.0001)), 2));
}

TEST(InnovationGate, DoesNotAdmitWhatIsNoNumber) {
    EXPECT_FALSE((InnovationGate{{.enabled = true, .threshold = 16.0}}.admits(
        nis(of_nis(std::numeric_limits<double>::quiet_NaN())), 2)));
}

TEST(InnovationGate, AdmitsEverythingWhenDisabled) {
    EXPECT_TRUE((InnovationGate{{.enabled = false, .threshold = 16.0}}.admits(nis(of_nis(1e6)), 2)));
}

}  // namespace
}  // namespace truenorth
