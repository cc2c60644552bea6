#include "filter/arrival.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "filter/gnss_input.hpp"
#include "filter/imu_input.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(ArrivalTest, IsCountedAsTheCountSays) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.0), 0);
    EXPECT_FALSE(arrival.any());
    EXPECT_EQ(arrival.number(7, 0.1), 7);
    EXPECT_EQ(arrival.number(7, 0.2), 7);
    EXPECT_EQ(arrival.number(0, 0.3), 0);  // the sensor starts again
    EXPECT_EQ(arrival.number(0, 0.4), 0);
    EXPECT_TRUE(arrival.any());
    EXPECT_FALSE(arrival.by_stamps());
}

TEST(ArrivalTest, WithoutACountIsANewStampAfterTheFirst) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.1), 0);
    EXPECT_EQ(arrival.number(0, 0.1), 0);
    EXPECT_FALSE(arrival.any());
    EXPECT_EQ(arrival.number(0, 0.2), 1);
    EXPECT_EQ(arrival.number(0, 0.2), 1);
    EXPECT_EQ(arrival.number(0, 0.1), 2);
    EXPECT_TRUE(arrival.by_stamps());
}

TEST(ArrivalTest, AStampThatIsNoNumberSaysNothing) {
    Arrival arrival;
    for (const double stamp : {kNaN, 0.1, kNaN, 0.1, std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(arrival.number(0, stamp), 0);
    }
    EXPECT_EQ(arrival.number(0, 0.2), 1);
}

TEST(ArrivalTest, OfACountThatBeginsAtZeroLosesNoMeasurement) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.0), 0);
    EXPECT_EQ(arrival.number(0, 0.1), 1);
    EXPECT_EQ(arrival.number(1, 0.2), 2);
    EXPECT_EQ(arrival.number(1, 0.3), 2);
    EXPECT_EQ(arrival.number(std::numeric_limits<int>::max(), 0.4), std::numeric_limits<int>::min());
}

TEST(ArrivalTest, OfAFixIsByStampsBesideAnUncountedImuAlone) {
    Arrival arrival;
    const Vector3d value(1.0, 2.0, 3.0);
    double stamp = 0.0;
    for (int k = 0; k < 5; ++k) {
        EXPECT_EQ(arrival.number(0, stamp += 0.1, value * k, false), 0);
    }
    EXPECT_FALSE(arrival.any());
    EXPECT_EQ(arrival.number(0, stamp += 0.1, value, true),
              0);  // of what lies there at the start nobody knows
    EXPECT_EQ(arrival.number(0, stamp += 0.1, 2.0 * value, true), 1);
    EXPECT_EQ(arrival.number(3, stamp += 0.1, 3.0 * value, true), 4);
}

TEST(ArrivalTest, OfAFixThatIsHeldIsNotNewWhateverItsStamp) {
    Arrival arrival;
    const Vector3d value(1.0, kNaN, 3.0);
    EXPECT_EQ(arrival.number(0, 0.1, value, true), 0);
    EXPECT_EQ(arrival.number(0, 0.2, value, true), 0);
    EXPECT_EQ(arrival.number(0, 0.3, 2.0 * value, true), 1);
    EXPECT_EQ(arrival.number(0, 0.4, 2.0 * value, true), 1);
    EXPECT_EQ(arrival.number(0, 0.5, value, true), 2);
}

TEST(ArrivalTest, IsToldOnce) {
    Arrival arrival;
    EXPECT_TRUE(arrival.tell());
    EXPECT_FALSE(arrival.tell());
}

TEST(ArrivalTest, OfAnUncountedImuIsAsIfItCounted) {
    ImuInput counted;
    ImuInput stamped;
    counted.start(0.0);
    stamped.start(0.0);
    int sample = 0;
    for (const double time : {0.0, 0.01, 0.02, 0.02, 0.03, 0.07, 0.08}) {
        const Vector3d angle(1e-4 * time, 2e-4, 0.0);
        const Vector3d velocity(0.0, 1e-3, 0.098);
        sample += time > stamped.time() ? 1 : 0;
        EXPECT_EQ(stamped.read(0, time, angle, velocity, time),
                  counted.read(sample, time, angle, velocity, time));
        EXPECT_EQ(stamped.increment().dt, counted.increment().dt);
    }
    EXPECT_EQ(stamped.time(), 0.08);
    EXPECT_EQ(stamped.rejected(), 0);
    EXPECT_EQ(stamped.missed(), counted.missed());
}

TEST(ArrivalTest, OfUncountedFixesIsNewWhatHasANewStampAndNewValues) {
    GnssInput input;
    input.start();
    const StampClock::Moment now{.now = 10.0, .offset = 0.0, .slack = 0.01, .oldest = 0.0};
    GnssFix fix;
    fix.position.latitude = 0.5;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::stale);
    fix.time = 9.0;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::stale);
    fix.position.latitude = 0.500001;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::accepted);
    fix.position.latitude = 0.500002;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::stale);  // the stamp has been seen
    fix.time = 9.5;
    fix.position.latitude = 0.500003;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::accepted);
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::stale);
}

TEST(ArrivalTest, OfChannelsIsNewWhatHasANewStamp) {
    GnssInput input;
    input.start();
    const StampClock::Moment now{.now = 10.0, .offset = 0.0, .slack = 0.01, .oldest = 0.0};
    GnssFix fix;
    fix.has_channels = true;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::stale);
    fix.time = 9.0;
    EXPECT_EQ(input.read(0, fix, now, 0.0, true), GnssInput::Verdict::accepted);
}

}  // namespace
}  // namespace truenorth
