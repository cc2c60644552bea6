#include "filter/arrival.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "filter/gnss_input.hpp"
#include "filter/imu_input.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;

TEST(ArrivalTest, IsCountedAsTheCountSays) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.0, true), 0);
    EXPECT_EQ(arrival.number(7, 0.1, false), 7);
    EXPECT_EQ(arrival.number(7, 0.2, false), 7);
    EXPECT_EQ(arrival.number(0, 0.3, false), 0);  // the sensor starts again
    EXPECT_EQ(arrival.number(0, 0.4, false), 0);
    EXPECT_TRUE(arrival.counted());
    EXPECT_FALSE(arrival.stamped());
}

TEST(ArrivalTest, WithoutACountIsANewStamp) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.1, false), 1);
    EXPECT_EQ(arrival.number(0, 0.1, false), 1);
    EXPECT_EQ(arrival.number(0, 0.2, false), 2);
    EXPECT_EQ(arrival.number(0, 0.3, true), 3);  // what measures may measure nothing
    EXPECT_EQ(arrival.number(0, 0.2, false), 4);
    EXPECT_FALSE(arrival.counted());
}

TEST(ArrivalTest, IsNoneBeforeValuesCome) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 5.0, true), 0);
    EXPECT_EQ(arrival.number(0, 6.0, true), 0);
    EXPECT_FALSE(arrival.fed());
    EXPECT_EQ(arrival.number(0, 6.0, false), 1);
}

TEST(ArrivalTest, OfACountThatBeginsAtZeroLosesNoSample) {
    Arrival arrival;
    EXPECT_EQ(arrival.number(0, 0.1, false), 1);
    EXPECT_EQ(arrival.number(1, 0.2, false), 2);
    EXPECT_EQ(arrival.number(1, 0.3, false), 2);
    EXPECT_EQ(arrival.number(std::numeric_limits<int>::max(), 0.4, false), std::numeric_limits<int>::min());
}

TEST(ArrivalTest, IsToldOnce) {
    Arrival arrival;
    EXPECT_TRUE(arrival.tell());
    EXPECT_FALSE(arrival.tell());
}

TEST(ArrivalTest, OfAnUncountedImuKnowsGapsByItsStamps) {
    ImuInput counted;
    ImuInput stamped;
    counted.start(0.0);
    stamped.start(0.0);
    int sample = 0;
    for (const double time : {0.01, 0.02, 0.02, 0.03, 0.07, 0.08}) {
        const Vector3d angle(1e-4 * time, 2e-4, 0.0);
        const Vector3d velocity(0.0, 1e-3, 0.098);
        sample += time == 0.02 && sample == 2 ? 0 : 1;
        EXPECT_EQ(stamped.read(0, time, angle, velocity, time),
                  counted.read(sample, time, angle, velocity, time));
        EXPECT_EQ(stamped.increment().dt, counted.increment().dt);
    }
    EXPECT_EQ(stamped.time(), 0.08);
    EXPECT_EQ(stamped.rejected(), 0);
}

TEST(ArrivalTest, OfAFixAtTheOriginAloneIsNone) {
    GnssInput input;
    input.start();
    const StampClock::Moment now{.now = 10.0, .offset = 0.0, .slack = 0.01, .oldest = 0.0};
    GnssFix fix;
    fix.time = 9.0;
    EXPECT_EQ(input.read(0, fix, now), GnssInput::Verdict::stale);
    fix.position.latitude = 0.5;
    EXPECT_EQ(input.read(0, fix, now), GnssInput::Verdict::accepted);
    EXPECT_EQ(input.read(0, fix, now), GnssInput::Verdict::stale);
}

}  // namespace
}  // namespace truenorth
