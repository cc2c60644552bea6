// The log of one instance: two categories, each on or off, and a sink that knows the FMI version.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "contract/log.hpp"

namespace truenorth::fmi {

// Names, as the model description declares them.
struct LogCategories {
    const char* errors;  // calls that were refused
    const char* events;  // what happened in a step
    const char* every;   // both
};

class Journal final : public Log {
  public:
    enum class Severity : std::uint8_t { information, error };
    using Sink = std::function<void(Severity severity, const char* category, const char* text)>;

    // What a log that is switched off leaves out. In FMI 2 it is the debug log that is switched: an error is
    // worth a line unless errors are switched off by name. FMI 3 asks to respect the switch for errors, too.
    enum class Off : std::uint8_t { events, all };

    Journal(Sink sink, const LogCategories& categories, bool on, Off off)
        : sink_(std::move(sink)),
          categories_(categories),
          off_(off),
          events_(on),
          errors_(on || off == Off::events) {}

    // On, with categories: those and no others. Off, with categories: the others stay as they are. Throws
    // Refusal for an unknown category.
    void enable(bool on, std::span<const std::string_view> categories);

    [[nodiscard]] bool listens() const override { return events_; }
    void event(const std::string& text) override;
    void error(const std::string& text) const;

  private:
    Sink sink_;
    LogCategories categories_;
    Off off_;
    bool events_;
    bool errors_;
};

}  // namespace truenorth::fmi
