// The log of one instance: two categories, each on or off, and a sink that knows the FMI version.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "components/log.hpp"

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

    // Errors are always worth a line unless they are switched off by name; events are for who asks.
    Journal(Sink sink, const LogCategories& categories, bool events)
        : sink_(std::move(sink)), categories_(categories), events_(events) {}

    // No category: the debug log as a whole, that is, events. Throws Refusal for an unknown category.
    void enable(bool on, std::span<const std::string_view> categories);

    [[nodiscard]] bool listens() const override { return events_; }
    void event(const std::string& text) override;
    void error(const std::string& text) const;

  private:
    Sink sink_;
    LogCategories categories_;
    bool events_;
    bool errors_ = true;
};

}  // namespace truenorth::fmi
