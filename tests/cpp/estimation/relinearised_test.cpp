#include "estimation/relinearised.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>

#include "estimation/example_models.hpp"
#include "estimation/linearised.hpp"
#include "estimation/random_covariance.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

const auto kStandard = [](const auto& prior, const auto& innovation) {
    return Standard().correct(prior, innovation);
};

template <class Model, int Count>
std::array<Epoch<Model>, Count> random_epochs(RandomCovariance& random) {
    std::array<Epoch<Model>, Count> epochs;
    for (auto& epoch : epochs) {
        epoch.fix.value = random.normal<2, 1>();
    }
    return epochs;
}

TEST(FilterAlongTrajectory, IsTheRecursiveFilterOfALinearModel) {
    RandomCovariance random(1);
    LinearModel<4> model;
    model.F = Matrix<4>::Identity() + 0.2 * random.normal<4, 4>();
    model.Q = random.covariance<4>(0.1, 1.0);
    const auto epochs = random_epochs<LinearModel<4>, 20>(random);

    Vector<4> x = random.normal<4, 1>();
    Matrix<4> P = random.covariance<4>(0.1, 2.0);
    Vector<4> recursive = x;
    Matrix<4> P_recursive = P;
    filter_along_trajectory(model, x, P, Vector<4>(Vector<4>::Zero()), epochs, kStandard);
    for (const auto& epoch : epochs) {
        Linearised().predict(model, recursive, P_recursive, epoch.interval);
        const auto correction =
            Standard().correct(P_recursive, innovate(model, recursive, P_recursive, epoch.fix));
        recursive += correction.deviation;
        P_recursive = correction.covariance;
    }
    EXPECT_LT((x - recursive).norm(), 1e-10);
    EXPECT_LT((P - P_recursive).norm(), 1e-10);
}

// Of a linear model it does not matter where the trajectory is, if the prior stays where it was.
TEST(FilterAlongTrajectory, KnowsWhereThePriorIs) {
    RandomCovariance random(3);
    LinearModel<4> model;
    model.F = Matrix<4>::Identity() + 0.2 * random.normal<4, 4>();
    model.Q = random.covariance<4>(0.1, 1.0);
    const auto epochs = random_epochs<LinearModel<4>, 20>(random);

    Vector<4> x = random.normal<4, 1>();
    Matrix<4> P = random.covariance<4>(0.1, 2.0);
    const Vector<4> away = random.normal<4, 1>();
    Vector<4> other = x + away;
    Matrix<4> P_other = P;
    filter_along_trajectory(model, x, P, Vector<4>(Vector<4>::Zero()), epochs, kStandard);
    filter_along_trajectory(model, other, P_other, Vector<4>(-away), epochs, kStandard);
    EXPECT_LT((x - other).norm(), 1e-10);
    EXPECT_LT((P - P_other).norm(), 1e-10);
}

// The state at the end that minimises the squares of all residuals and of the prior, without process noise,
// linearised at the trajectory.
TEST(FilterAlongTrajectory, IsTheGaussNewtonStepOfACurvedModel) {
    RandomCovariance random(2);
    const CurvedModel model;
    const auto epochs = random_epochs<CurvedModel, 6>(random);
    const Vector<3> start(0.3, -0.2, 0.5);
    const Matrix<3> prior = random.covariance<3>(0.5, 2.0);

    Matrix<3> information = prior.inverse();
    Vector<3> right = Vector<3>::Zero();
    Vector<3> trajectory = start;
    Matrix<3> to_end = Matrix<3>::Identity();
    for (const auto& epoch : epochs) {
        to_end = CurvedModel::transition(trajectory, {}) * to_end;
        trajectory = CurvedModel::moved(trajectory);
        const Matrix<2, 3> H = to_end.topRows<2>();
        const Eigen::Matrix2d R_inverse = CurvedModel::measurement_noise(trajectory, epoch.fix).inverse();
        information += H.transpose() * R_inverse * H;
        right += H.transpose() * R_inverse * CurvedModel::residual(trajectory, epoch.fix);
    }
    const Vector<3> step = to_end * information.ldlt().solve(right);
    const Matrix<3> covariance = to_end * information.inverse() * to_end.transpose();

    Vector<3> x = start;
    Matrix<3> P = prior;
    filter_along_trajectory(model, x, P, Vector<3>(Vector<3>::Zero()), epochs, kStandard);
    EXPECT_LT((x - (trajectory + step)).norm(), 1e-9 * step.norm());
    EXPECT_LT((P - covariance).norm(), 1e-9 * covariance.norm());
    EXPECT_GT(step.norm(), 0.1);
}

}  // namespace
}  // namespace truenorth
