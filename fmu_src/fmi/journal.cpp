#include "fmi/journal.hpp"

#include "fmi/refusal.hpp"

namespace truenorth::fmi {

void Journal::enable(bool on, std::span<const std::string_view> categories) {
    bool events = events_ && !categories.empty();
    bool errors = errors_;
    if (categories.empty()) {
        events = on;
        errors = errors || on;
    }
    for (const std::string_view category : categories) {
        const bool every = category == categories_.every;
        if (!every && category != categories_.events && category != categories_.errors) {
            throw Refusal("there is no log category '" + std::string(category) + "'; there are " +
                          categories_.errors + ", " + categories_.events + " and " + categories_.every);
        }
        if (every || category == categories_.events) {
            events = on;
        }
        if (every || category == categories_.errors) {
            errors = on;
        }
    }
    events_ = events;
    errors_ = errors;
}

void Journal::event(const std::string& text) {
    if (events_) {
        sink_(Severity::information, categories_.events, text.c_str());
    }
}

void Journal::error(const std::string& text) const {
    if (errors_) {
        sink_(Severity::error, categories_.errors, text.c_str());
    }
}

}  // namespace truenorth::fmi
