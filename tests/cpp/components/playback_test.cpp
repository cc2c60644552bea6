#include "components/playback.hpp"

#include <gtest/gtest.h>

#include <cereal/archives/binary.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "contract/invalid_parameter.hpp"
#include "lines.hpp"
#include "recording_file.hpp"

namespace truenorth {
namespace {

class PlaybackTest : public testing::Test {
  protected:
    Playback of(const RecordingFile& file) {
        folder_.put(file.bytes());
        return {log_, std::make_shared<const RecordedSignals>(folder_.path())};
    }

    // Steps of `size` from `start` on.
    static void run(Playback& playback, int from, int to, double size = RecordingFile::period,
                    double start = 0.0) {
        for (int i = from; i < to; ++i) {
            playback.step(start + i * size, size);
        }
    }

    static std::string stored(Playback& playback) {
        std::ostringstream bytes;
        cereal::BinaryOutputArchive{bytes}(playback);
        return bytes.str();
    }

    static void restore(Playback& playback, const std::string& bytes) {
        std::istringstream stream(bytes);
        cereal::BinaryInputArchive{stream}(playback);
    }

    ResourceFolder folder_;
    Lines log_;
    RecordingFile file_;
};

// As a stored state may have it, which comes from outside.
TEST_F(PlaybackTest, ACountStaysWhereItCannotGoOn) {
    constexpr int most = std::numeric_limits<int>::max();
    constexpr int least = std::numeric_limits<int>::min();
    file_.body_velocity.push_back({3.0, 2.0, file_.time(3), 1, 2, 3, 4, 5, 6});
    file_.height_aid.push_back({3.0, 2.0, file_.time(3), 1, 2});
    Playback playback = of(file_);
    for (const int count : {most, most - 1, least}) {
        playback.initialise(0.0);
        auto& outputs = playback.outputs;
        for (int* const sample : {&outputs.imu.sample, &outputs.gnss.sample, &outputs.body_velocity.sample,
                                  &outputs.heading_aid.sample, &outputs.height_aid.sample}) {
            *sample = count;
        }
        restore(playback, stored(playback));
        run(playback, 0, 20);
        const bool far = count == least;
        EXPECT_EQ(outputs.imu.sample, far ? least + 20 : most);
        EXPECT_EQ(outputs.gnss.sample, far ? least + 1 : most);
        EXPECT_EQ(outputs.body_velocity.sample, far ? least + 2 : most);
        EXPECT_EQ(outputs.heading_aid.sample, far ? least + 4 : most);
        EXPECT_EQ(outputs.height_aid.sample, far ? least + 2 : most);
    }
}

TEST_F(PlaybackTest, BeginsBeforeItsFirstSample) {
    Playback playback = of(file_);
    playback.initialise(5.0);
    EXPECT_EQ(playback.outputs.imu.sample, 0);
    EXPECT_EQ(playback.outputs.imu.time, 5.0);
    EXPECT_EQ(playback.outputs.recording.time, 1000.0);
    EXPECT_EQ(playback.outputs.gnss.sample, 0);
    EXPECT_EQ(playback.outputs.gnss.latitude, 0.1);  // the first fix stands in
    EXPECT_EQ(playback.outputs.height_aid.time, 5.0);
    EXPECT_TRUE(std::isnan(playback.outputs.truth.heading));
    EXPECT_EQ(playback.sample_period(), 0.1);
}

TEST_F(PlaybackTest, PutsOutASampleAStepWithStampsOfTheSimulation) {
    for (const double start : {0.0, 7.0, 1000.0}) {
        Playback playback = of(file_);
        playback.initialise(start);
        for (int i = 1; i <= RecordingFile::samples; ++i) {
            run(playback, i - 1, i, 0.1, start);
            EXPECT_EQ(playback.outputs.imu.sample, i);
            EXPECT_NEAR(playback.outputs.imu.time, start + 0.1 * i, 1e-12);
            EXPECT_EQ(playback.outputs.recording.time, file_.time(i));
            EXPECT_EQ(playback.outputs.imu.delta_angle, Eigen::Vector3d::Constant(i));
            EXPECT_EQ(playback.outputs.imu.delta_velocity, Eigen::Vector3d::Constant(-i));
        }
    }
}

TEST_F(PlaybackTest, BetweenSamplesNothingIsNew) {
    Playback playback = of(file_);
    playback.initialise(0.0);
    run(playback, 0, 4, 0.025);
    EXPECT_EQ(playback.outputs.imu.sample, 1);
    const auto before = playback.outputs.imu;
    run(playback, 4, 7, 0.025);
    EXPECT_EQ(playback.outputs.imu.sample, before.sample);
    EXPECT_EQ(playback.outputs.imu.time, before.time);
    run(playback, 7, 8, 0.025);
    EXPECT_EQ(playback.outputs.imu.sample, 2);
}

TEST_F(PlaybackTest, AddsUpTheSamplesOfALongStep) {
    Playback playback = of(file_);
    playback.initialise(0.0);
    run(playback, 0, 2, 0.5);
    EXPECT_EQ(playback.outputs.imu.sample, 2);
    EXPECT_NEAR(playback.outputs.imu.time, 1.0, 1e-12);
    EXPECT_EQ(playback.outputs.imu.delta_angle, Eigen::Vector3d::Constant(6 + 7 + 8 + 9 + 10));
}

TEST_F(PlaybackTest, LostSamplesMakeTheCountJump) {
    file_.imu.erase(file_.imu.begin() + 20, file_.imu.begin() + 23);
    file_.imu[20][0] = 3.0;
    file_.gnss.clear();
    file_.heading_aid.clear();
    Playback playback = of(file_);
    playback.initialise(0.0);
    run(playback, 0, 23);
    EXPECT_EQ(playback.outputs.imu.sample, 20);
    run(playback, 23, 24);
    EXPECT_EQ(playback.outputs.imu.sample, 24);
    EXPECT_EQ(playback.outputs.imu.delta_angle, Eigen::Vector3d::Constant(24));
}

TEST_F(PlaybackTest, AidsComeWithTheirSample) {
    Playback playback = of(file_);
    playback.initialise(100.0);
    run(playback, 0, 30, 0.1, 100.0);
    EXPECT_EQ(playback.outputs.gnss.sample, 2);
    run(playback, 30, 31, 0.1, 100.0);
    EXPECT_EQ(playback.outputs.gnss.sample, 3);
    EXPECT_NEAR(playback.outputs.gnss.time, 103.0, 1e-12);
    EXPECT_NEAR(playback.outputs.gnss.latitude, 0.3, 1e-12);
    EXPECT_EQ(playback.outputs.gnss.velocity, Eigen::Vector3d::Constant(3.0));
    EXPECT_EQ(playback.outputs.gnss.fix_velocity_sigma, Eigen::Vector3d(4.0, 5.0, 6.0));
    EXPECT_EQ(playback.outputs.heading_aid.sample, 6);
    EXPECT_NEAR(playback.outputs.heading_aid.heading, 0.3, 1e-12);
    EXPECT_EQ(playback.outputs.heading_aid.sigma, 0.02);
    EXPECT_EQ(playback.outputs.body_velocity.sample, 0);
}

TEST_F(PlaybackTest, OfSeveralFixesTheLastIsPutOutAndAllAreCounted) {
    file_.gnss[2][1] = 2.0;  // it is the last of two
    Playback playback = of(file_);
    playback.initialise(0.0);
    run(playback, 0, 2, 2.5);
    EXPECT_EQ(playback.outputs.gnss.sample, 5);
    EXPECT_NEAR(playback.outputs.gnss.time, 4.0, 1e-12);
}

TEST_F(PlaybackTest, WhatIsSkippedIsNotCounted) {
    Playback playback = of(file_);
    playback.parameters.recording.skip = 2.0;
    playback.initialise(0.0);
    EXPECT_EQ(playback.outputs.recording.time, 1002.0);
    EXPECT_NEAR(playback.outputs.gnss.time, 1.0, 1e-12);  // that of 1002 s is at the begin, not after it
    run(playback, 0, 11);
    EXPECT_EQ(playback.outputs.imu.sample, 11);
    EXPECT_EQ(playback.outputs.imu.delta_angle, Eigen::Vector3d::Constant(31));
    EXPECT_NEAR(playback.outputs.imu.time, 1.1, 1e-12);
    EXPECT_EQ(playback.outputs.gnss.sample, 1);
    EXPECT_NEAR(playback.outputs.gnss.latitude, 0.3, 1e-12);
}

TEST_F(PlaybackTest, FixesInAnOutageAreWithheld) {
    Playback playback = of(file_);
    playback.parameters.gnss.outage.begin[1] = 0.5;
    playback.parameters.gnss.outage.end[1] = 3.0;
    playback.initialise(0.0);
    EXPECT_NEAR(playback.outputs.gnss.time, 3.0, 1e-12);
    run(playback, 0, 30);
    EXPECT_EQ(playback.outputs.gnss.sample, 0);
    run(playback, 30, 45);
    EXPECT_EQ(playback.outputs.gnss.sample, 2);  // of 3 s and 4 s
}

TEST_F(PlaybackTest, TheReferenceIsTheTruth) {
    for (int i = 0; i <= RecordingFile::samples; ++i) {
        const double x = i;
        file_.truth.push_back({x, x + 1, x + 2, x + 3, x + 4, x + 5, x + 6, x + 7, x + 8});
    }
    Playback playback = of(file_);
    playback.initialise(0.0);
    EXPECT_EQ(playback.outputs.truth.roll, 0.0);
    run(playback, 0, 10);
    EXPECT_EQ(playback.outputs.truth.heading, 12.0);
    EXPECT_EQ(playback.outputs.truth.velocity, Eigen::Vector3d(16.0, 17.0, 18.0));
    EXPECT_EQ(playback.outputs.truth.time, playback.outputs.imu.time);
    EXPECT_TRUE(std::isnan(playback.outputs.truth.clock_bias));
}

TEST_F(PlaybackTest, AfterTheEndAllStaysAndTheLogSaysSoOnce) {
    Playback playback = of(file_);
    playback.initialise(0.0);
    run(playback, 0, RecordingFile::samples);
    EXPECT_FALSE(playback.outputs.recording.ended);
    EXPECT_TRUE(log_.lines.empty());
    const auto last = playback.outputs;
    run(playback, RecordingFile::samples, 2 * RecordingFile::samples);
    EXPECT_TRUE(playback.outputs.recording.ended);
    EXPECT_EQ(playback.outputs.imu.sample, last.imu.sample);
    EXPECT_EQ(playback.outputs.imu.delta_angle, last.imu.delta_angle);
    EXPECT_EQ(log_.with("the recording has ended at 10 s, 1010 s of its own clock"), 1);
    EXPECT_EQ(log_.lines.size(), 1U);
}

TEST_F(PlaybackTest, AMasterMayAddUpItsSteps) {
    Playback playback = of(file_);
    playback.initialise(0.0);
    double time = 0.0;
    for (int i = 1; i <= RecordingFile::samples; ++i) {
        playback.step(time, 0.1);
        time += 0.1;
        ASSERT_EQ(playback.outputs.imu.sample, i);
    }
    EXPECT_NE(time, 10.0);  // it has rounded
}

TEST_F(PlaybackTest, ARestoredOneContinuesToTheBit) {
    Playback original = of(file_);
    original.parameters.recording.skip = 0.3;
    original.initialise(0.0);
    run(original, 0, 45, 0.07);
    const std::string state = stored(original);
    run(original, 45, 90, 0.07);
    Playback restored = of(file_);
    restore(restored, state);
    run(restored, 45, 90, 0.07);
    EXPECT_EQ(stored(restored), stored(original));
}

TEST_F(PlaybackTest, AStateOfAnotherRecordingIsRefused) {
    Playback original = of(file_);
    original.initialise(0.0);
    run(original, 0, 10);
    const std::string state = stored(original);
    file_.imu[50][2] += 1e-9;
    Playback other = of(file_);
    EXPECT_THROW(restore(other, state), std::runtime_error);
}

TEST_F(PlaybackTest, ASkippedRecordingIsRefused) {
    Playback playback = of(file_);
    playback.parameters.recording.skip = 10.0;
    try {
        playback.initialise(0.0);
        FAIL() << "accepted";
    } catch (const InvalidParameter& reason) {
        EXPECT_STREQ(reason.what(), "recording.skip = 10: must be less than 10, which the recording lasts");
    }
}

TEST_F(PlaybackTest, AnOutageThatEndsBeforeItBeginsIsRefused) {
    Playback playback = of(file_);
    playback.parameters.gnss.outage.begin[2] = 4.0;
    playback.parameters.gnss.outage.end[2] = 3.0;
    try {
        playback.initialise(0.0);
        FAIL() << "accepted";
    } catch (const InvalidParameter& reason) {
        EXPECT_STREQ(reason.what(), "gnss.outage.end[3] = 3: must be at least gnss.outage.begin[3] = 4");
    }
}

}  // namespace
}  // namespace truenorth
