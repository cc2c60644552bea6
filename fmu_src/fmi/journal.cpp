#include "fmi/journal.hpp"

#include "fmi/refusal.hpp"

namespace truenorth::fmi {

void Journal::enable(bool on, std::span<const std::string_view> categories) {
    bool events = false;  // whether they are named
    bool errors = false;
    for (const std::string_view category : categories) {
        const bool every = category == categories_.every;
        if (!every && category != categories_.events && category != categories_.errors) {
            throw Refusal("there is no log category '" + std::string(category) + "'; there are " +
                          categories_.errors + ", " + categories_.events + " and " + categories_.every);
        }
        events = events || every || category == categories_.events;
        errors = errors || every || category == categories_.errors;
    }
    if (categories.empty()) {
        events_ = on;
        errors_ = on || (errors_ && off_ == Off::events);
    } else {
        events_ = on ? events : events_ && !events;
        errors_ = on ? errors : errors_ && !errors;
    }
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
