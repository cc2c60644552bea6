#include "error_models/euler_platform.hpp"

#include <gtest/gtest.h>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"
#include "error_models/two_mechanisations.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Model = EulerPlatform;
using State = Model::State;
using Form = Model::VelocityForm;

constexpr std::array<Misalignment, 3> kForms{Misalignment::large, Misalignment::large_azimuth,
                                             Misalignment::small};
constexpr std::array<Form, 2> kVelocityForms{Form::transposed, Form::vertical_force};

// At rest: the trusted velocity is zero.
Model::Interval at_rest(RandomValues& random) {
    const Matrix3d C_bn = dcm(random.angles());
    const Vector3d force = Vector3d(0.0, 0.0, 9.8) + random.vector(3.0);
    return interval_of<Model>({1.0, C_bn, force, Vector3d::Zero(), random.position()});
}

State random_state(RandomValues& random) {
    State x;
    x << random.vector(1.2), random.vector(3.0);
    return x;
}

// Equations 25 to 27 word for word; the force of the true frame is vertical, or comes from the computed one.
State transcription(Misalignment form, Form velocity_form, const State& x, const Model::Interval& i) {
    const Vector3d alpha = x.head<3>();
    const Vector3d dv = x.tail<3>();
    const Matrix3d I = Matrix3d::Identity();
    const Matrix3d C = misalignment_matrix(form, alpha);
    const Vector3d dw_en(-dv.y() * i.per_meridian_radius, dv.x() * i.per_prime_vertical_radius,
                         dv.x() * i.per_prime_vertical_radius * i.tan_latitude);
    const Vector3d turn = (I - C) * i.omega_ie + dw_en;
    const Vector3d force = velocity_form == Form::vertical_force
                               ? Vector3d((C - I) * Vector3d(0.0, 0.0, i.gravity))
                               : Vector3d((I - C.transpose()) * i.force);
    State rate;
    rate << turn, force - (2.0 * i.omega_ie + dw_en).cross(dv);
    if (form == Misalignment::large) {
        rate.head<3>() = euler_rate_matrix(alpha).partialPivLu().solve(turn);
    }
    return rate;
}

TEST(EulerPlatformRate, IsTheTranscriptionOfEveryForm) {
    RandomValues random(1);
    for (int n = 0; n < 100; ++n) {
        const State x = random_state(random);
        const Model::Interval interval = at_rest(random);
        for (const Misalignment form : kForms) {
            for (const Form velocity_form : kVelocityForms) {
                const Model model{.form = form, .velocity_form = velocity_form};
                const State difference =
                    model.rate(x, interval) - transcription(form, velocity_form, x, interval);
                EXPECT_LT(difference.head<3>().norm(), 1e-18) << static_cast<int>(form);
                EXPECT_LT(difference.tail<3>().norm(), 1e-13) << static_cast<int>(form);
            }
        }
    }
}

// Without a matrix of the product: (I - C) w = alpha x w, and the force of the true frame turns by alpha.
TEST(EulerPlatformRate, OfSmallAnglesIsEquation27WordForWord) {
    RandomValues random(3);
    for (int n = 0; n < 100; ++n) {
        const State x = random_state(random);
        const Vector3d alpha = x.head<3>();
        const Vector3d dv = x.tail<3>();
        const Model::Interval i = at_rest(random);
        const Vector3d dw_en(-dv.y() * i.per_meridian_radius, dv.x() * i.per_prime_vertical_radius,
                             dv.x() * i.per_prime_vertical_radius * i.tan_latitude);
        for (const Form velocity_form : kVelocityForms) {
            const Vector3d force =
                velocity_form == Form::vertical_force ? Vector3d(0.0, 0.0, i.gravity) : i.force;
            const Model model{.form = Misalignment::small, .velocity_form = velocity_form};
            const State rate = model.rate(x, i);
            EXPECT_LT((rate.head<3>() - alpha.cross(i.omega_ie) - dw_en).norm(), 1e-18);
            EXPECT_LT((rate.tail<3>() - force.cross(alpha) + (2.0 * i.omega_ie + dw_en).cross(dv)).norm(),
                      1e-13);
        }
    }
}

TEST(EulerPlatformRate, TakesASetOfPointsAsItTakesEachOfThem) {
    RandomValues random(2);
    const Model::Interval interval = at_rest(random);
    Points<Model::kStates, 13> set;
    for (int i = 0; i < 13; ++i) {
        set.col(i) = random_state(random);
    }
    for (const Misalignment form : kForms) {
        const Model model{.form = form};
        const auto rates = model.rate(set, interval);
        for (int i = 0; i < 13; ++i) {
            EXPECT_LT((rates.col(i) - model.rate(State(set.col(i)), interval)).norm(), 1e-14);
        }
    }
}

// The angles of C_y C_x C_z.
Vector3d angles_of(const Matrix3d& C) {
    return {std::asin(C(1, 2)), std::atan2(-C(0, 2), C(2, 2)), std::atan2(-C(1, 0), C(1, 1))};
}

State error(const TwoMechanisations& pair) {
    const Matrix3d C = (pair.computed.state.q_bn * pair.truth.state.q_bn.conjugate()).toRotationMatrix();
    State x;
    x << angles_of(C), pair.computed.state.velocity - pair.truth.state.velocity;
    return x;
}

TEST(EulerPlatformRate, OfTheLargeFormIsTheErrorOfAMechanisationAtRestForAnyAngles) {
    RandomValues random(3);
    for (int n = 0; n < 20; ++n) {
        const State x = random_state(random);
        NavigationState truth = random.navigation_state();
        truth.velocity.setZero();
        NavigationState computed = truth;
        computed.q_bn =
            Eigen::Quaterniond(misalignment_matrix(Misalignment::large, x.head<3>())) * truth.q_bn;
        computed.velocity = x.tail<3>();

        const Matrix3d C_nb = truth.q_bn.toRotationMatrix().transpose();
        const Vector3d gravity(0.0, 0.0, earth::gravity(truth.position.latitude, truth.position.height));
        const TwoMechanisations pair{.truth = Mechanisation(truth),
                                     .computed = Mechanisation(computed),
                                     .omega_b = C_nb * earth::rate(truth.position.latitude),
                                     .force_b = C_nb * gravity};
        const State derivative = pair.derivative(error, 1e-3);

        const Matrix3d C_bn = computed.q_bn.toRotationMatrix();
        const auto interval =
            interval_of<Model>({1.0, C_bn, C_bn * pair.force_b, Vector3d::Zero(), truth.position});
        // The quotient's rounding: 1e-15 rad and 1e-15 m/s over 1 ms.
        for (const Form velocity_form : kVelocityForms) {
            const State rate = Model{.velocity_form = velocity_form}.rate(x, interval);
            EXPECT_LT((rate - derivative).head<3>().norm(), 1e-11 / std::cos(x(0)));
            EXPECT_LT((rate - derivative).tail<3>().norm(), 1e-7);
        }
    }
}

TEST(EulerPlatformRate, WithAVerticalForceTheVelocityTellsNothingOfTheHeading) {
    RandomValues random(12);
    const Model model{.velocity_form = Form::vertical_force};
    for (int n = 0; n < 20; ++n) {
        const State x = random_state(random);
        const Model::Interval interval = at_rest(random);
        const Matrix<Model::kStates> F = model.jacobian(x, interval);
        EXPECT_LT((F.block<3, 1>(Model::kVelocityEast, Model::kAlphaZ).norm()), 1e-14);
        EXPECT_GT((F.block<3, 2>(Model::kVelocityEast, Model::kAlphaX).norm()), 1.0);
    }
}

// The rates of two forms differ by a quantity of second order: a quarter remains for half the scale.
void expect_second_order(Misalignment a, Misalignment b, const State& direction) {
    RandomValues random(4);
    const Model::Interval interval = at_rest(random);
    const auto difference = [&](double scale) {
        State x = direction;
        x.head<2>() *= scale;
        if (b == Misalignment::small) {
            x(2) *= scale;
        }
        return State(Model{.form = a}.rate(x, interval) - Model{.form = b}.rate(x, interval));
    };
    const State coarse = difference(1e-2);
    const State fine = difference(5e-3);
    EXPECT_NEAR(coarse.head<3>().norm() / fine.head<3>().norm(), 4.0, 0.1);
    EXPECT_NEAR(coarse.tail<3>().norm() / fine.tail<3>().norm(), 4.0, 0.1);
}

TEST(EulerPlatformRate, OfOneFormGoesOverIntoTheNextToSecondOrder) {
    State direction;
    direction << 0.7, -0.9, 0.8, 0.0, 0.0, 0.0;
    expect_second_order(Misalignment::large_azimuth, Misalignment::small, direction);
    expect_second_order(Misalignment::large, Misalignment::small, direction);
}

TEST(EulerPlatformJacobian, IsTheDerivativeOfTheRate) {
    RandomValues random(5);
    for (int n = 0; n < 50; ++n) {
        const State x = random_state(random);
        // A moving base as well, so that no term goes unseen.
        const Model::Interval interval = interval_of<Model>(random.interval());
        for (const Misalignment form : kForms) {
            for (const Form velocity_form : kVelocityForms) {
                const Model model{.form = form, .velocity_form = velocity_form};
                const auto rate = [&](const State& y) { return model.rate(y, interval); };
                const Matrix<Model::kStates> expected = central_difference<6, 6>(rate, x, 1e-5);
                const Matrix<Model::kStates> difference = model.jacobian(x, interval) - expected;
                EXPECT_LT(difference.topRows<3>().norm(),
                          1e-9 * (1e-4 + expected.topRows<3>().norm()) + 1e-14)
                    << static_cast<int>(form);
                EXPECT_LT(difference.bottomRows<3>().norm(), 1e-8) << static_cast<int>(form);
            }
        }
    }
}

TEST(EulerPlatformPropagate, MovesEveryDeviationAsTheStateItBelongsTo) {
    RandomValues random(6);
    const Model::Interval interval = at_rest(random);
    for (const auto discretisation : {Discretisation::euler, Discretisation::runge_kutta}) {
        const Model model{.discretisation = discretisation};
        const State start = random_state(random);
        Points<Model::kStates, 3> deviations = Points<Model::kStates, 3>::Zero();
        deviations.col(1) = 1e-2 * random_state(random);
        deviations.col(2) = 1e-2 * random_state(random);
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

TEST(EulerPlatformProcessNoise, IsThatOfTheSensorsTurnedIntoTheAngles) {
    RandomValues random(7);
    Model::Interval interval = at_rest(random);
    interval.dt = 0.25;
    const State x = random_state(random);
    const Model::Noise noise{.angle_random_walk = 2e-6, .velocity_random_walk = 3e-4, .velocity_sigma = 0.1};
    for (const Misalignment form : kForms) {
        const Matrix<Model::kStates> Q = Model{.form = form, .noise = noise}.process_noise(x, interval);
        const Matrix3d C_w =
            form == Misalignment::large ? euler_rate_matrix(x.head<3>()) : Matrix3d(Matrix3d::Identity());
        // Turn rates of the frame: white and equal about all axes.
        EXPECT_LT((C_w * Q.topLeftCorner<3, 3>() * C_w.transpose() - 1e-12 * Matrix3d::Identity()).norm(),
                  1e-26);
        EXPECT_LT((Q.bottomRightCorner<3, 3>() - 2.25e-8 * Matrix3d::Identity()).norm(), 1e-22);
        EXPECT_EQ((Q.topRightCorner<3, 3>()), Matrix3d::Zero());
    }
}

TEST(EulerPlatformMeasurement, IsTheVelocityOfTheMechanisation) {
    RandomValues random(8);
    const State x = random_state(random);
    const Model model{.noise = {.angle_random_walk = 0, .velocity_random_walk = 0, .velocity_sigma = 0.2}};
    const Model::Fix fix{.velocity = random.vector(1.0)};
    EXPECT_LT((Model::residual(x, fix) - (fix.velocity - x.tail<3>())).norm(), 1e-16);
    const auto prediction = [&](const State& y) -> Vector3d {
        return fix.velocity - Model::residual(y, fix);
    };
    EXPECT_LT((Model::measurement_matrix(x, fix) - central_difference<3, 6>(prediction, x, 1e-3)).norm(),
              1e-11);
    EXPECT_LT((model.measurement_noise(x, fix) - 0.04 * Matrix3d::Identity()).norm(), 1e-16);
}

TEST(EulerPlatformCorrected, UndoesAKnownError) {
    RandomValues random(9);
    for (int n = 0; n < 50; ++n) {
        const State x = random_state(random);
        const NavigationState truth = random.navigation_state();
        NavigationState computed = truth;
        computed.q_bn =
            Eigen::Quaterniond(misalignment_matrix(Misalignment::large, x.head<3>())) * truth.q_bn;
        computed.velocity += x.tail<3>();
        const NavigationState corrected = Model::corrected(computed, x);
        EXPECT_LT((corrected.q_bn.toRotationMatrix() - truth.q_bn.toRotationMatrix()).norm(), 3e-15);
        EXPECT_LT((corrected.velocity - truth.velocity).norm(), 3e-14);
    }
}

TEST(EulerPlatformReset, JacobianIsTheDerivativeOfWhatRemains) {
    RandomValues random(10);
    for (int n = 0; n < 20; ++n) {
        const State x = random_state(random);
        const auto remaining = [&](const State& truth) {
            const Matrix3d back = misalignment_matrix(Misalignment::large, x.head<3>()).transpose();
            State rest;
            rest << angles_of(back * misalignment_matrix(Misalignment::large, truth.head<3>())),
                truth.tail<3>() - x.tail<3>();
            return rest;
        };
        const Matrix<6> expected = central_difference<6, 6>(remaining, x, 1e-5);
        EXPECT_LT((Model::reset_jacobian(x) - expected).norm(), 1e-9);
    }
}

TEST(EulerPlatformDamp, MovesTheVelocityErrorIntoTheMechanisationAndLeavesTheRest) {
    RandomValues random(11);
    const State before = random_state(random);
    const NavigationState undamped = random.navigation_state();
    State x = before;
    NavigationState damped = undamped;
    Model::damp(damped, x);
    EXPECT_EQ(x.head<3>(), before.head<3>());
    EXPECT_EQ(damped.q_bn.coeffs(), undamped.q_bn.coeffs());
    EXPECT_LT((damped.velocity - (undamped.velocity - before.tail<3>())).norm(), 1e-16);
    EXPECT_LT((Model::residual(x, {damped.velocity}) - Model::residual(before, {undamped.velocity})).norm(),
              3e-14);
    EXPECT_LT((Model::corrected(damped, x).velocity - Model::corrected(undamped, before).velocity).norm(),
              3e-14);
}

TEST(EulerPlatformInterval, TrustsThatTheBaseIsAtRest) {
    Mechanisation mechanisation({.velocity = {1.0, 2.0, 0.1}, .position = {.latitude = 0.5}});
    IntervalAverage average;
    const NavigationState before = mechanisation.state;
    mechanisation.advance({.dt = 0.1, .delta_angle = {0.0, 0.0, 0.0}, .delta_velocity = {0.0, 0.0, 0.98}});
    average.add(before, mechanisation, 0.1);
    const Model::Interval interval(average, mechanisation.state.position, State::Zero());
    EXPECT_EQ(interval.velocity, Vector3d::Zero());
    EXPECT_EQ(interval.omega_en, Vector3d::Zero());
    EXPECT_EQ(interval.force, average.force());
}

}  // namespace
}  // namespace truenorth
