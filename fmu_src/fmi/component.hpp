// A component as the FMI layer sees it: scalars by reference, a clock, and its complete state as bytes.
#pragma once

#include <cereal/archives/binary.hpp>
#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <variant>

#include "components/log.hpp"
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

    // Number of scalars; their references count from 0.
    [[nodiscard]] virtual unsigned size() const = 0;
    // nullptr: there is no such reference.
    [[nodiscard]] virtual const Variable* find(unsigned reference) const = 0;

    // The reference must exist and have the type; to be set, it must not be an output.
    virtual void get(unsigned reference, double& value) const = 0;
    virtual void get(unsigned reference, int& value) const = 0;
    virtual void get(unsigned reference, bool& value) const = 0;
    virtual void set(unsigned reference, double value) = 0;
    virtual void set(unsigned reference, int value) = 0;
    virtual void set(unsigned reference, bool value) = 0;

    virtual void initialise(double start_time) = 0;
    virtual void step(double time, double size) = 0;
    // Time between two samples [s], once the parameters are set: that of the time events in model exchange.
    [[nodiscard]] virtual double sample_period() const = 0;

    virtual void save(std::ostream& stream) const = 0;
    virtual void load(std::istream& stream) = 0;

    // Lets `change` set tunable parameters; if the component refuses the result, every parameter
    // is what it was and the refusal is thrown on. Takes any callable without allocating.
    template <class Change>
    void retune(Change change) {
        retune_with(std::ref(change));
    }

  private:
    virtual void retune_with(std::function<void()> change) = 0;
};

// A component of the class C, through its generated table. It is sampled each `period` [s] unless it says
// otherwise.
template <class C>
class TabledComponent final : public Component {
  public:
    TabledComponent(std::span<const Row<C>> table, double period, Log& log)
        : table_(table), period_(period), component_(log) {}

    [[nodiscard]] unsigned size() const override { return static_cast<unsigned>(table_.size()); }

    [[nodiscard]] const Variable* find(unsigned reference) const override {
        return reference < table_.size() ? &table_[reference].variable : nullptr;
    }

    void get(unsigned reference, double& value) const override { value = read<double>(reference); }
    void get(unsigned reference, int& value) const override { value = read<int>(reference); }
    void get(unsigned reference, bool& value) const override { value = read<bool>(reference); }
    void set(unsigned reference, double value) override { write(reference, value); }
    void set(unsigned reference, int value) override { write(reference, value); }
    void set(unsigned reference, bool value) override { write(reference, value); }

    void initialise(double start_time) override { component_.initialise(start_time); }
    void step(double time, double size) override { component_.step(time, size); }

    [[nodiscard]] double sample_period() const override {
        if constexpr (requires { component_.sample_period(); }) {
            return component_.sample_period();
        } else {
            return period_;
        }
    }

    void save(std::ostream& stream) const override { cereal::BinaryOutputArchive{stream}(component_); }

    void load(std::istream& stream) override { cereal::BinaryInputArchive{stream}(component_); }

  private:
    template <class T>
    [[nodiscard]] T read(unsigned reference) const {
        return std::get<Access<C, T>>(table_[reference].access).get(component_);
    }

    template <class T>
    void write(unsigned reference, T value) {
        std::get<Access<C, T>>(table_[reference].access).set(component_, value);
    }

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

    std::span<const Row<C>> table_;
    double period_;
    C component_;
};

}  // namespace truenorth::fmi
