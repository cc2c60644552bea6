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

}  // namespace
}  // namespace truenorth
