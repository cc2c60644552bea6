#include "inertial/mechanisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "inertial/ecef.hpp"

namespace truenorth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kArcsecond = kPi / 180.0 / 3600.0;
const earth::Position kPlace{.latitude = 0.6, .longitude = 2.0, .height = 50.0};

// An IMU in free fall: the velocity does not depend on the attitude, so that
// q_bn(t) = q_bn(t of a body that does not turn) * (turn of the body in inertial space).
class FreeFall {
  public:
    explicit FreeFall(const Quaterniond& turned = Quaterniond::Identity())
        : turning({.q_bn = turned, .position = kPlace}), inert({.position = kPlace}) {}

    void advance(double dt, const Vector3d& delta_angle, const Vector3d& delta_velocity = Vector3d::Zero()) {
        turning.advance({.dt = dt, .delta_angle = delta_angle, .delta_velocity = delta_velocity});
        inert.advance({.dt = dt, .delta_angle = Vector3d::Zero(), .delta_velocity = Vector3d::Zero()});
    }
    // Forgets the previous increment, as an algorithm without coning and sculling terms would.
    void forget() { turning = Mechanisation(turning.state); }

    [[nodiscard]] Quaterniond turned() const { return inert.state.q_bn.conjugate() * turning.state.q_bn; }
    [[nodiscard]] Vector3d gained() const { return turning.state.velocity - inert.state.velocity; }

    Mechanisation turning;
    Mechanisation inert;
};

// Coning: the axis of a constant small rotation `cone` turns with `omega`.
struct Coning {
    double cone;
    double omega;

    [[nodiscard]] Quaterniond at(double t) const {
        const double s = std::sin(0.5 * cone);
        return {std::cos(0.5 * cone), s * std::cos(omega * t), s * std::sin(omega * t), 0.0};
    }
    // Integral of the body rate, 2 q* q'.
    [[nodiscard]] Vector3d increment(double from, double to) const {
        const double s = std::sin(0.5 * cone);
        return {std::sin(cone) * (std::cos(omega * to) - std::cos(omega * from)),
                std::sin(cone) * (std::sin(omega * to) - std::sin(omega * from)),
                -2.0 * s * s * omega * (to - from)};
    }
};

// Mean drift of the computed attitude about the cone's axis over whole turns [rad/s].
double coning_drift(const Coning& coning, double dt, bool compensated) {
    FreeFall fall(coning.at(0.0));
    const auto steps_of = [&](double turns) { return std::lround(turns * 2.0 * kPi / coning.omega / dt); };
    double first = 0.0;
    for (long k = 0; k < steps_of(21); ++k) {
        fall.advance(dt, coning.increment(static_cast<double>(k) * dt, static_cast<double>(k + 1) * dt));
        if (!compensated) {
            fall.forget();
        }
        const double t = static_cast<double>(k + 1) * dt;
        const double error = rotation_vector(coning.at(t).conjugate() * fall.turned()).z();
        if (k + 1 == steps_of(1)) {
            first = error;
        }
        if (k + 1 == steps_of(21)) {
            return (error - first) / (static_cast<double>(steps_of(20)) * dt);
        }
    }
    return 0.0;
}

// Per sample, x = omega dt: what coning adds is a^2/2 (x - sin x); two samples give a^2/6 (1 - cos x) sin x.
double coning_of(double x) { return 0.5 * (x - std::sin(x)); }
double two_sample_estimate(double x) { return (1.0 - std::cos(x)) * std::sin(x) / 6.0; }

TEST(MechanisationConing, WithoutThePreviousSampleDriftsAsTheTextbooksSay) {
    const Coning coning{.cone = 2e-3, .omega = 2.0 * kPi * 5.0};
    const double dt = 0.01;
    const double expected = -coning.cone * coning.cone * coning_of(coning.omega * dt) / dt;
    EXPECT_NEAR(coning_drift(coning, dt, false), expected, 1e-3 * std::abs(expected));
}

TEST(MechanisationConing, LeavesTheResidualOfTheTwoSampleAlgorithm) {
    const Coning coning{.cone = 2e-3, .omega = 2.0 * kPi * 5.0};
    const double a2 = coning.cone * coning.cone;
    for (const double dt : {0.02, 0.01}) {
        const double x = coning.omega * dt;
        const double expected = -a2 * (coning_of(x) - two_sample_estimate(x)) / dt;
        EXPECT_NEAR(coning_drift(coning, dt, true), expected, 1e-3 * std::abs(expected));
    }
}

TEST(MechanisationConing, VanishesWithTheFourthPowerOfTheInterval) {
    const Coning coning{.cone = 2e-3, .omega = 2.0 * kPi * 5.0};
    const double ratio = coning_drift(coning, 0.01, true) / coning_drift(coning, 0.005, true);
    EXPECT_NEAR(std::log2(ratio), 4.0, 0.1);
    // a^2 omega x^4 / 60 against a^2 omega x^2 / 12
    EXPECT_LT(std::abs(coning_drift(coning, 0.005, true)),
              0.01 * std::abs(coning_drift(coning, 0.005, false)));
}

// Sculling: turn A sin(omega t) about right, specific force B sin(omega t) along forward: the force has the
// mean A B / 2 along up.
double sculling_acceleration(double A, double B, double omega, double dt, bool compensated) {
    FreeFall fall;
    const long per_turn = std::lround(2.0 * kPi / omega / dt);
    double first = 0.0;
    for (long k = 0; k < 11 * per_turn; ++k) {
        const double from = omega * dt * static_cast<double>(k);
        const double to = omega * dt * static_cast<double>(k + 1);
        fall.advance(dt, {A * (std::sin(to) - std::sin(from)), 0.0, 0.0},
                     {0.0, B / omega * (std::cos(from) - std::cos(to)), 0.0});
        if (!compensated) {
            fall.forget();
        }
        if (k + 1 == per_turn) {
            first = fall.gained().z();
        }
    }
    return (fall.gained().z() - first) / (10.0 * static_cast<double>(per_turn) * dt);
}

TEST(MechanisationSculling, WithoutThePreviousSampleMissesWhatTheTextbooksSay) {
    const double A = 2e-3;
    const double B = 3.0;
    const double omega = 2.0 * kPi * 5.0;
    const double dt = 0.01;
    const double missed = A * B * coning_of(omega * dt) / (omega * dt);
    EXPECT_NEAR(sculling_acceleration(A, B, omega, dt, false), 0.5 * A * B - missed, 2e-2 * missed);
}

TEST(MechanisationSculling, LeavesTheResidualOfTheTwoSampleAlgorithm) {
    const double A = 2e-3;
    const double B = 3.0;
    const double omega = 2.0 * kPi * 5.0;
    for (const double dt : {0.02, 0.01}) {
        const double x = omega * dt;
        const double missed = A * B * (coning_of(x) - two_sample_estimate(x)) / x;
        EXPECT_NEAR(sculling_acceleration(A, B, omega, dt, true), 0.5 * A * B - missed, 2e-2 * missed);
    }
}

// Rates that are linear in time, w = w0 + w1 t and f = f0 + f1 t, integrated finely in a frame that does not
// turn.
struct Linear {
    Vector3d w0{0.4, -0.1, 0.2};
    Vector3d w1{-1.0, 6.0, 3.0};
    Vector3d f0{2.0, -9.0, 4.0};
    Vector3d f1{90.0, 40.0, -60.0};

    [[nodiscard]] Vector3d angle(double from, double to) const {
        return w0 * (to - from) + 0.5 * w1 * (to * to - from * from);
    }
    [[nodiscard]] Vector3d velocity(double from, double to) const {
        return f0 * (to - from) + 0.5 * f1 * (to * to - from * from);
    }

    struct End {
        Quaterniond turned;
        Vector3d gained;
    };
    // From 0 to T in steps so small that the mid-point rule (error step^2 T) is exact to 1e-12.
    [[nodiscard]] End integrated(double T) const {
        constexpr int steps = 20000;
        const double h = T / steps;
        End end{.turned = Quaterniond::Identity(), .gained = Vector3d::Zero()};
        for (int k = 0; k < steps; ++k) {
            const double middle = (k + 0.5) * h;
            const Vector3d w = w0 + w1 * middle;
            const Quaterniond half(Eigen::AngleAxisd(0.5 * h * w.norm(), w.normalized()));
            end.turned = end.turned * half;
            end.gained += h * (end.turned * (f0 + f1 * middle));
            end.turned = end.turned * half;
        }
        return end;
    }
};

TEST(MechanisationUnequalIntervals, FollowRatesThatAreLinearInTime) {
    const Linear motion;
    for (const auto& [before, now] : {std::pair{0.01, 0.01}, {0.02, 0.01}, {0.005, 0.02}, {0.003, 0.01}}) {
        FreeFall fall;
        fall.advance(before, motion.angle(-before, 0.0), motion.velocity(-before, 0.0));
        // What is tested is the second interval alone: it starts from the truth.
        fall.turning.state.q_bn = fall.inert.state.q_bn;
        fall.turning.state.velocity = fall.inert.state.velocity;
        const Quaterniond start = fall.inert.state.q_bn;
        fall.advance(now, motion.angle(0.0, now), motion.velocity(0.0, now));

        const auto [turned, gained] = motion.integrated(now);
        const Vector3d coning = motion.w0.cross(motion.w1) * std::pow(now, 3) / 12.0;
        const Vector3d sculling =
            (motion.w0.cross(motion.f1) + motion.f0.cross(motion.w1)) * std::pow(now, 3) / 12.0;
        // The next order is |w| T smaller than the terms under test: a fifth of them at most.
        const Quaterniond error = turned.conjugate() * fall.turned();
        EXPECT_LT(rotation_vector(error).norm(), 0.02 * coning.norm()) << before << " then " << now;
        EXPECT_LT((fall.gained() - start * gained).norm(), 0.1 * sculling.norm())
            << before << " then " << now;
    }
}

TEST(Mechanisation, ResolvesAForceThatIsConstantInSpaceWhileTheBodyTurnsSteadily) {
    // f_b(t) = R(-w t) g: its integral has a closed form by Rodrigues' formula.
    const Vector3d omega(0.4, -0.3, 0.2);
    const Vector3d force(0.0, 0.0, 9.8);
    const double dt = 0.05;
    const double rate = omega.norm();
    const Vector3d axis = omega / rate;
    FreeFall fall;
    for (int k = 0; k < 20; ++k) {
        const Vector3d along = axis * axis.dot(force);
        const Vector3d across = axis.cross(force);
        const auto integral = [&](double t) {
            return Vector3d(along * t + (force - along) * std::sin(rate * t) / rate +
                            across * std::cos(rate * t) / rate);
        };
        fall.advance(dt, omega * dt, integral((k + 1) * dt) - integral(k * dt));
    }
    // Without the second order of the rotation, g w^2 dt^2 / 6 = 1.2e-3 m/s would be missing. What may remain
    // is the sculling of the first interval, which has no predecessor, g w^2 dt^3 / 12 = 3e-5 m/s, and 1e-5
    // m/s of the next order.
    EXPECT_NEAR(fall.gained().z(), 9.8, 1e-4);
}

TEST(Mechanisation, StaysWhereItIsOnTheTurningEarth) {
    const Eigen::Matrix3d C_bn = dcm({.roll = 0.1, .pitch = -0.2, .heading = 2.5});
    Mechanisation mechanisation({.q_bn = Quaterniond(C_bn), .position = kPlace});
    const double dt = 0.01;
    const Vector3d up(0.0, 0.0, earth::gravity(kPlace.latitude, kPlace.height));
    const ImuIncrement increment{
        .dt = dt,
        .delta_angle = dt * C_bn.transpose() * earth::rate(kPlace.latitude),
        .delta_velocity = dt * C_bn.transpose() * up,
    };
    for (int k = 0; k < 60000; ++k) {
        mechanisation.advance(increment);
    }

    const Quaterniond turned = Quaterniond(C_bn).conjugate() * mechanisation.state.q_bn;
    EXPECT_LT(rotation_vector(turned).norm(), 1e-5 * kArcsecond);
    EXPECT_LT(mechanisation.state.velocity.norm(), 1e-7);
    EXPECT_LT(earth::displacement(kPlace, mechanisation.state.position).norm(), 1e-4);
}

TEST(Mechanisation, KeepsTheQuaternionNormal) {
    Mechanisation mechanisation({.position = kPlace});
    for (int k = 0; k < 10000; ++k) {
        mechanisation.advance(
            {.dt = 0.01, .delta_angle = {0.03, -0.02, 0.01}, .delta_velocity = {0.0, 0.0, 0.098}});
    }
    EXPECT_NEAR(mechanisation.state.q_bn.norm(), 1.0, 1e-15);
}

TEST(Mechanisation, AcrossTheDateLineWrapsTheLongitude) {
    const NavigationState start{.velocity = {200.0, 0.0, 0.0},
                                .position = {.latitude = 0.3, .longitude = kPi - 1e-6, .height = 0.0}};
    Mechanisation mechanisation(start);
    for (int k = 0; k < 100; ++k) {
        mechanisation.advance(
            {.dt = 0.01, .delta_angle = Vector3d::Zero(), .delta_velocity = {0.0, 0.0, 0.0978}});
    }
    EXPECT_LT(mechanisation.state.position.longitude, -kPi + 1e-4);
    EXPECT_GE(mechanisation.state.position.longitude, -kPi);
}

TEST(Mechanisation, GivesTheSpecificForceInNavigationAxes) {
    const Eigen::Matrix3d C_bn = dcm({.roll = 0.1, .pitch = -0.2, .heading = 2.5});
    Mechanisation mechanisation({.q_bn = Quaterniond(C_bn), .position = kPlace});
    const Vector3d delta_velocity(0.01, 0.02, 0.1);
    mechanisation.advance({.dt = 0.01, .delta_angle = Vector3d::Zero(), .delta_velocity = delta_velocity});
    EXPECT_LT((mechanisation.delta_velocity_n() - C_bn * delta_velocity).norm(), 1e-7);  // w_ie dt |dv|
}

TEST(Mechanisation, ExtrapolatesTheRateToTheEndOfTheInterval) {
    const Linear motion;
    for (const auto& [before, now] : {std::pair{0.01, 0.01}, {0.02, 0.01}, {0.005, 0.02}}) {
        Mechanisation mechanisation({.position = kPlace});
        mechanisation.advance(
            {.dt = before, .delta_angle = motion.angle(-before, 0.0), .delta_velocity = Vector3d::Zero()});
        mechanisation.advance(
            {.dt = now, .delta_angle = motion.angle(0.0, now), .delta_velocity = Vector3d::Zero()});
        const Vector3d end = motion.w0 + motion.w1 * now;
        const Vector3d expected =
            end - mechanisation.state.q_bn.conjugate() * earth::rate(mechanisation.state.position.latitude);
        EXPECT_LT((mechanisation.omega_eb_b() - expected).norm(), 1e-12) << before << " then " << now;
    }
}

TEST(Mechanisation, AfterOneIncrementGivesItsMeanRate) {
    Mechanisation mechanisation({.position = kPlace});
    mechanisation.advance(
        {.dt = 0.01, .delta_angle = {1e-3, 2e-3, 3e-3}, .delta_velocity = Vector3d::Zero()});
    const Vector3d expected =
        Vector3d(0.1, 0.2, 0.3) - mechanisation.state.q_bn.conjugate() * earth::rate(kPlace.latitude);
    EXPECT_LT((mechanisation.omega_eb_b() - expected).norm(), 1e-12);
}

TEST(LeverArm, VelocityIsTheDerivativeOfThePointsPosition) {
    const Vector3d lever_arm(2.0, -7.0, 12.0);
    const Vector3d omega_nb_b(0.1, -0.3, 0.2);
    const NavigationState now{.q_bn = Quaterniond(dcm({.roll = 0.1, .pitch = -0.2, .heading = 2.5})),
                              .velocity = {90.0, -60.0, 5.0},
                              .position = kPlace};
    const Vector3d position_rate = earth::position_rate(now.position, now.velocity);
    const auto point = [&](double t) {
        const Quaterniond turn(Eigen::AngleAxisd(omega_nb_b.norm() * t, omega_nb_b.normalized()));
        return ecef::coordinates(point_position({.q_bn = now.q_bn * turn,
                                                 .velocity = now.velocity,
                                                 .position = ecef::moved(now.position, position_rate, t)},
                                                lever_arm));
    };
    const double t = 1e-3;
    const Vector3d expected = ecef::axes(now.position).transpose() * (point(t) - point(-t)) / (2.0 * t);

    const Vector3d omega_eb_b =
        omega_nb_b + now.q_bn.conjugate() * earth::transport_rate(now.position, now.velocity);
    // Rounding of 6e6 m over 2 ms, and (l / R) v of the first-order displacement.
    EXPECT_LT((point_velocity(now, omega_eb_b, lever_arm) - expected).norm(), 1e-6 + 12.0 / 6.3e6 * 110.0);
    EXPECT_GT((expected - now.velocity).norm(), 1.0);
}

TEST(LeverArm, PositionIsTheArmInNavigationAxes) {
    const NavigationState state{
        .q_bn = Quaterniond(dcm({.heading = 0.5 * kPi})), .velocity = Vector3d::Zero(), .position = kPlace};
    const Vector3d offset = earth::displacement(kPlace, point_position(state, {1.0, 2.0, 3.0}));
    EXPECT_LT((offset - Vector3d(2.0, -1.0, 3.0)).norm(), 1e-8);  // forward is east, right is south
}

}  // namespace
}  // namespace truenorth
