#include "error_models/invariant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "error_models/central_difference.hpp"
#include "error_models/loose.hpp"
#include "error_models/random_values.hpp"
#include "estimation/linearised.hpp"
#include "estimation/relinearised.hpp"
#include "estimation/standard.hpp"
#include "inertial/attitude.hpp"
#include "inertial/vector_alignment.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
constexpr double kDegree = std::numbers::pi / 180.0;

template <bool coloured>
Invariant<coloured> model() {
    Invariant<coloured> m;
    m.noise = {.angle_random_walk = 2e-6,
               .velocity_random_walk = 3e-4,
               .gyro_random_walk = 1e-9,
               .accelerometer_random_walk = 1e-6,
               .gyro = {.sigma = 1e-6, .correlation_time = 50.0},
               .accelerometer = {.sigma = 3e-3, .correlation_time = 20.0},
               .position_sigma = {5.0, 6.0, 7.0},
               .velocity_sigma = {0.1, 0.2, 0.3}};
    return m;
}

// Increments of 10 ms of a body that sways and feels about its weight.
ImuIncrement increment(int k) {
    const double t = 0.01 * k;
    return {.dt = 0.01,
            .delta_angle = {0.004 * std::sin(3.0 * t), 0.003 * std::cos(2.0 * t), -0.002},
            .delta_velocity = {0.01 * std::cos(4.0 * t), 0.02 * std::sin(5.0 * t), 0.098}};
}

Preintegration preintegrated(int first, int last) {
    Preintegration sum;
    for (int k = first; k < last; ++k) {
        sum = sum * Preintegration::of(increment(k - 1), increment(k));
    }
    return sum;
}

template <class Model>
class InvariantModel : public ::testing::Test {
  public:
    static constexpr int n = Model::kStates;
    using State = typename Model::State;
    using Deviation = typename Model::Deviation;

    State random_state() {
        State x = State::of(random.navigation_state());
        for (int i = 0; i < Model::kSensors; ++i) {
            x.sensors(i) = random((i / 3) % 2 == 0 ? 1e-6 : 1e-2);
        }
        return x;
    }

    // Of the size that gyros, velocities and so on have.
    static Deviation scale() {
        Deviation s;
        s.setConstant(1e-2);
        s.template head<9>() << Vector3d::Constant(1e-3), Vector3d::Constant(0.5), Vector3d::Constant(10.0);
        for (int i = Model::kGyro; i < n; i += 6) {
            s.template segment<3>(i).setConstant(1e-6);
        }
        return s;
    }

    Deviation random_deviation() {
        Deviation d = scale();
        for (double& component : d) {
            component *= random(1.0);
        }
        return d;
    }

    typename Model::Fix random_fix(const State& x) {
        const NavigationState truth = x.navigation();
        return Model::Fix::of(earth::displaced(truth.position, random.vector(20.0)),
                              truth.velocity + random.vector(1.0), random.vector(5.0), random.vector(0.5));
    }

    // Of another state than the x for which the fix was made: it knows the gyros, by which the antenna moves
    // about the IMU, differently.
    static Vector<6> residual_of(const State& other, const State& x, typename Model::Fix fix) {
        const Vector<6> difference = Model::sensor_error(other) - Model::sensor_error(x);
        fix.velocity_arm -= difference.template head<3>().cross(fix.lever_arm);
        return Model::residual(other, fix);
    }

    static State moved(const Model& model, State x, const Preintegration& interval) {
        Points<n, 1> centre = Points<n, 1>::Zero();
        model.propagate(x, centre, interval);
        return x;
    }

    RandomValues random{1};
    const Model model = truenorth::model<n == 21>();
};

using Models = ::testing::Types<Invariant<false>, Invariant<true>>;
TYPED_TEST_SUITE(InvariantModel, Models);

TYPED_TEST(InvariantModel, StateIsThatOfTheNavigation) {
    for (int k = 0; k < 20; ++k) {
        const NavigationState navigation = this->random.navigation_state();
        const NavigationState back = TypeParam::State::of(navigation).navigation();
        EXPECT_LT(navigation.q_bn.angularDistance(back.q_bn), 1e-7);  // of a cosine
        EXPECT_LT((navigation.velocity - back.velocity).norm(), 1e-11);
        EXPECT_LT(earth::displacement(navigation.position, back.position).norm(), 1e-7);
    }
}

TYPED_TEST(InvariantModel, LocalUndoesRetractAtAnyMisalignment) {
    for (int k = 0; k < 50; ++k) {
        const auto x = this->random_state();
        auto d = this->random_deviation();
        d.template head<3>() = this->random.vector(1.7);  // less than half a turn
        const auto back = TypeParam::local(x, TypeParam::retract(x, d));
        EXPECT_LT((back - d).cwiseQuotient(this->scale()).norm(), 1e-6);  // rounding of 6e6 m
    }
}

// The property that the whole model stands on.
TYPED_TEST(InvariantModel, ErrorsOfAnySizeMoveByTheSameMatrixWhateverTheState) {
    const Preintegration interval = preintegrated(1, 101);
    for (int k = 0; k < 50; ++k) {
        auto x = this->random_state();
        x.sensors.setZero();
        auto d = this->random_deviation();
        d.template tail<TypeParam::kSensors>().setZero();
        d.template head<3>() = this->random.vector(1.7);
        const auto expected = TypeParam::local(this->moved(this->model, x, interval),
                                               this->moved(this->model, TypeParam::retract(x, d), interval));
        auto other = this->random_state();
        other.sensors.setZero();
        const auto Phi = this->model.transition(other, interval);
        const auto difference = (Phi * d - expected).eval();
        // The gradient of gravitation over 25 m, and rounding of 6e6 m.
        EXPECT_LT(difference.template head<3>().norm(), 1e-12);
        EXPECT_LT(difference.template segment<3>(3).norm(), 3.1e-6 * 25.0 * 2.0);
        EXPECT_LT(difference.template segment<3>(6).norm(), 3.1e-6 * 25.0 * 2.0);
        EXPECT_EQ((difference.template tail<TypeParam::kSensors>().norm()), 0.0);
    }
}

// Increments of 10 ms of a body that does not turn.
Preintegration straight() {
    Preintegration sum;
    for (int k = 1; k < 101; ++k) {
        ImuIncrement before = increment(k - 1);
        ImuIncrement next = increment(k);
        before.delta_angle.setZero();
        next.delta_angle.setZero();
        sum = sum * Preintegration::of(before, next);
    }
    return sum;
}

// With what the two-frame group adds: an accelerometer that is off by any amount, seen from any misalignment.
TYPED_TEST(InvariantModel, AccelerometerErrorsOfAnySizeMoveByTheSameMatrixWhileTheBodyDoesNotTurn) {
    const Preintegration interval = straight();
    for (int k = 0; k < 50; ++k) {
        auto x = this->random_state();
        x.sensors.setZero();
        auto d = this->random_deviation();
        d.template tail<TypeParam::kSensors>().setZero();
        d.template head<3>() = this->random.vector(1.7);
        d.template segment<3>(TypeParam::kAccelerometer) = this->random.vector(0.5);  // 50 mg
        const auto expected = TypeParam::local(this->moved(this->model, x, interval),
                                               this->moved(this->model, TypeParam::retract(x, d), interval));
        const auto difference = (this->model.transition(x, interval) * d - expected).eval();
        EXPECT_LT(difference.template head<3>().norm(), 1e-12);
        EXPECT_LT(difference.template segment<3>(3).norm(), 3.1e-6 * 25.0 * 2.0);
        EXPECT_LT(difference.template segment<3>(6).norm(), 3.1e-6 * 25.0 * 2.0);
        EXPECT_LT(difference.template segment<3>(TypeParam::kAccelerometer).norm(), 1e-12);
    }
}

// Whatever has been learnt of the sensors meanwhile: what is known of tilts, velocity and sensors moves as if
// it had not.
TYPED_TEST(InvariantModel, TransportTakesWhatWasLearntOutOfTheTransition) {
    constexpr int n = TestFixture::n;
    const Preintegration interval = straight();
    const auto S = this->scale();
    for (int k = 0; k < 20; ++k) {
        const auto x = this->random_state();
        auto y = x;
        for (int i = 0; i < TypeParam::kSensors; ++i) {
            y.sensors(i) += this->random((i / 3) % 2 == 0 ? 1e-5 : 0.2);
        }
        Matrix<n> but_heading = Matrix<n>::Identity();
        const Vector3d up = x.navigation().q_bn.conjugate() * Vector3d::UnitZ();
        but_heading.template topLeftCorner<3, 3>() -= up * up.transpose();
        const auto before = this->moved(this->model, x, interval);
        const auto after = this->moved(this->model, y, interval);
        const auto scaled = [&](const Matrix<n>& F) -> double {
            return (S.cwiseInverse().asDiagonal() * F * but_heading * S.asDiagonal()).cwiseAbs().maxCoeff();
        };
        const Matrix<n> one = TypeParam::transport(before, after) * this->model.transition(x, interval);
        const Matrix<n> other = this->model.transition(y, interval) * TypeParam::transport(x, y);
        // An unknown gyro turns the body, by 1e-6 rad, and 0.2 m/s2 with it, against 0.01.
        EXPECT_LT(scaled(one - other), 5e-5);
        EXPECT_GT(scaled(this->model.transition(y, interval) - this->model.transition(x, interval)), 1e-4);
    }
}

// A vehicle at rest that learns of its accelerometers, and is levelled with that: what it does not know of
// its heading is a turn about the vertical before and after, and no matter of accelerometers.
TYPED_TEST(InvariantModel, TransportLeavesAHeadingAHeading) {
    for (int k = 0; k < 20; ++k) {
        const auto x = this->random_state();
        const auto up = [](const auto& state) -> Vector3d {
            return state.navigation().q_bn.conjugate() * Vector3d::UnitZ();
        };
        typename TypeParam::Deviation c = TypeParam::Deviation::Zero();
        c.template segment<3>(TypeParam::kAccelerometer) = this->random.vector(0.02);
        // (E - I) f = c, with f = g up.
        c.template head<3>() = up(x).cross(c.template segment<3>(TypeParam::kAccelerometer)) / 9.80665;
        const auto y = TypeParam::retract(x, c);
        typename TypeParam::Deviation heading = TypeParam::Deviation::Zero();
        heading.template head<3>() = up(x);
        const typename TypeParam::Deviation after = TypeParam::transport(x, y) * heading;
        EXPECT_LT((after.template head<3>() - up(y)).norm(), 1e-5);  // the square of 2 mg
        EXPECT_GT((up(x) - up(y)).norm(), 1e-5);
        EXPECT_LT(after.template tail<TypeParam::kSensors>().norm(), 1e-4);
    }
}

TYPED_TEST(InvariantModel, TransitionIsTheDerivativeOfTheMotion) {
    constexpr int n = TestFixture::n;
    const Preintegration interval = preintegrated(1, 101);
    const auto x = this->random_state();
    const auto S = this->scale();
    const auto end = this->moved(this->model, x, interval);
    const auto image = [&](const Vector<n>& scaled) -> Vector<n> {
        const auto start = TypeParam::retract(x, S.cwiseProduct(scaled));
        return TypeParam::local(end, this->moved(this->model, start, interval)).cwiseQuotient(S);
    };
    const Matrix<n> expected = central_difference<n, n>(image, Vector<n>(Vector<n>::Zero()), 1.0);
    const Matrix<n> Phi =
        S.cwiseInverse().asDiagonal() * this->model.transition(x, interval) * S.asDiagonal();
    // Gravitation over 10 m, against 0.5 m/s.
    EXPECT_LT((Phi - expected).cwiseAbs().maxCoeff(), 7e-5);
    EXPECT_GT((expected - Matrix<n>::Identity()).cwiseAbs().maxCoeff(), 1e-2);
}

TYPED_TEST(InvariantModel, PropagateAppliesTheTransitionToEveryDeviation) {
    constexpr int n = TestFixture::n;
    const Preintegration interval = preintegrated(1, 101);
    auto x = this->random_state();
    const auto Phi = this->model.transition(x, interval);
    Points<n, 3> deviations;
    deviations << Vector<n>::Zero(), this->random_deviation(), this->random_deviation();
    const Points<n, 3> expected = Phi * deviations;
    this->model.propagate(x, deviations, interval);
    EXPECT_LT((deviations - expected).norm(), 1e-14);
}

TYPED_TEST(InvariantModel, CarriesACovarianceAsTransitionAndProcessNoiseDo) {
    constexpr int n = TypeParam::kStates;
    const auto x = this->random_state();
    const Preintegration interval = preintegrated(1, 101);
    const Matrix<n> F = this->model.transition(x, interval);
    Matrix<n> root = Matrix<n>::Zero();
    for (int i = 0; i < n; ++i) {
        root.col(i) = this->random_deviation();
    }
    const Matrix<n> P = root * root.transpose();
    const Matrix<n> expected = F * P * F.transpose() + this->model.process_noise(x, interval);
    const Matrix<n> carried = this->model.carried_covariance(P, F, interval);
    const Vector<n> unit = expected.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT((unit.asDiagonal() * (carried - expected) * unit.asDiagonal()).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_EQ(carried, carried.transpose());
}

TYPED_TEST(InvariantModel, ProcessNoiseIsTheSumOverShortIntervals) {
    constexpr int n = TestFixture::n;
    const auto x = this->random_state();
    Matrix<n> sum = Matrix<n>::Zero();
    for (int k = 1; k < 101; ++k) {
        const Preintegration step = preintegrated(k, k + 1);
        const Matrix<n> F = this->model.transition(x, step);
        sum = F * sum * F.transpose() + this->model.process_noise(x, step);
    }
    const Matrix<n> Q = this->model.process_noise(x, preintegrated(1, 101));
    const Vector<n> sigma = sum.diagonal().cwiseSqrt();
    EXPECT_GT(sigma.minCoeff(), 0.0);
    // A body that turns by 0.4 rad costs 2 %. Position, which has no noise of its own and is observed to
    // metres while this is millimetres, is less exact: Gauss-Markov forces enter it by two integrals.
    Matrix<n> difference = (Q - sum).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs();
    EXPECT_LT((difference.template block<3, 3>(TypeParam::kPosition, TypeParam::kPosition).maxCoeff()), 0.5);
    difference.template middleRows<3>(TypeParam::kPosition).setZero();
    difference.template middleCols<3>(TypeParam::kPosition).setZero();
    EXPECT_LT(difference.maxCoeff(), 0.05);
    EXPECT_EQ(Q, Q.transpose());
}

TYPED_TEST(InvariantModel, ResidualOfThePerfectFixIsZero) {
    for (int k = 0; k < 20; ++k) {
        const NavigationState truth = this->random.navigation_state();
        const Vector3d lever_arm = this->random.vector(5.0);
        const Vector3d omega_eb_b = this->random.vector(0.5);
        const Vector3d omega_ib_b =
            omega_eb_b + truth.q_bn.conjugate() * earth::rate(truth.position.latitude);
        const auto fix =
            TypeParam::Fix::of(point_position(truth, lever_arm), point_velocity(truth, omega_eb_b, lever_arm),
                               lever_arm, omega_ib_b);
        const auto residual = TypeParam::residual(TypeParam::State::of(truth), fix);
        EXPECT_LT(residual.template head<3>().norm(), 1e-4);  // 8.7^2 m^2 / R tan L: metres to angles
        // The velocity is in the axes at the IMU, and is read in those at the antenna: 170 m/s 8.7 m / R tan
        // L.
        EXPECT_LT(residual.template tail<3>().norm(), 1e-3);
    }
}

// What a late fix says of the state of now is what it said of the state then, errors of any size included.
TYPED_TEST(InvariantModel, LateFixSeesTheStateAsItWas) {
    const Preintegration since = preintegrated(1, 51);
    for (int k = 0; k < 20; ++k) {
        auto then = this->random_state();
        then.sensors.setZero();
        const auto fix = this->random_fix(then);
        const auto late = fix.after(since.change, since.duration);
        auto d = this->random_deviation();
        d.template head<3>() = this->random.vector(1.7);
        d.template tail<TypeParam::kSensors>().setZero();
        for (const auto& state : {then, TypeParam::retract(then, d)}) {
            const auto expected = TypeParam::residual(state, fix);
            const auto residual = TypeParam::residual(this->moved(this->model, state, since), late);
            // The velocity measured carries the position, 0.5 s; both in the axes of now.
            Vector<6> shifted = expected;
            shifted.template head<3>() += since.duration * expected.template tail<3>();
            const Vector<6> difference = residual - shifted;
            EXPECT_LT(difference.template head<3>().norm(), 4e-5 * expected.norm() + 1e-4);
            EXPECT_LT(difference.template tail<3>().norm(), 4e-5 * expected.norm() + 1e-4);
        }
    }
}

TYPED_TEST(InvariantModel, MeasurementMatrixIsTheDerivativeOfTheResidual) {
    constexpr int n = TestFixture::n;
    for (int k = 0; k < 10; ++k) {
        const auto x = this->random_state();
        const auto fix = this->random_fix(x);
        const auto S = this->scale();
        const auto predicted = [&](const Vector<n>& scaled) -> Vector<6> {
            return -this->residual_of(TypeParam::retract(x, S.cwiseProduct(scaled)), x, fix);
        };
        const Matrix<6, n> expected = central_difference<6, n>(predicted, Vector<n>(Vector<n>::Zero()), 1.0);
        const Matrix<6, n> H = TypeParam::measurement_matrix(x, fix) * S.asDiagonal();
        EXPECT_LT((H - expected).cwiseAbs().maxCoeff(), 1e-8 * 10.0);
        EXPECT_GT((H.template leftCols<3>().norm()), 1e-3);
    }
}

TYPED_TEST(InvariantModel, PredictedIsTheDifferenceOfResidualsForErrorsOfAnySize) {
    const auto x = this->random_state();
    const auto fix = this->random_fix(x);
    Points<TestFixture::n, 2> deviations;
    for (int i = 0; i < 2; ++i) {
        auto d = this->random_deviation();
        d.template head<3>() = this->random.vector(1.7);
        d.template segment<3>(TypeParam::kGyro).setConstant(0.01);  // so that its lever velocity is seen
        deviations.col(i) = d;
    }
    const Points<6, 2> images = this->model.predicted(x, deviations, fix);
    for (int i = 0; i < 2; ++i) {
        const auto other = TypeParam::retract(x, typename TypeParam::Deviation(deviations.col(i)));
        const Vector<6> expected = TypeParam::residual(x, fix) - this->residual_of(other, x, fix);
        EXPECT_LT((images.col(i) - expected).norm(), 1e-8);  // rounding of 6e6 m
    }
}

TYPED_TEST(InvariantModel, MeasurementNoiseIsTheSquaredSigmaOfEachComponent) {
    Vector<6> expected;
    expected << 25.0, 36.0, 49.0, 0.01, 0.04, 0.09;
    const auto x = this->random_state();
    const Matrix<6> R = this->model.measurement_noise(x, this->random_fix(x));
    EXPECT_LT((R - Matrix<6>(expected.asDiagonal())).norm(), 1e-14);
}

TYPED_TEST(InvariantModel, NavigationErrorsAreThoseOfTheLocalLevel) {
    constexpr int n = TestFixture::n;
    for (int k = 0; k < 10; ++k) {
        const auto x = this->random_state();
        const auto S = this->scale();
        const NavigationState computed = x.navigation();
        const auto errors = [&](const Vector<n>& scaled) -> Vector<n> {
            const auto truth = TypeParam::retract(x, S.cwiseProduct(scaled));
            Vector<n> e;
            e << navigation_error::local(truth.navigation(), computed), (truth.sensors - x.sensors).eval();
            return e.cwiseQuotient(S);
        };
        const Matrix<n> expected = central_difference<n, n>(errors, Vector<n>(Vector<n>::Zero()), 1.0);
        const Matrix<n> J = TypeParam::navigation_errors(x);
        const Matrix<n> scaled = S.cwiseInverse().asDiagonal() * J * S.asDiagonal();
        // A displacement turns the local axes: 10 m / R tan L against 1e-3 rad, and 170 m/s of that against
        // 0.5 m/s.
        EXPECT_LT((scaled - expected).cwiseAbs().maxCoeff(), 5e-3);
        EXPECT_TRUE((J * J.transpose()).eval().isIdentity(1e-12));
    }
}

// A vessel that sways on a steady course, as a filter sees it: intervals and fixes of one second, the
// velocity of which is wrong by what `error` gives. Only the intervals know of the sensors' biases.
struct Voyage {
    NavigationState start;
    NavigationState end;
    std::vector<Epoch<Invariant<false>>> epochs;
    std::vector<NavigationState> measured;  // position and velocity of the fixes
    std::vector<IntervalAverage> averages;  // of a mechanisation that is wrong at the start
    std::vector<NavigationState> computed;  // by it, at the fixes
};

template <class Error>
Voyage voyage(int seconds, const Error& error, const navigation_error::Error& wrong,
              const Vector<6>& bias = Vector<6>::Zero()) {
    Voyage v;
    v.start = {.q_bn = Eigen::Quaterniond(dcm({.roll = 0.02, .pitch = 0.03, .heading = 1.0})),
               .velocity = {1.0, 10.0, 0.0},
               .position = {.latitude = 32.0 * kDegree, .longitude = 2.0, .height = 0.0}};
    Mechanisation truth(v.start);
    Mechanisation computed(navigation_error::retract(v.start, wrong));
    ImuIncrement before;
    for (int s = 0; s < seconds; ++s) {
        Preintegration interval;
        IntervalAverage average;
        for (int k = 0; k < 100; ++k) {
            const double t = s + 0.01 * k;
            // The force that carries the vessel, in the body as it stands.
            const Vector3d up(0.0, 0.0, earth::gravity(v.start.position.latitude, 0.0) * 0.01);
            const ImuIncrement next{
                .dt = 0.01,
                .delta_angle = {8e-4 * std::cos(0.8 * t), 6e-4 * std::cos(0.6 * t), 9e-4 * std::cos(t)},
                .delta_velocity = truth.state.q_bn.conjugate() * up};
            const ImuIncrement measured{.dt = 0.01,
                                        .delta_angle = next.delta_angle + 0.01 * bias.head<3>(),
                                        .delta_velocity = next.delta_velocity + 0.01 * bias.tail<3>()};
            interval = interval * Preintegration::of(before, measured);
            before = measured;
            truth.advance(next);
            const NavigationState old = computed.state;
            computed.advance(next);
            average.add(old, computed, 0.01);
        }
        v.measured.push_back(truth.state);
        v.measured.back().velocity += error();
        v.epochs.push_back(
            {.interval = interval,
             .fix = Invariant<false>::Fix::of(v.measured.back().position, v.measured.back().velocity,
                                              Vector3d::Zero(), Vector3d::Zero())});
        v.averages.push_back(average);
        v.computed.push_back(computed.state);
    }
    v.end = truth.state;
    return v;
}

void filter(const Invariant<false>& model, Invariant<false>::State& x, Matrix<15>& P,
            const Epoch<Invariant<false>>& epoch) {
    Linearised().predict(model, x, P, epoch.interval);
    const auto correction = Standard().correct(P, innovate(model, x, P, epoch.fix));
    P = correction.covariance;
    correct(model, x, correction.deviation, [&P](const Matrix<15>& F) { P = transformed<15>(F, P); });
}

Vector<15> sigmas(const Vector3d& attitude, double velocity, double position) {
    Vector<15> sigma;
    sigma << attitude, Vector3d::Constant(velocity), Vector3d::Constant(position), Vector3d::Constant(2.4e-7),
        Vector3d::Constant(9.8e-3);
    return sigma;
}

// From sigmas of the navigation errors, east, north, up.
Matrix<15> covariance_of(const Invariant<false>::State& x, const Vector<15>& sigma) {
    const Matrix<15> J = Invariant<false>::navigation_errors(x);
    return J.transpose() * sigma.cwiseAbs2().asDiagonal() * J;
}

// There is nothing in it that a wrong heading could spoil, but what a rolling and pitching body makes of the
// biases that were found.
TEST(InvariantFilter, CovarianceDoesNotDependOnTheEstimate) {
    const auto difference = [](double biases) -> double {
        RandomValues random(5);
        const Voyage v =
            voyage(60, [&]() -> Vector3d { return random.vector(0.3); }, navigation_error::Error::Zero());
        auto m = model<false>();
        m.noise.position_sigma.setConstant(5.0);
        m.noise.velocity_sigma.setConstant(0.1);
        m.noise.gyro_random_walk *= biases;
        m.noise.accelerometer_random_walk *= biases;
        Vector<15> prior = sigmas(Vector3d(0.01, 0.01, 0.2), 0.5, 5.0);
        prior.tail<6>() *= biases;
        std::vector<Matrix<9>> covariances;
        for (const double heading : {0.0, 2.5}) {
            NavigationState start = v.start;
            start.q_bn = quaternion({0.0, 0.0, heading}) * start.q_bn;
            auto x = Invariant<false>::State::of(start);
            const auto nothing_learnt = x;
            Matrix<15> P = covariance_of(x, prior);
            for (const auto& epoch : v.epochs) {
                filter(m, x, P, epoch);
            }
            P = transformed<15>(Invariant<false>::transport(x, nothing_learnt), P);
            covariances.emplace_back(P.topLeftCorner<9, 9>());
        }
        const Vector<9> sigma = covariances[0].diagonal().cwiseSqrt();
        const Matrix<9> relative = (covariances[1] - covariances[0]).cwiseQuotient(sigma * sigma.transpose());
        return relative.cwiseAbs().maxCoeff();
    };
    EXPECT_LT(difference(0.0), 1e-6);
    EXPECT_LT(difference(1.0), 0.01);
}

TEST(InvariantFilter, AgreesWithTheLooseModelWhenErrorsAreSmall) {
    RandomValues random(6);
    navigation_error::Error wrong;
    wrong << 2e-4, -3e-4, 5e-3, 0.1, -0.1, 0.05, 3.0, -2.0, 1.0;
    const Voyage v = voyage(120, [&]() -> Vector3d { return random.vector(0.1); }, wrong);
    auto m = model<false>();
    Loose loose{.noise = {.angle_random_walk = m.noise.angle_random_walk,
                          .velocity_random_walk = m.noise.velocity_random_walk,
                          .gyro_random_walk = m.noise.gyro_random_walk,
                          .accelerometer_random_walk = m.noise.accelerometer_random_walk,
                          .position_sigma = m.noise.position_sigma,
                          .velocity_sigma = m.noise.velocity_sigma}};
    auto x = Invariant<false>::State::of(navigation_error::retract(v.start, wrong));
    const Vector<15> sigma = sigmas(Vector3d(1e-3, 1e-3, 1e-2), 0.2, 5.0);
    Matrix<15> P = covariance_of(x, sigma);
    Matrix<15> P_loose = sigma.cwiseAbs2().asDiagonal();
    Loose::State x_loose = Loose::State::Zero();
    for (std::size_t k = 0; k < v.epochs.size(); ++k) {
        filter(m, x, P, v.epochs[k]);

        const NavigationState& measured = v.measured[k];
        const NavigationState& computed = v.computed[k];
        Linearised().predict(loose, x_loose, P_loose,
                             Loose::Interval(v.averages[k], computed.position, x_loose));
        const Loose::Fix fix{
            .position_difference = earth::displacement(measured.position, computed.position),
            .velocity_difference = computed.velocity - measured.velocity,
            .antenna = {computed.q_bn.toRotationMatrix(), Vector3d::Zero(), Vector3d::Zero()}};
        const auto loose_correction = Standard().correct(P_loose, innovate(loose, x_loose, P_loose, fix));
        x_loose += loose_correction.deviation;
        P_loose = loose_correction.covariance;
    }
    const Vector<15> sigma_loose = P_loose.diagonal().cwiseSqrt();
    const Matrix<15> J = Invariant<false>::navigation_errors(x);
    const Vector<15> ours = (J * P * J.transpose()).diagonal().cwiseSqrt();
    EXPECT_LT((ours - sigma_loose).cwiseQuotient(sigma_loose).cwiseAbs().maxCoeff(), 0.01);
    const NavigationState theirs = Loose::corrected(v.computed.back(), x_loose);
    const Vector<9> difference = navigation_error::local(theirs, x.navigation());
    EXPECT_LT(difference.cwiseQuotient(sigma_loose.head<9>()).cwiseAbs().maxCoeff(), 0.05);
    const Vector<6> sensors = (x.sensors - x_loose.tail<6>()).cwiseQuotient(sigma_loose.tail<6>());
    EXPECT_LT(sensors.cwiseAbs().maxCoeff(), 0.05);
}

// The whole way from nothing: vectors, the series linearised at what they found, and at what came of that,
// then the filter. Accelerometers of this bias sigma [m/s2].
struct Outcome {
    double nees = 0.0;     // of the attitude, its mean for each angle
    double largest = 0.0;  // error of the attitude [rad]
};
constexpr int kVoyages = 50;
Outcome from_nothing(double accelerometer_sigma) {
    RandomValues random(7);
    constexpr std::size_t coarse = 100;
    auto m = model<false>();
    m.noise = {.angle_random_walk = 0.0,
               .velocity_random_walk = 0.0,
               .gyro_random_walk = 0.0,
               .accelerometer_random_walk = 0.0,
               .gyro = {},
               .accelerometer = {},
               .position_sigma = Vector3d::Constant(5.0),
               .velocity_sigma = Vector3d::Constant(0.05)};
    Vector<15> sigma =
        sigmas(Vector3d::Constant(std::numbers::pi / std::sqrt(3.0)), 0.05, 5.0);  // any attitude
    sigma.tail<3>().setConstant(accelerometer_sigma);
    const double uniform = std::sqrt(3.0);  // half of the width over sigma
    Outcome outcome;
    for (int run = 0; run < kVoyages; ++run) {
        Vector<6> bias;
        bias << random.vector(uniform * sigma(9)), random.vector(uniform * sigma(12));
        const Voyage v = voyage(
            150, [&]() -> Vector3d { return random.vector(uniform * 0.05); }, navigation_error::Error::Zero(),
            bias);
        VectorAlignment vectors;
        const auto begin = std::span(v.epochs).first(coarse);
        for (const auto& [interval, fix] : begin) {
            vectors.add(
                interval,
                {.position = fix.position, .velocity = fix.velocity, .velocity_arm = Vector3d::Zero()});
        }
        const auto solution = vectors.solve();
        EXPECT_TRUE(solution);
        Invariant<false>::State x;
        Matrix<15> P;
        Eigen::Quaterniond attitude = solution->at_first_fix;
        for (int pass = 0; pass < 2; ++pass) {
            x.pose = {
                .attitude = attitude, .velocity = begin[0].fix.velocity, .position = begin[0].fix.position};
            P = covariance_of(x, sigma);
            Vector<15> prior = Vector<15>::Zero();
            prior.tail<6>() = -x.sensors;
            filter_along_trajectory(m, x, P, prior, begin.subspan(1),
                                    [](const auto& covariance, const auto& innovation) {
                                        return Standard().correct(covariance, innovation);
                                    });
            attitude = vectors.at_first_fix(x.pose.attitude, x.sensors);
        }
        for (const auto& epoch : std::span(v.epochs).subspan(coarse)) {
            filter(m, x, P, epoch);
        }
        const Vector3d error = Invariant<false>::local(x, Invariant<false>::State::of(v.end)).head<3>();
        outcome.nees += error.dot(P.topLeftCorner<3, 3>().llt().solve(error)) / (3.0 * kVoyages);
        outcome.largest = std::max(outcome.largest, error.norm());
    }
    return outcome;
}

// 1 mg and 20 mg.
TEST(InvariantFilter, CovarianceIsThatOfTheErrorsWhenNoAttitudeIsKnown) {
    for (const double bias : {9.8e-3, 0.196}) {
        const Outcome outcome = from_nothing(bias);
        EXPECT_NEAR(outcome.nees, 1.0, 3.3 * std::sqrt(2.0 / (3.0 * kVoyages))) << bias;  // 99.9 %
        EXPECT_LT(outcome.largest, 4.0 * kDegree) << bias;
    }
}

}  // namespace
}  // namespace truenorth
