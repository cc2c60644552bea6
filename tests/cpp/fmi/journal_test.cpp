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
    std::vector<std::string> lines;
    Journal journal{[this](Journal::Severity severity, const char* category, const char* text) {
                        const char* prefix = severity == Journal::Severity::error ? "error " : "";
                        lines.push_back(std::string(prefix) + category + ": " + text);
                    },
                    {.errors = "errors", .events = "events", .every = "all"},
                    false};

    void enable(bool on, std::vector<std::string_view> categories = {}) { journal.enable(on, categories); }
};

TEST_F(JournalTest, EventsAreForWhoAsksAndErrorsForEverybody) {
    journal.event("a");
    journal.error("b");
    EXPECT_FALSE(journal.listens());
    enable(true, {"events"});
    EXPECT_TRUE(journal.listens());
    journal.event("100 % of %s");
    EXPECT_EQ(lines, (std::vector<std::string>{"error errors: b", "events: 100 % of %s"}));
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
