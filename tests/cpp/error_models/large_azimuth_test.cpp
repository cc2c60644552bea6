#include "error_models/large_azimuth.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include "estimation/augmented.hpp"
#include "estimation/estimator.hpp"
#include "estimation/linearised.hpp"
#include "estimation/standard.hpp"
#include "estimation/unscented.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Model = LargeAzimuth;
using State = Model::State;
using Form = Model::VelocityForm;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRate = 7.292115e-5;

// Rotations of coordinates, Zhao 2012 eq. 1, and their product, eq. 2.
Matrix3d C_x(double a) {
    return (Matrix3d() << 1, 0, 0, 0, std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a)).finished();
}
Matrix3d C_y(double a) {
    return (Matrix3d() << std::cos(a), 0, -std::sin(a), 0, 1, 0, std::sin(a), 0, std::cos(a)).finished();
}
Matrix3d C_z(double a) {
    return (Matrix3d() << std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0, 0, 0, 1).finished();
}
Matrix3d exact_C(const Vector3d& phi) { return C_y(phi.y()) * C_x(phi.x()) * C_z(phi.z()); }

// Zhou 2011 eq. 13.
Matrix3d large_azimuth_C(const Vector3d& phi) {
    const double c = std::cos(phi.z());
    const double s = std::sin(phi.z());
    return (Matrix3d() << c, s, -phi.y(), -s, c, phi.x(), phi.y() * c + phi.x() * s,
            phi.y() * s - phi.x() * c, 1.0)
        .finished();
}

// The angles of C_y C_x C_z.
Vector3d angles_of(const Matrix3d& C) {
    return {std::asin(C(1, 2)), std::atan2(-C(0, 2), C(2, 2)), std::atan2(-C(1, 0), C(1, 1))};
}

class Random {
  public:
    explicit Random(unsigned seed) : generator_(seed) {}
    double operator()(double limit) {
        return std::uniform_real_distribution<double>(-limit, limit)(generator_);
    }
    Vector3d vector(double limit) { return {(*this)(limit), (*this)(limit), (*this)(limit)}; }

    State state() {
        State x;
        x << (*this)(40.0), (*this)(40.0), (*this)(0.02), (*this)(0.02), (*this)(3.1), (*this)(0.02),
            (*this)(0.02), vector(1e-6);
        return x;
    }
    Model::Interval interval() {
        Model::Interval interval(IntervalAverage{}, {}, State::Zero());
        const double latitude = (*this)(1.3);
        const earth::Position position{.latitude = latitude, .longitude = 0.0, .height = 100.0};
        interval.dt = 1.0;
        interval.C_bn = dcm({.roll = (*this)(0.5), .pitch = (*this)(0.5), .heading = (*this)(3.0)});
        interval.force = Vector3d(0.0, 0.0, 9.8) + vector(2.0);
        interval.velocity = vector(100.0);
        interval.omega_ie = {0.0, kRate * std::cos(latitude), kRate * std::sin(latitude)};
        interval.omega_en = earth::transport_rate(position, interval.velocity);
        interval.per_meridian_radius = 1.0 / (earth::radii(latitude).meridian + 100.0);
        interval.per_prime_vertical_radius = 1.0 / (earth::radii(latitude).prime_vertical + 100.0);
        interval.tan_latitude = std::tan(latitude);
        return interval;
    }

  private:
    std::mt19937 generator_;
};

// Zhou 2011 eqs. 12 to 14 with 3x3 matrices, word for word; `force` is what each form puts in
// place of the first two terms of dv'.
template <class Force>
State transcription(const State& x, const Model::Interval& i, const Force& force_terms) {
    const Vector3d dv(x(0), x(1), 0.0);
    const Vector3d phi = x.segment<3>(2);
    const Vector3d nabla(x(5), x(6), 0.0);
    const Vector3d eps = x.segment<3>(7);
    const Matrix3d I = Matrix3d::Identity();
    const Matrix3d C = large_azimuth_C(phi);
    const Vector3d dw_en(-dv.y() * i.per_meridian_radius, dv.x() * i.per_prime_vertical_radius,
                         dv.x() * i.per_prime_vertical_radius * i.tan_latitude);

    State rate = State::Zero();
    rate.segment<3>(2) = (I - C) * (i.omega_ie + i.omega_en) + dw_en - i.C_bn * eps;
    const Vector3d dv_rate = force_terms(C, Vector3d(i.C_bn * nabla)) -
                             (2.0 * i.omega_ie + i.omega_en).cross(dv) - dw_en.cross(i.velocity + dv);
    rate.head<2>() = dv_rate.head<2>();
    return rate;
}

State expected_rate(Form form, const State& x, const Model::Interval& i) {
    const Matrix3d I = Matrix3d::Identity();
    return transcription(x, i, [&](const Matrix3d& C, const Vector3d& nabla) -> Vector3d {
        switch (form) {
            case Form::transposed:
                return (I - C.transpose()) * i.force + C.transpose() * nabla;
            case Form::computed_force:
                return (C - I) * i.force + nabla;
            case Form::vertical_force:
                return (C - I) * Vector3d(0.0, 0.0, i.force.z()) + nabla;
            case Form::printed:
                return (C - I) * i.force + nabla + Vector3d(x(3) * i.force.z(), 0.0, 0.0);
        }
        return Vector3d::Zero();
    });
}

constexpr std::array<Form, 4> kForms{Form::transposed, Form::computed_force, Form::vertical_force,
                                     Form::printed};

// How many points there are, and beside which others one lies, makes no difference to the bit.
TEST(LargeAzimuthPoints, MoveAsEachMovesAlone) {
    Random random(11);
    const Model model;
    const Model::Interval interval = random.interval();
    const State x = random.state();
    Points<Model::kStates, 21> together = Points<Model::kStates, 21>::Zero();
    for (int i = 1; i < 21; ++i) {
        together.col(i) = 0.1 * random.state();
    }
    const Points<Model::kStates, 21> before = together;
    State centre = x;
    model.propagate(centre, together, interval);
    for (int i = 0; i < 21; ++i) {
        Points<Model::kStates, 2> alone = Points<Model::kStates, 2>::Zero();
        alone.col(1) = before.col(i);
        State moved = x;
        model.propagate(moved, alone, interval);
        EXPECT_EQ(moved, centre);
        EXPECT_EQ(State(alone.col(1)), State(together.col(i))) << i;
    }
}

TEST(LargeAzimuthRate, IsTheTranscriptionOfEveryForm) {
    for (const unsigned seed : {1U, 2024U}) {
        Random random(seed);
        for (int n = 0; n < 100; ++n) {
            const State x = random.state();
            const Model::Interval interval = random.interval();
            for (const Form form : kForms) {
                const State difference =
                    Model{.velocity_form = form}.rate(x, interval) - expected_rate(form, x, interval);
                EXPECT_LT(difference.head<2>().norm(), 1e-13) << static_cast<int>(form);
                EXPECT_LT(difference.tail<8>().norm(), 1e-18) << static_cast<int>(form);
            }
        }
    }
}

TEST(LargeAzimuthRate, OfThePrintedFormIsEquation14OfZhou2011) {
    // Level flight, as printed: no vertical velocity, R + h for R. Its V is the true velocity in w_en and
    // that of the mechanisation beside dw_en, which eq. 14 does not tell apart.
    Random random(3);
    for (int n = 0; n < 20; ++n) {
        const State x = random.state();
        Model::Interval i = random.interval();
        i.velocity.z() = 0.0;
        const double tan = i.tan_latitude;
        const double W = kRate * i.omega_ie.z() / i.omega_ie.norm();  // w_ie sin L
        const double R_e = 1.0 / i.per_prime_vertical_radius;
        const double V_e = i.velocity.x();
        const double mechanised_V_e = V_e + x(0);
        const double mechanised_V_n = i.velocity.y() + x(1);
        const double c = std::cos(x(4));
        const double s = std::sin(x(4));
        const Vector3d nabla = i.C_bn * Vector3d(x(5), x(6), 0.0);
        const Vector3d& f = i.force;
        const double east = f.x() * (c - 1.0) + f.y() * s + x(0) * mechanised_V_n / R_e * tan +
                            x(1) * (2.0 * W + V_e / R_e * tan) + nabla.x();
        const double north = -f.x() * s + (c - 1.0) * f.y() + f.z() * x(2) -
                             x(0) * (2.0 * W + (V_e + mechanised_V_e) / R_e * tan) + nabla.y();
        const State rate = Model{.velocity_form = Form::printed}.rate(x, i);
        EXPECT_NEAR(rate(0), east, 1e-12);
        EXPECT_NEAR(rate(1), north, 1e-12);
    }
}

TEST(LargeAzimuthRate, TakesASetOfPointsAsItTakesEachOfThem) {
    Random random(4);
    const Model::Interval interval = random.interval();
    Points<Model::kStates, 21> set;
    for (int i = 0; i < 21; ++i) {
        set.col(i) = random.state();
    }
    for (const Form form : kForms) {
        const Model model{.velocity_form = form};
        const auto rates = model.rate(set, interval);
        for (int i = 0; i < 21; ++i) {
            const State alone = model.rate(State(set.col(i)), interval);
            EXPECT_LT((rates.col(i) - alone).norm(), 1e-14);
        }
    }
}

// Brute force: two mechanisations run side by side, one of them wrong by x.
struct Pair {
    Mechanisation truth;
    Mechanisation computed;
    Vector3d omega_b{0.05, -0.04, 0.08};
    Vector3d force_b{0.8, -0.5, 9.7};
    Vector3d omega_error;
    Vector3d force_error;

    Pair(const NavigationState& start, const State& x)
        : truth(start), omega_error(x.segment<3>(7)), force_error(x(5), x(6), 0.0) {
        NavigationState wrong = start;
        wrong.q_bn = Eigen::Quaterniond(exact_C(x.segment<3>(2))) * start.q_bn;
        wrong.velocity += Vector3d(x(0), x(1), 0.0);
        computed = Mechanisation(wrong);
    }
    // Horizontal velocity error and misalignment after one increment.
    [[nodiscard]] Vector<5> error_after(double dt) const {
        Pair later = *this;
        later.truth.advance({.dt = dt, .delta_angle = dt * omega_b, .delta_velocity = dt * force_b});
        later.computed.advance({.dt = dt,
                                .delta_angle = dt * (omega_b + omega_error),
                                .delta_velocity = dt * (force_b + force_error)});
        const Matrix3d C =
            (later.computed.state.q_bn * later.truth.state.q_bn.conjugate()).toRotationMatrix();
        Vector<5> error;
        error << (later.computed.state.velocity - later.truth.state.velocity).head<2>(), angles_of(C);
        return error;
    }
};

struct BruteForce {
    State rate;             // of the model
    Vector2d velocity;      // d(dv)/dt of the pair
    Vector3d misalignment;  // w_nn' of the pair, C_w alpha' (Zhao 2012 eq. 6)
};

BruteForce brute_force(double heading_error, double tilt, const Vector2d& velocity_error) {
    const NavigationState start{
        .q_bn = Eigen::Quaterniond(dcm({.roll = 0.1, .pitch = -0.15, .heading = 0.7})),
        .velocity = {8.0, -5.0, 0.0},
        .position = {.latitude = 0.56, .longitude = 2.0, .height = 20.0},
    };
    State x;
    x << velocity_error, tilt, -0.6 * tilt, heading_error, 8e-3, -5e-3, 2e-7, -3e-7, 1e-7;
    const Pair pair(start, x);

    const double h = 1e-3;
    Vector<5> now;
    now << x.head<5>();
    const Vector<5> derivative =
        (4.0 * pair.error_after(h) - pair.error_after(2.0 * h) - 3.0 * now) / (2.0 * h);

    Model::Interval interval(IntervalAverage{}, {}, State::Zero());
    interval.C_bn = pair.computed.state.q_bn.toRotationMatrix();
    interval.force = interval.C_bn * (pair.force_b + pair.force_error);
    interval.velocity = start.velocity;
    interval.omega_ie = earth::rate(start.position.latitude);
    interval.omega_en = earth::transport_rate(start.position, start.velocity);
    interval.per_meridian_radius =
        1.0 / (earth::radii(start.position.latitude).meridian + start.position.height);
    interval.per_prime_vertical_radius =
        1.0 / (earth::radii(start.position.latitude).prime_vertical + start.position.height);
    interval.tan_latitude = std::tan(start.position.latitude);

    Matrix3d C_w;
    C_w << std::cos(x(3)), 0.0, -std::sin(x(3)) * std::cos(x(2)),  //
        0.0, 1.0, std::sin(x(2)),                                  //
        std::sin(x(3)), 0.0, std::cos(x(3)) * std::cos(x(2));
    return {.rate = Model{}.rate(x, interval),
            .velocity = derivative.head<2>(),
            .misalignment = C_w * derivative.tail<3>()};
}

TEST(LargeAzimuthRate, IsTheErrorOfAMechanisationToFirstOrderInTheTilt) {
    for (const double heading_error : {10.0, 60.0, 120.0, -120.0}) {
        for (const double tilt : {2e-3, 1e-3}) {
            const auto [rate, velocity, misalignment] =
                brute_force(heading_error * kDegree, tilt, {0.05, -0.03});
            // Second order in the tilt: g tilt^2 and w tilt^2; the differences quotient adds 1e-7 and 1e-11.
            EXPECT_LT((rate.head<2>() - velocity).norm(), 9.8 * 2.0 * tilt * tilt + 1e-7) << heading_error;
            EXPECT_LT((rate.segment<3>(2) - misalignment).norm(), 9e-5 * 2.0 * tilt * tilt + 1e-11)
                << heading_error;
        }
    }
}

TEST(LargeAzimuthRate, IsTheErrorOfAMechanisationWhoseVelocityIsFarFromTheTruth) {
    // Open loop: without tilt nothing is neglected, and -dw_en x dv alone is up to 1600 tan(L) / R = 1.6e-4.
    for (const double heading_error : {0.0, 10.0, -120.0}) {
        for (const Vector2d& velocity_error : {Vector2d(40.0, 0.0), Vector2d(-25.0, 30.0)}) {
            const auto [rate, velocity, misalignment] =
                brute_force(heading_error * kDegree, 0.0, velocity_error);
            EXPECT_LT((rate.head<2>() - velocity).norm(), 2e-7) << heading_error;
            EXPECT_LT((rate.segment<3>(2) - misalignment).norm(), 1e-11) << heading_error;
        }
    }
}

TEST(LargeAzimuthJacobian, IsTheDerivativeOfTheRate) {
    const double rounding = 1e-8;  // of 10 m/s2, and the third derivative over the step
    for (const unsigned seed : {5U, 55U}) {
        Random random(seed);
        for (int n = 0; n < 50; ++n) {
            const State x = random.state();
            const Model::Interval interval = random.interval();
            for (const Form form : kForms) {
                const Model model{.velocity_form = form};
                const Matrix<Model::kStates> F = model.jacobian(x, interval);
                for (int j = 0; j < Model::kStates; ++j) {
                    const double h = 1e-5;
                    const State step = h * State::Unit(j);
                    const State expected =
                        (model.rate(State(x + step), interval) - model.rate(State(x - step), interval)) /
                        (2.0 * h);
                    EXPECT_LT((F.col(j) - expected).head<2>().norm(), rounding)
                        << static_cast<int>(form) << " " << j;
                    EXPECT_LT((F.col(j) - expected).tail<8>().norm(),
                              1e-10 * (1.0 + expected.tail<8>().norm()))
                        << j;
                }
            }
        }
    }
}

TEST(LargeAzimuthJacobian, OfTheVerticalForceKnowsNoHeadingInTheVelocity) {
    Random random(6);
    const Matrix<Model::kStates> F =
        Model{.velocity_form = Form::vertical_force}.jacobian(random.state(), random.interval());
    EXPECT_EQ(F(Model::kVelocityEast, Model::kPhiUp), 0.0);
    EXPECT_EQ(F(Model::kVelocityNorth, Model::kPhiUp), 0.0);
}

TEST(LargeAzimuthMeasurement, MatrixIsTheDerivativeOfThePrediction) {
    for (const unsigned seed : {7U, 70U}) {
        Random random(seed);
        for (int n = 0; n < 50; ++n) {
            const State x = random.state();
            const Model::Fix fix{.velocity_difference = Vector2d(1.0, -2.0),
                                 .lever_velocity = random.vector(3.0)};
            const auto H = Model::measurement_matrix(x, fix);
            for (int j = 0; j < Model::kStates; ++j) {
                const State step = 1e-5 * State::Unit(j);
                const Vector2d derivative =
                    -(Model::residual(x + step, fix) - Model::residual(x - step, fix)) / 2e-5;
                EXPECT_LT((H.col(j) - derivative).norm(), 1e-9) << j;
            }
        }
    }
}

TEST(LargeAzimuthMeasurement, OfTheTrueErrorsHasNoResidual) {
    // The antenna's computed velocity is v + dv + C_b^n' (w x l), the true one v + C_b^n (w x l).
    Random random(8);
    for (int n = 0; n < 50; ++n) {
        State x = random.state();
        x.segment<2>(Model::kPhiEast) *= 0.01;
        const Vector3d lever = random.vector(3.0);  // in n'
        const Vector3d true_lever = exact_C(x.segment<3>(2)).transpose() * lever;
        const Vector2d difference = x.head<2>() + (lever - true_lever).head<2>();
        EXPECT_LT(Model::residual(x, {difference, lever}).norm(), 3.0 * 2e-4 * 2e-4 * 2.0);  // tilt squared
    }
}

TEST(LargeAzimuthMeasurement, NoiseIsTheSquaredSigmaOfEachComponent) {
    const Model model{
        .noise = {.angle_random_walk = 1e-6, .velocity_random_walk = 1e-4, .velocity_sigma = 0.2}};
    const Model::Fix fix{.velocity_difference = Vector2d::Zero(), .lever_velocity = Vector3d::Zero()};
    EXPECT_LT((model.measurement_noise(State::Zero(), fix) - 0.04 * Eigen::Matrix2d::Identity()).norm(),
              1e-16);
}

TEST(LargeAzimuthProcessNoise, GrowsWithTimeAndTheSquaredRandomWalks) {
    Random random(9);
    Model::Interval interval = random.interval();
    interval.dt = 0.25;
    const Matrix<Model::kStates> Q =
        Model{.noise = {.angle_random_walk = 2e-6, .velocity_random_walk = 3e-4, .velocity_sigma = 0.1}}
            .process_noise(State::Zero(), interval);
    State expected;
    expected << 2.25e-8, 2.25e-8, 1e-12, 1e-12, 1e-12, 0.0, 0.0, 0.0, 0.0, 0.0;
    EXPECT_LT((Q - Matrix<Model::kStates>(expected.asDiagonal())).cwiseAbs().maxCoeff(), 1e-22);
}

TEST(LargeAzimuthCorrected, UndoesAKnownMisalignment) {
    Random random(11);
    for (int n = 0; n < 50; ++n) {
        const State x = random.state();
        const NavigationState truth{
            .q_bn =
                Eigen::Quaterniond(dcm({.roll = random(1.0), .pitch = random(1.0), .heading = random(3.0)})),
            .velocity = random.vector(50.0),
            .position = {.latitude = 0.5, .longitude = 1.0, .height = 2.0},
        };
        NavigationState computed = truth;
        computed.q_bn = Eigen::Quaterniond(exact_C(x.segment<3>(2))) * truth.q_bn;
        computed.velocity.head<2>() += x.head<2>();
        const NavigationState corrected = Model::corrected(computed, x);
        EXPECT_LT((corrected.q_bn.toRotationMatrix() - truth.q_bn.toRotationMatrix()).norm(), 3e-15);
        EXPECT_LT((corrected.velocity - truth.velocity).norm(), 3e-14);
        EXPECT_EQ(corrected.position.latitude, truth.position.latitude);
    }
}

TEST(LargeAzimuthCorrected, ForAHeadingErrorAloneTurnsTheHeadingByIt) {
    // phi_u turns the computed axes counter-clockwise, so that the computed heading is phi_u too large.
    State x = State::Zero();
    x(Model::kPhiUp) = 0.2;
    NavigationState computed;
    computed.q_bn = Eigen::Quaterniond(dcm({.roll = 0.0, .pitch = 0.0, .heading = 1.0}));
    EXPECT_NEAR(euler_angles(Model::corrected(computed, x).q_bn.toRotationMatrix()).heading, 0.8, 1e-15);
}

TEST(LargeAzimuthReset, JacobianIsTheDerivativeOfWhatRemains) {
    for (const unsigned seed : {12U, 120U}) {
        Random random(seed);
        for (int n = 0; n < 20; ++n) {
            State x = random.state();
            x.segment<2>(Model::kPhiEast) *= 20.0;  // any tilt, for the formula has no approximation
            const auto G = Model::reset_jacobian(x);
            const Vector3d phi = x.segment<3>(Model::kPhiEast);
            for (int j = 0; j < 3; ++j) {
                const Vector3d step = 1e-5 * Vector3d::Unit(j);
                const Matrix3d back = exact_C(phi).transpose();  // from n' to the corrected frame
                // Remaining rotation from n to n'': C(x)^T C(x + d).
                const Vector3d remaining =
                    (angles_of(back * exact_C(phi + step)) - angles_of(back * exact_C(phi - step))) / 2e-5;
                EXPECT_LT((G.block<3, 1>(Model::kPhiEast, Model::kPhiEast + j) - remaining).norm(), 1e-9);
            }
            Matrix<Model::kStates> others = G;
            others.block<3, 3>(Model::kPhiEast, Model::kPhiEast).setIdentity();
            EXPECT_EQ(others, Matrix<Model::kStates>::Identity());
        }
    }
}

TEST(LargeAzimuthHindsight, TakesOutTheSightOfTheHeadingThatAWrongTiltGave) {
    // Tilts alone have made the velocity errors, (-g phi_n, g phi_e) t, and a correction finds the tilts.
    constexpr double kFallen = 9.8 * 3.0;
    State sigma = State::Constant(1e-6);
    sigma.segment<2>(Model::kPhiEast).setConstant(0.01);
    Matrix<Model::kStates> P = sigma.cwiseAbs2().asDiagonal();
    Matrix<Model::kStates> F = Matrix<Model::kStates>::Identity();
    F(Model::kVelocityEast, Model::kPhiNorth) = -kFallen;
    F(Model::kVelocityNorth, Model::kPhiEast) = kFallen;
    P = (F * P * F.transpose()).eval();
    State correction = State::Zero();
    correction.segment<2>(Model::kPhiEast) << 0.002, 0.003;

    Matrix<Model::kStates> J = Model{}.hindsight(P, correction).matrix();
    // The false force was (-g phi_n, g phi_e); a heading error turns it clockwise.
    EXPECT_NEAR(J(Model::kVelocityEast, Model::kPhiUp), -kFallen * 0.002, 1e-12);
    EXPECT_NEAR(J(Model::kVelocityNorth, Model::kPhiUp), -kFallen * 0.003, 1e-12);
    J.block<2, 1>(Model::kVelocityEast, Model::kPhiUp).setZero();
    EXPECT_EQ(J, Matrix<Model::kStates>::Identity());
    EXPECT_EQ(Model{.velocity_form = Form::vertical_force}.hindsight(P, correction).matrix(),
              Matrix<Model::kStates>::Identity());
    EXPECT_EQ(Model{}.hindsight(Matrix<Model::kStates>::Zero(), correction).matrix(),
              Matrix<Model::kStates>::Identity());
}

TEST(LargeAzimuthHindsight, LearnsNoHeadingWhereNoForceIsHorizontal) {
    // Level and at rest on an Earth that does not turn, ideal sensors and fixes: nothing tells the heading.
    constexpr double g = 9.8;
    Model::Interval interval(IntervalAverage{}, {}, State::Zero());
    interval.dt = 1.0;
    interval.velocity.setZero();
    interval.omega_ie.setZero();
    interval.omega_en.setZero();
    for (const Predictor& predictor : {Predictor(Linearised()), Predictor(Unscented())}) {
        Estimator<Model> estimator;
        estimator.model.noise = {
            .angle_random_walk = 1e-6, .velocity_random_walk = 5e-4, .velocity_sigma = 0.1};
        estimator.predictor = predictor;
        State sigma;
        sigma << 0.1, 0.1, Vector2d::Constant(0.5 * kDegree), 10.0 * kDegree, Vector2d::Constant(1e-2),
            Vector3d::Constant(2.4e-7);
        estimator.covariance = sigma.cwiseAbs2().asDiagonal();
        Matrix3d C = exact_C({0.5 * kDegree, 0.5 * kDegree, 10.0 * kDegree});
        Vector2d velocity = Vector2d::Zero();
        Vector2d accelerometer = Vector2d::Zero();  // what they are held to be off by
        for (int second = 0; second < 60; ++second) {
            interval.C_bn = C;
            interval.force = C * Vector3d(-accelerometer.x(), -accelerometer.y(), g);
            velocity += interval.dt * interval.force.head<2>();
            ASSERT_EQ(estimator.predict(interval), Prediction::sound);
            const Model::Fix fix{.velocity_difference = velocity, .lever_velocity = Vector3d::Zero()};
            estimator.apply(Standard().correct(estimator.covariance, estimator.innovate(fix)));
            const State& x = estimator.state;
            velocity -= x.head<2>();
            C = exact_C(x.segment<3>(Model::kPhiEast)).transpose() * C;
            accelerometer += x.segment<2>(Model::kAccelerometerX);
            estimator.reset();
        }
        // Without hindsight 8.5 deg.
        EXPECT_GT(std::sqrt(estimator.covariance(Model::kPhiUp, Model::kPhiUp)), 9.5 * kDegree);
        EXPECT_NEAR(angles_of(C).z(), 10.0 * kDegree, 1.0 * kDegree);
    }
}

TEST(LargeAzimuthInterval, TakesTheAveragesAndTrustsTheCorrectedVelocity) {
    Mechanisation mechanisation(
        {.velocity = {10.0, 20.0, 1.0}, .position = {.latitude = 0.5, .longitude = 1.0, .height = 100.0}});
    IntervalAverage average;
    const NavigationState before = mechanisation.state;
    mechanisation.advance({.dt = 0.1, .delta_angle = {0.01, 0.02, 0.03}, .delta_velocity = {0.0, 0.0, 0.98}});
    average.add(before, mechanisation, 0.1);
    State x = State::Zero();
    x.head<2>() << 1.0, 2.0;
    const earth::Position position{.latitude = 0.6, .longitude = 1.0, .height = 100.0};
    const Model::Interval interval(average, position, x);
    EXPECT_EQ(interval.dt, average.duration());
    EXPECT_EQ(interval.C_bn, average.C_bn());
    EXPECT_EQ(interval.force, average.force());
    const Vector3d trusted = average.velocity() - Vector3d(1.0, 2.0, 0.0);
    EXPECT_EQ(interval.velocity, trusted);
    EXPECT_EQ(interval.omega_ie, earth::rate(0.6));
    EXPECT_EQ(interval.omega_en, earth::transport_rate(position, trusted));
    EXPECT_NEAR(interval.per_meridian_radius * (earth::radii(0.6).meridian + 100.0), 1.0, 1e-15);
    EXPECT_NEAR(interval.per_prime_vertical_radius * (earth::radii(0.6).prime_vertical + 100.0), 1.0, 1e-15);
    EXPECT_NEAR(interval.tan_latitude, std::tan(0.6), 1e-15);
}

TEST(LargeAzimuthPropagate, MovesEveryDeviationAsTheStateItBelongsTo) {
    Random random(13);
    const Model::Interval interval = random.interval();
    for (const auto discretisation : {Discretisation::euler, Discretisation::runge_kutta}) {
        const Model model{.discretisation = discretisation};
        const State start = random.state();
        Points<Model::kStates, 3> deviations = Points<Model::kStates, 3>::Zero();
        deviations.col(1) = 1e-2 * random.state();
        deviations.col(2) = 1e-2 * random.state();
        const auto moved = [&](const State& x) {
            return integrate(
                x, [&](const State& y) { return model.rate(y, interval); }, interval.dt, discretisation);
        };
        State x = start;
        Points<Model::kStates, 3> result = deviations;
        model.propagate(x, result, interval);
        EXPECT_LT((x - moved(start)).norm(), 1e-13);
        for (int i = 0; i < 3; ++i) {
            EXPECT_LT((result.col(i) - (moved(start + deviations.col(i)) - moved(start))).norm(), 1e-13);
        }
    }
}

// A filter beside a mechanisation at rest on level ground: ideal sensors save for their biases, a sample each
// 20 ms, a velocity and a position each second. With feedback, estimates move into mechanisation and sensors.
class AtRest {
  public:
    AtRest(bool feedback, const Vector3d& velocity_error, double heading_error) : feedback_(feedback) {
        NavigationState start = truth();
        start.q_bn = Eigen::Quaterniond(exact_C({0.0, 0.0, heading_error})) * start.q_bn;
        start.velocity = velocity_error;
        mechanisation_ = Mechanisation(start);
        State sigma;
        sigma << 40.0, 40.0, Vector2d::Constant(0.5 * kDegree), 10.0 * kDegree, Vector2d::Constant(1e-2),
            Vector3d::Constant(2.4e-7);
        P_ = sigma.cwiseAbs2().asDiagonal();
    }

    void second() {
        IntervalAverage average;
        for (int k = 0; k < 50; ++k) {
            const NavigationState before = mechanisation_.state;
            const Matrix3d C_nb = truth().q_bn.toRotationMatrix().transpose();
            const Vector3d up(0.0, 0.0, earth::gravity(truth().position.latitude, truth().position.height));
            const Vector3d gyro = C_nb * earth::rate(truth().position.latitude) - known_.tail<3>();
            const Vector3d force = C_nb * up + kBias - Vector3d(known_(0), known_(1), 0.0);
            mechanisation_.advance({.dt = 0.02, .delta_angle = 0.02 * gyro, .delta_velocity = 0.02 * force});
            average.add(before, mechanisation_, 0.02);
        }
        const Model::Interval interval(average, mechanisation_.state.position, x_);
        Linearised().predict(model_, x_, P_, interval);
        const Model::Fix fix{.velocity_difference = mechanisation_.state.velocity.head<2>(),
                             .lever_velocity = Vector3d::Zero()};
        const auto correction = Standard().correct(P_, innovate(model_, x_, P_, fix));
        x_ += correction.deviation;
        P_ = correction.covariance;
        mechanisation_.state.velocity.z() = 0.0;
        mechanisation_.state.position = truth().position;
        if (feedback_) {
            mechanisation_.state = Model::corrected(mechanisation_.state, x_);
            known_ += x_.tail<5>();
            const Matrix<Model::kStates> G = Model::reset_jacobian(x_);
            P_ = (G * P_ * G.transpose()).eval();
            x_.setZero();
        }
    }

    [[nodiscard]] Matrix3d attitude() const {
        return Model::corrected(mechanisation_.state, x_).q_bn.toRotationMatrix();
    }
    [[nodiscard]] Vector<5> biases() const { return known_ + x_.tail<5>(); }

  private:
    inline static const Vector3d kBias{4e-3, -3e-3, 0.0};

    static NavigationState truth() {
        return {.q_bn = Eigen::Quaterniond(dcm({.roll = 0.0, .pitch = 0.0, .heading = 0.7})),
                .position = {.latitude = 0.56, .longitude = 2.06, .height = 30.0}};
    }

    bool feedback_;
    Model model_{.noise = {.angle_random_walk = 1e-6, .velocity_random_walk = 1e-4, .velocity_sigma = 0.1}};
    Mechanisation mechanisation_;
    State x_ = State::Zero();
    Matrix<Model::kStates> P_;
    Vector<5> known_ = Vector<5>::Zero();  // accelerometer and gyro biases, by feedback
};

TEST(LargeAzimuthLoop, OpenAndClosedFindTheSameFromAVelocityThatIs40MetresPerSecondWrong) {
    for (const Vector3d& velocity : {Vector3d(40.0, 0.0, 0.0), Vector3d(-28.0, 28.0, 0.0)}) {
        AtRest closed(true, velocity, 5.0 * kDegree);
        AtRest open(false, velocity, 5.0 * kDegree);
        for (int second = 0; second < 300; ++second) {
            closed.second();
            open.second();
        }
        const Vector3d rotation =
            rotation_vector(Eigen::Quaterniond(open.attitude() * closed.attitude().transpose())) / kDegree *
            60.0;
        const Vector<5> biases = open.biases() - closed.biases();
        // Arcmin, ug, deg/h. Without -dw_en x dv each of these is beyond its limit, the accelerometers' by 1
        // and 3 ug.
        EXPECT_LT(rotation.head<2>().norm(), 0.02);
        EXPECT_LT(std::abs(rotation.z()), 0.3);
        EXPECT_LT(biases.head<2>().norm(), 2.5e-6 * 9.8);
        EXPECT_LT(biases.tail<3>().norm(), 1e-3 * kDegree / 3600.0);
    }
}

TEST(LargeAzimuthAugmented, LetsTheNoiseOfTheGyrosReachTheVelocityWithinTheInterval) {
    // Level and at rest on an Earth that does not turn: a gyro noise of the variance q dt, spread over dt,
    // tilts by w t / dt, and the velocity is wrong by the integral of g times that, g w dt / 2.
    Model::Interval interval(IntervalAverage{}, {}, State::Zero());
    interval.dt = 2.0;
    interval.C_bn.setIdentity();
    interval.force = {0.0, 0.0, 9.8};
    interval.velocity.setZero();
    interval.omega_ie.setZero();
    interval.omega_en.setZero();
    const double q = 1e-10;
    const Model model{
        .noise = {.angle_random_walk = std::sqrt(q), .velocity_random_walk = 0.0, .velocity_sigma = 0.1}};
    const UnscentedParameters parameters{.alpha = 1.0, .beta = 2.0, .kappa = 0.0};
    State x = State::Zero();
    Matrix<Model::kStates> P = Matrix<Model::kStates>::Zero();
    ASSERT_NE(Augmented(parameters).predict(model, x, P, interval), Prediction::failed);
    Matrix<Model::kStates> expected = Matrix<Model::kStates>::Zero();
    const double g = 9.8;
    const double dt = interval.dt;
    expected.block<3, 3>(Model::kPhiEast, Model::kPhiEast) = q * dt * Matrix3d::Identity();
    for (const auto& [velocity, tilt, sign] : {std::tuple(Model::kVelocityEast, Model::kPhiNorth, -1.0),
                                               std::tuple(Model::kVelocityNorth, Model::kPhiEast, 1.0)}) {
        expected(velocity, velocity) = q * g * g * dt * dt * dt / 4.0;
        expected(velocity, tilt) = expected(tilt, velocity) = sign * q * g * dt * dt / 2.0;
    }
    // Schuler's feedback is g dt^2 / R = 6e-6 of it.
    EXPECT_LT((P - expected).cwiseAbs().maxCoeff(), 1e-5 * expected.maxCoeff());

    // The simplified filter adds the noise when the interval is over.
    Matrix<Model::kStates> P_simple = Matrix<Model::kStates>::Zero();
    State x_simple = State::Zero();
    ASSERT_NE(Unscented(parameters).predict(model, x_simple, P_simple, interval), Prediction::failed);
    EXPECT_EQ(P_simple(Model::kVelocityEast, Model::kVelocityEast), 0.0);
    EXPECT_NEAR(P_simple(Model::kPhiNorth, Model::kPhiNorth), q * dt, 1e-18);
}

}  // namespace
}  // namespace truenorth
