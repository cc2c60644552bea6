#include "fmi/start_values.hpp"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

#include "contract/log.hpp"
#include "fmi/instance.hpp"
#include "fmi/refusal.hpp"
#include "stand_in.hpp"

namespace truenorth::test {
namespace {

using fmi::Refusal;
using fmi::StartValues;

constexpr const char* whole = "fixed 3.5\ntunable 4.5\ninput -1e-300\n";
constexpr const char* mark = ":44bc4b7686190254";

class StartValuesTest : public testing::Test {
  protected:
    // One for each test: they run at the same time.
    std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                   testing::UnitTest::GetInstance()->current_test_info()->name();

    void SetUp() override { std::filesystem::create_directories(folder); }

    void write(const std::string& text) const {
        std::ofstream(folder / "start_values.txt", std::ios::binary) << text;
    }

    void write_recording(const std::string& bytes) const {
        std::ofstream(folder / "recording.bin", std::ios::binary) << bytes;
    }

    // What is said of the file.
    [[nodiscard]] std::string refusal(const std::string& given) const {
        try {
            fmi::Instance(
                stand_in(), {.fmi_version = 2, .kind = fmi::Kind::co_simulation}, [](auto...) {}, false,
                StartValues::marked(given, folder));
        } catch (const Refusal& reason) {
            return reason.what();
        }
        return "nothing";
    }
};

double read(fmi::Instance& instance, unsigned reference) {
    double value = 0.0;
    instance.get<double>(std::array{reference}, fmi::Reach::scalar, std::span(&value, 1));
    return value;
}

TEST_F(StartValuesTest, HoldFromTheBeginningAndAfterAReset) {
    write(whole);
    fmi::Instance instance(
        stand_in(), {.fmi_version = 2, .kind = fmi::Kind::co_simulation}, [](auto...) {}, false,
        StartValues::marked(mark, folder));
    for (int life = 0; life < 2; ++life) {
        instance.enter_initialisation();
        EXPECT_EQ(read(instance, fixed), 3.5);
        EXPECT_EQ(read(instance, tunable), 4.5);
        EXPECT_EQ(read(instance, input), -1e-300);
        instance.set<double>(std::array{fixed}, fmi::Reach::scalar, std::span<const double>(std::array{9.0}));
        instance.reset();
    }
}

TEST_F(StartValuesTest, AnyChangedByteIsFound) {
    const std::string text = whole;
    for (std::size_t i = 0; i < text.size(); ++i) {
        std::string changed = text;
        changed[i] = static_cast<char>(changed[i] ^ 1);
        write(changed);
        EXPECT_NE(refusal(mark).find("is corrupt, or of another export"), std::string::npos) << changed;
    }
}

TEST_F(StartValuesTest, AnotherRecordingIsFound) {
    constexpr const char* of_both = ":50e1f2551e5b0354";
    std::string recording;
    for (int i = 0; i < 25000; ++i) {
        recording += "recorded";
    }
    write(whole);
    EXPECT_NE(refusal(of_both).find("is corrupt, or of another export"), std::string::npos);
    write_recording(recording);
    EXPECT_EQ(refusal(of_both), "nothing");
    EXPECT_NE(refusal(mark).find("is corrupt, or of another export"), std::string::npos);
    for (std::size_t i = 0; i < recording.size(); i += 9999) {
        std::string changed = recording;
        changed[i] = static_cast<char>(changed[i] ^ 1);
        write_recording(changed);
        EXPECT_NE(refusal(of_both).find("or a recording beside it is"), std::string::npos) << i;
        write_recording(recording.substr(0, i));
        EXPECT_NE(refusal(of_both).find("or a recording beside it is"), std::string::npos) << i;
    }
    // Whatever their sums make of it: signs of two numbers.
    recording[7] = static_cast<char>(recording[7] ^ 0x80);
    recording[23] = static_cast<char>(recording[23] ^ 0x80);
    write_recording(recording);
    EXPECT_NE(refusal(of_both).find("or a recording beside it is"), std::string::npos);
}

TEST_F(StartValuesTest, AFileThatIsNotThereIsMissed) {
    folder /= "nowhere";
    EXPECT_NE(refusal(mark).find("the tool must tell the FMU where its resources are"), std::string::npos);
}

TEST_F(StartValuesTest, NoMarkAsksForNoFile) {
    folder /= "nowhere";
    EXPECT_EQ(refusal(""), "nothing");
}

TEST_F(StartValuesTest, LinesThatCannotBeSetAreNamed) {
    struct Case {
        const char* text;
        const char* mark;
        const char* reason;
    };
    for (const auto& [text, mark, reason] : {
             Case{"absent 1\n", ":93e1720c9cea3c83", "there is no variable absent"},
             Case{"output 1\n", ":cdd60be52f23a157", "output is an output"},
             Case{"fixed 1x\n", ":d39662e0a4aa5068", "fixed = 1x: must be a value of its type"},
         }) {
        write(text);
        EXPECT_NE(refusal(mark).find(reason), std::string::npos) << refusal(mark);
    }
}

TEST(ResourceFolderTest, IsThatOfTheUriOrPath) {
    EXPECT_EQ(fmi::folder_of("file:///tmp/a%20b/r%C3%A9"), std::filesystem::path(u8"/tmp/a b/r\u00e9"));
    EXPECT_EQ(fmi::folder_of("file:///data/100%_runs/x"), std::filesystem::path("/data/100%_runs/x"));
    EXPECT_EQ(fmi::folder_of("file:/tmp/x"), std::filesystem::path("/tmp/x"));
    EXPECT_EQ(fmi::folder_of("file://localhost/tmp/x"), std::filesystem::path("/tmp/x"));
    EXPECT_EQ(fmi::folder_of("file:///C:/x"), std::filesystem::path("C:/x"));
    EXPECT_EQ(fmi::folder_of("/tmp/100%"), std::filesystem::path("/tmp/100%"));
    EXPECT_EQ(fmi::folder_of(""), std::filesystem::path());
}

}  // namespace
}  // namespace truenorth::test
