#include "fmi/journal.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "fmi/refusal.hpp"

namespace truenorth::fmi {
namespace {

class JournalTest : public testing::Test {
  protected:
    explicit JournalTest(bool on = false, Journal::Off off = Journal::Off::events)
        : journal(
              [this](Journal::Severity severity, const char* category, const char* text) {
                  const char* prefix = severity == Journal::Severity::error ? "error " : "";
                  lines.push_back(std::string(prefix) + category + ": " + text);
              },
              {.errors = "errors", .events = "events", .every = "all"}, on, off) {}

    std::vector<std::string> lines;
    Journal journal;

    void enable(bool on, std::vector<std::string_view> categories = {}) { journal.enable(on, categories); }

    // What of an event and an error is told now.
    std::string told() {
        lines.clear();
        journal.event("a");
        journal.error("b");
        std::string all;
        for (const std::string& line : lines) {
            all += line + "; ";
        }
        EXPECT_EQ(journal.listens(), all.find("events") != std::string::npos);
        return all;
    }

    static constexpr const char* both = "events: a; error errors: b; ";
    static constexpr const char* events = "events: a; ";
    static constexpr const char* errors = "error errors: b; ";
    static constexpr const char* nothing = "";
};

TEST_F(JournalTest, EventsAreForWhoAsksAndErrorsForEverybody) {
    EXPECT_EQ(told(), errors);
    enable(true);
    EXPECT_EQ(told(), both);
    journal.event("100 % of %s");
    EXPECT_EQ(lines.back(), "events: 100 % of %s");
}

TEST_F(JournalTest, SwitchedOnByNameThoseAndNoOthersAreTold) {
    enable(true, {"events"});
    EXPECT_EQ(told(), events);
    enable(true, {"errors"});
    EXPECT_EQ(told(), errors);
    enable(true, {"events", "errors"});
    EXPECT_EQ(told(), both);
    enable(false, {"errors"});
    EXPECT_EQ(told(), events);
    enable(true, {"all"});
    EXPECT_EQ(told(), both);
    enable(false, {"events"});
    EXPECT_EQ(told(), errors);
    enable(false, {"all"});
    EXPECT_EQ(told(), nothing);
    enable(false);
    EXPECT_EQ(told(), nothing);
}

class SilentJournalTest : public JournalTest {
  protected:
    SilentJournalTest() : JournalTest(false, Journal::Off::all) {}
};

TEST_F(SilentJournalTest, TellsNothingUntilItIsSwitchedOn) {
    EXPECT_EQ(told(), nothing);
    enable(true, {"errors"});
    EXPECT_EQ(told(), errors);
    enable(true);
    EXPECT_EQ(told(), both);
    enable(false);
    EXPECT_EQ(told(), nothing);
}

TEST_F(JournalTest, AnUnknownCategoryChangesNothing) {
    EXPECT_THROW(enable(true, {"events", "nonsense"}), Refusal);
    EXPECT_FALSE(journal.listens());
}

TEST_F(JournalTest, SwitchingTheDebugLogOffKeepsTheErrors) {
    enable(true);
    enable(false);
    journal.event("a");
    journal.error("b");
    EXPECT_EQ(lines, std::vector<std::string>{"error errors: b"});
}

}  // namespace
}  // namespace truenorth::fmi
