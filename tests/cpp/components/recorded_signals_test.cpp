#include "components/recorded_signals.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "recording_file.hpp"

namespace truenorth {
namespace {

// Why a file is refused; empty: it is not.
std::string refusal(const std::string& content) {
    const ResourceFolder folder;
    folder.put(content);
    try {
        const RecordedSignals signals(folder.path());
        return "";
    } catch (const std::runtime_error& reason) {
        return reason.what();
    }
}

TEST(RecordedSignals, AreThoseOfTheFile) {
    const RecordingFile file;
    const ResourceFolder folder;
    folder.put(file.bytes());
    const RecordedSignals signals(folder.path());
    EXPECT_EQ(signals.begin(), 1000.0);
    EXPECT_EQ(signals.step(), 0.1);
    ASSERT_EQ(signals.imu().size(), 100U);
    EXPECT_EQ(signals.imu()[6].time, file.time(7));
    EXPECT_EQ(signals.imu()[6].delta_velocity, (recorded::Triple{-7.0, -7.0, -7.0}));
    ASSERT_EQ(signals.gnss().size(), 9U);
    EXPECT_EQ(signals.gnss()[2].shown, 31.0);
    EXPECT_EQ(signals.gnss()[2].velocity_sigma, (recorded::Triple{4.0, 5.0, 6.0}));
    EXPECT_EQ(signals.heading_aid().size(), 20U);
    EXPECT_TRUE(signals.height_aid().empty());
    EXPECT_TRUE(signals.truth().empty());
}

TEST(RecordedSignals, AFolderWithoutARecordingSaysWhatMakesOne) {
    const ResourceFolder folder;
    try {
        const RecordedSignals signals(folder.path());
        FAIL() << "read from nothing";
    } catch (const std::runtime_error& reason) {
        const std::string text = reason.what();
        EXPECT_NE(text.find("recording.bin"), std::string::npos) << text;
        EXPECT_NE(text.find("`truenorth export RECORDING`"), std::string::npos) << text;
    }
}

TEST(RecordedSignals, AnyTruncatedFileIsRefused) {
    const std::string whole = RecordingFile().bytes();
    for (std::size_t length = 0; length < whole.size(); length += length < 64 ? 1 : 37) {
        EXPECT_NE(refusal(whole.substr(0, length)).find("recording.bin: it is"), std::string::npos) << length;
    }
}

TEST(RecordedSignals, AnyChangedByteIsFound) {
    const std::string whole = RecordingFile().bytes();
    for (std::size_t place = 0; place < whole.size(); place += 11) {
        std::string changed = whole;
        changed[place] = static_cast<char>(changed[place] ^ 0x40);
        EXPECT_NE(refusal(changed), "") << place;
    }
}

struct Fault {
    const char* name;
    std::function<void(RecordingFile&)> make;
    const char* sentence;
};

class FaultyRecording : public testing::TestWithParam<Fault> {};

TEST_P(FaultyRecording, IsRefusedWithASentence) {
    RecordingFile file;
    GetParam().make(file);
    const std::string text = refusal(file.bytes());
    EXPECT_NE(text.find(GetParam().sentence), std::string::npos) << text;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultyRecording,
    testing::Values(
        Fault{"another_version", [](auto& f) { f.magic = "TNplay2\n"; }, "no recording of this version"},
        Fault{"more", [](auto& f) { f.appended = "12345678"; }, "8 bytes follow its end"},
        Fault{"no_begin", [](auto& f) { f.begin = kNaN; }, "begin = nan s"},
        Fault{"no_step", [](auto& f) { f.step = 0.0; }, "step = 0 s: must be finite, and the step greater"},
        Fault{"no_samples", [](auto& f) { f.imu.clear(); }, "it has no IMU samples"},
        Fault{"repeated_stamp", [](auto& f) { f.imu[5][1] = f.imu[4][1]; }, "must come after 1000.5 s"},
        Fault{"before_the_begin", [](auto& f) { f.imu[0][1] = 1000.0; }, "must come after 1000 s"},
        Fault{"no_stamp", [](auto& f) { f.imu[5][1] = kNaN; }, "IMU sample at nan s"},
        Fault{"negative_loss", [](auto& f) { f.imu[5][0] = -1.0; }, "-1 were missed"},
        Fault{"too_many_lost", [](auto& f) { f.imu[5][0] = 3e9; }, "not more than 32 bits count"},
        Fault{"fix_of_no_sample", [](auto& f) { f.gnss[8][0] = 101.0; }, "must be one from 82 to 100"},
        Fault{"fixes_in_disorder", [](auto& f) { f.gnss[8][0] = 3.0; }, "comes with the IMU sample 3"},
        Fault{"fix_that_is_none", [](auto& f) { f.gnss[8][1] = 0.0; }, "is the last of 0"},
        Fault{"heading_without_stamp", [](auto& f) { f.heading_aid[3][2] = kNaN; }, "heading of nan s"},
        Fault{"half_a_truth", [](auto& f) { f.truth.assign(100, std::vector<double>(9)); }, "must be 101"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace truenorth
