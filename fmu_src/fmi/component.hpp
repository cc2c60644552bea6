// A component as the FMI layer sees it: scalars by reference, a clock, and its complete state as bytes.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "contract/log.hpp"
#include "fmi/archive.hpp"
#include "fmi/variable.hpp"

namespace truenorth::fmi {

class Component {
  public:
    Component() = default;
    Component(const Component&) = delete;
    Component(Component&&) = delete;
    Component& operator=(const Component&) = delete;
    Component& operator=(Component&&) = delete;
    virtual ~Component() = default;

    // Its scalars; a reference is the number of one, from 0.
    [[nodiscard]] std::span<const Cell> cells() const { return cells_; }

    virtual void initialise(double start_time) = 0;
    virtual void step(double time, double size) = 0;
    // Time between two samples [s], once the parameters are set: that of the time events in model exchange.
    [[nodiscard]] virtual double sample_period() const = 0;

    virtual void save(StateWriter& archive) const = 0;
    virtual void load(StateReader& archive) = 0;

    // Lets `change` set tunable parameters; if the component refuses the result, every parameter
    // is what it was and the refusal is thrown on. Takes any callable without allocating.
    template <class Change>
    void retune(Change change) {
        retune_with(std::ref(change));
    }

  protected:
    std::vector<Cell> cells_;

  private:
    virtual void retune_with(std::function<void()> change) = 0;
};

// A component of the class C, through its generated table. It is sampled each `period` [s] unless it says
// otherwise. What is given besides, its constructor takes after the log.
template <class C>
class TabledComponent final : public Component {
  public:
    template <class... Given>
    TabledComponent(std::span<const Row<C>> table, double period, Log& log, Given... given)
        : period_(period), component_(log, std::move(given)...) {
        cells_.reserve(table.size());
        for (const Row<C>& row : table) {
            cells_.push_back({.variable = row.variable, .address = row.address(component_)});
        }
    }

    void initialise(double start_time) override { component_.initialise(start_time); }
    void step(double time, double size) override { component_.step(time, size); }

    [[nodiscard]] double sample_period() const override {
        if constexpr (requires { component_.sample_period(); }) {
            return component_.sample_period();
        } else {
            return period_;
        }
    }

    void save(StateWriter& archive) const override { archive(component_); }
    void load(StateReader& archive) override { archive(component_); }

  private:
    void retune_with(std::function<void()> change) override {
        const auto before = component_.parameters;
        change();
        try {
            component_.retune();
        } catch (...) {
            component_.parameters = before;
            component_.retune();
            throw;
        }
    }

    double period_;
    C component_;
};

// What makes components of the class C. One that has Resources reads them from a folder when the first is
// made, and all share them.
template <class C>
std::function<std::unique_ptr<Component>(Log&)> maker(std::span<const Row<C>> table, double period,
                                                      const std::filesystem::path& resources) {
    if constexpr (requires { typename C::Resources; }) {
        using Resources = typename C::Resources;
        return [table, period, resources, read = std::shared_ptr<const Resources>()](Log& log) mutable {
            if (!read) {
                read = std::make_shared<const Resources>(resources);
            }
            return std::make_unique<TabledComponent<C>>(table, period, log, read);
        };
    } else {
        return [table, period](Log& log) { return std::make_unique<TabledComponent<C>>(table, period, log); };
    }
}

}  // namespace truenorth::fmi
