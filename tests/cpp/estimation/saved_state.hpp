// A minimal archive: what a filter saves, as a row of numbers.
#pragma once

#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

namespace truenorth {

class SavedState {
  public:
    template <class Object>
    static std::vector<double> of(Object& object) {
        SavedState archive;
        archive(object);
        return std::move(archive.values_);
    }
    template <class Object>
    static void restore(Object& object, const std::vector<double>& values) {
        SavedState archive;
        archive.values_ = values;
        archive.loading_ = true;
        archive(object);
    }

    template <class... Values>
    void operator()(Values&... values) {
        (take(values), ...);
    }

  private:
    template <std::integral Value>
    void take(Value& value) {
        auto real = static_cast<double>(value);
        take(real);
        value = static_cast<Value>(real);
    }
    void take(double& value) {
        if (loading_) {
            value = values_.at(next_++);
        } else {
            values_.push_back(value);
        }
    }
    template <class Value>
    void take(Value& value) {
        if constexpr (requires { value.serialize(*this); }) {
            value.serialize(*this);
        } else if constexpr (requires { value.reshaped(); }) {
            for (double& component : value.reshaped()) {
                take(component);
            }
        } else {
            for (double& component : value) {
                take(component);
            }
        }
    }

    std::vector<double> values_;
    std::size_t next_ = 0;
    bool loading_ = false;
};

}  // namespace truenorth
