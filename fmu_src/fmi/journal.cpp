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
        const bool every = category == every_category;
        if (!every && category != events_category && category != errors_category) {
            throw Refusal("there is no log category '" + std::string(category) + "'; there are " +
                          errors_category + ", " + events_category + " and " + every_category);
        }
        if (every || category == events_category) {
            events = on;
        }
        if (every || category == errors_category) {
            errors = on;
        }
    }
    events_ = events;
    errors_ = errors;
}

void Journal::event(const std::string& text) {
    if (events_) {
        sink_(Severity::information, events_category, text.c_str());
    }
}

void Journal::error(const std::string& text) const {
    if (errors_) {
        sink_(Severity::error, errors_category, text.c_str());
    }
}

}  // namespace truenorth::fmi
