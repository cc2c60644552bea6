#include "estimation/model.hpp"

#include <gtest/gtest.h>

#include "estimation/example_models.hpp"
#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

static_assert(ErrorModel<LinearModel<4>>);
static_assert(!ErrorModel<Vector<4>>);

TEST(Innovate, PredictsAFixFromStateAndCovariance) {
    RandomCovariance random(6);
    const Matrix<4> P = random.covariance<4>(0.1, 2.0);
    const Vector<4> x(1.0, 2.0, 3.0, 4.0);
    const auto innovation = innovate(LinearModel<4>{}, x, P, {Eigen::Vector2d(1.5, 1.0)});
    EXPECT_EQ(innovation.residual, Eigen::Vector2d(0.5, -1.0));
    EXPECT_LT((innovation.spread - P.topLeftCorner<2, 2>()).norm(), 1e-15);
    EXPECT_LT((innovation.cross - P.leftCols<2>()).norm(), 1e-15);
    EXPECT_EQ(innovation.noise, Eigen::Matrix2d(Eigen::Vector2d(0.04, 0.09).asDiagonal()));
}

TEST(Innovate, OfAnyMeasurementMatrixIsPHtAndHPHt) {
    RandomCovariance random(7);
    const Matrix<4> P = random.covariance<4>(0.1, 2.0);
    const Matrix<2, 4> H = random.normal<2, 4>();
    const auto innovation =
        innovate(LinearModel<4>{}, Vector<4>(Vector<4>::Zero()), P, {Eigen::Vector2d::Zero()}, H);
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 4; ++i) {
            double cross = 0.0;
            for (int k = 0; k < 4; ++k) {
                cross += P(i, k) * H(j, k);
            }
            EXPECT_NEAR(innovation.cross(i, j), cross, 1e-13);
        }
        for (int i = 0; i < 2; ++i) {
            double spread = 0.0;
            for (int k = 0; k < 4; ++k) {
                for (int l = 0; l < 4; ++l) {
                    spread += H(i, k) * P(k, l) * H(j, l);
                }
            }
            EXPECT_NEAR(innovation.spread(i, j), spread, 1e-13);
        }
    }
}

}  // namespace
}  // namespace truenorth
